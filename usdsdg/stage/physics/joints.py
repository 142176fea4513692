"""Joints as UsdPhysics describes them, and the links that they connect to articulations."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Usd, UsdPhysics

from usdsdg.stage.paths import at_or_below
from usdsdg.stage.poses.rotations import compose

ARTICULATION_ROOT = "PhysicsArticulationRootAPI"
WORLD = ""  # the body of a joint end that is attached to nothing

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint between two bodies; its frames coincide where its position is zero.

    Positions are angles [rad] of revolute joints and distances [stage units] of prismatic ones.
    """

    path: str
    kind: str  # "Revolute", "Prismatic", "Fixed", "Spherical", "Distance" or "" for a general one
    body0: str
    body1: str
    frame0: Array  # row-vector 4x4 from the joint's frame to body 0's, whose scale multiplies the translation
    frame1: Array
    axis: int = 0  # 0, 1, 2 for x, y, z
    lower: float = -np.inf
    upper: float = np.inf
    in_articulation: bool = True

    @property
    def is_dof(self) -> bool:
        """Whether it has a position."""
        return self.kind in ("Revolute", "Prismatic")

    @property
    def unit(self) -> float:
        """Factor from the units of UsdPhysics (degrees, stage units) to those of positions."""
        return np.pi / 180.0 if self.kind == "Revolute" else 1.0

    @property
    def drive(self) -> str:
        """The instance name of its drive and of its state."""
        return "angular" if self.kind == "Revolute" else "linear"


def is_joint(prim: Usd.Prim) -> bool:
    """Whether a prim is a joint."""
    return prim.IsA(UsdPhysics.Joint)


def read_joint(prim: Usd.Prim) -> Joint:
    """Read a joint of any type."""
    joint = UsdPhysics.Joint(prim)
    kind = str(prim.GetTypeName()).removeprefix("Physics").removesuffix("Joint")
    axis, lower, upper = 0, -np.inf, np.inf
    if kind in ("Revolute", "Prismatic"):
        typed = UsdPhysics.RevoluteJoint(prim) if kind == "Revolute" else UsdPhysics.PrismaticJoint(prim)
        axis = "XYZ".index(str(typed.GetAxisAttr().Get() or "X"))
        unit = np.pi / 180.0 if kind == "Revolute" else 1.0
        lower, upper = (float(limit.Get()) * unit for limit in (typed.GetLowerLimitAttr(), typed.GetUpperLimitAttr()))
    return Joint(
        path=str(prim.GetPath()),
        kind=kind,
        body0=_target(joint.GetBody0Rel()),
        body1=_target(joint.GetBody1Rel()),
        frame0=_frame(joint.GetLocalPos0Attr().Get(), joint.GetLocalRot0Attr().Get()),
        frame1=_frame(joint.GetLocalPos1Attr().Get(), joint.GetLocalRot1Attr().Get()),
        axis=axis,
        lower=lower,
        upper=upper,
        in_articulation=not joint.GetExcludeFromArticulationAttr().Get(),
    )


def articulated_links(roots: Iterable[str], joints: Sequence[Joint]) -> set[str]:
    """Return the bodies that joints connect, directly or not, to a joint or body at or below one of `roots`."""
    used = [joint for joint in joints if joint.in_articulation]
    links: set[str] = set()
    for root in roots:
        for joint in used:
            if at_or_below(joint.path, root) or at_or_below(joint.body0, root) or at_or_below(joint.body1, root):
                links |= {joint.body0, joint.body1}
    return _connected(links - {WORLD}, used)


def _connected(links: Collection[str], joints: Sequence[Joint]) -> set[str]:
    found, grown = set(links), True
    while grown:
        grown = False
        for joint in joints:
            ends = {joint.body0, joint.body1} - {WORLD}
            if ends & found and not ends <= found:
                found |= ends
                grown = True
    return found


def _target(relation: Usd.Relationship) -> str:
    targets = relation.GetTargets()
    return str(targets[0]) if targets else WORLD


def _frame(position: Gf.Vec3f | None, rotation: Gf.Quatf | None) -> Array:
    quat = (*rotation.GetImaginary(), rotation.GetReal()) if rotation else (0.0, 0.0, 0.0, 1.0)
    return compose(position or (0.0, 0.0, 0.0), quat)
