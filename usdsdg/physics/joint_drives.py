"""Joint drives. Mirrors `rep.physics.drive_properties`."""

from typing import Any

from pxr import Usd, UsdPhysics

from usdsdg.arguments.prims import prim_at
from usdsdg.errors import BadPrim
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.modify.numbers import draw_numbers


def drive_properties(stiffness: Any = 0.0, damping: Any = 0.0, input_prims: Any = None) -> ReplicatorItem:
    """Author the drives of every joint at or below the prims at each execution; joints without a drive get one.

    A revolute joint has an angular drive, a prismatic one a linear drive; other joints keep the drives that they have.

    Args:
        stiffness: force per distance, or torque per degree, toward the target.
        damping: force per velocity, or torque per degree per second.

    Raises:
        BadPrim: at execution, there is no joint with a drive at or below a prim.
    """
    return act("OgnDriveProperties", input_prims, attribute="drive", stiffness=stiffness, damping=damping)


def _drives(path: str) -> list[UsdPhysics.DriveAPI]:
    joints = [prim for prim in Usd.PrimRange(prim_at(path)) if prim.IsA(UsdPhysics.Joint)]
    found = [drive for joint in joints for drive in _drives_of(joint)]
    if not found:
        raise BadPrim(f"{path} has no joint with a drive at or below it; give a revolute or prismatic joint")
    return found


def _drives_of(joint: Usd.Prim) -> list[UsdPhysics.DriveAPI]:
    drives = [name.partition(":")[2] for name in joint.GetAppliedSchemas() if name.startswith("PhysicsDriveAPI:")]
    if joint.IsA(UsdPhysics.RevoluteJoint):
        drives = drives or ["angular"]
    elif joint.IsA(UsdPhysics.PrismaticJoint):
        drives = drives or ["linear"]
    return [UsdPhysics.DriveAPI.Apply(joint, drive) for drive in drives]


@action("OgnDriveProperties")
def _write_drives(node: Node, execution: int) -> None:
    stiffness, damping = (draw_numbers(role, node, execution) for role in ("stiffness", "damping"))
    for index, path in enumerate(node.prims):
        for drive in _drives(path):
            drive.CreateStiffnessAttr().Set(float(stiffness[index]))
            drive.CreateDampingAttr().Set(float(damping[index]))
