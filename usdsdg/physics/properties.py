"""Joint drives and physics materials. Mirrors `rep.physics.drive_properties` and `physics_material`."""

from __future__ import annotations

from typing import Any

from pxr import Usd, UsdPhysics, UsdShade

from usdsdg.errors import BadPrim
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.modify import prim_at
from usdsdg.modify.numbers import draw_numbers


def drive_properties(stiffness: Any = 0.0, damping: Any = 0.0, input_prims: Any = None) -> ReplicatorItem:
    """Author the drives of every joint at or below the prims at each firing; joints without a drive get one.

    A revolute joint has an angular drive, a prismatic one a linear drive; other joints keep the drives that they have.
    The schemas are for Isaac Sim and others: our own engine moves free bodies only.

    Args:
        stiffness: force per distance, or torque per degree, that pulls to the target.
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


def physics_material(
    static_friction: Any = None, dynamic_friction: Any = None, restitution: Any = None, input_prims: Any = None
) -> ReplicatorItem:
    """Author the physics material of each prim at each firing.

    A prim without one gets `<prim>/PhysicsMaterial`, bound weaker than what descendants have. A material that several
    prims share changes for all of them.

    Args:
        static_friction: coefficient, as is `dynamic_friction`.
        restitution: 0 (no bounce) to 1.
    """
    values = dict(static_friction=static_friction, dynamic_friction=dynamic_friction, restitution=restitution)
    item = act("OgnPhysicsMaterial", input_prims, attribute="physics:material", **values)
    for path in item.prims:
        _physics_material(prim_at(path))
    return item


def _physics_material(prim: Usd.Prim) -> UsdPhysics.MaterialAPI:
    material, binding = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
    if material and (material.GetPrim().HasAPI(UsdPhysics.MaterialAPI) or binding.GetName().endswith(":physics")):
        return UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    made = UsdShade.Material.Define(prim.GetStage(), prim.GetPath().AppendChild("PhysicsMaterial"))
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(made, UsdShade.Tokens.weakerThanDescendants, "physics")
    return UsdPhysics.MaterialAPI.Apply(made.GetPrim())


@action("OgnPhysicsMaterial")
def _write_physics_material(node: Node, execution: int) -> None:
    roles = [role for role in ("static_friction", "dynamic_friction", "restitution") if role in node.inputs]
    columns = {role: draw_numbers(role, node, execution) for role in roles}
    for index, path in enumerate(node.prims):
        api = _physics_material(prim_at(path))
        setters = {
            "static_friction": api.CreateStaticFrictionAttr,
            "dynamic_friction": api.CreateDynamicFrictionAttr,
            "restitution": api.CreateRestitutionAttr,
        }
        for role, column in columns.items():
            setters[role]().Set(float(column[index]))
