"""The types of joints, and which are simulated."""

from __future__ import annotations

from pxr import Usd

from usdsdg.errors import warn_once
from usdsdg_physics.parse.attributes import has_api

ROPE = "PhysicsLimitAPI:distance"  # of a joint without a type of its own
_SUPPORTED = ("Fixed", "Revolute", "Prismatic", "Spherical", "Distance", "")


def type_of(prim: Usd.Prim) -> str:
    return str(prim.GetTypeName()).removeprefix("Physics").removesuffix("Joint")


def is_supported(prim: Usd.Prim) -> bool:
    """Return whether the type of a joint is one that can be simulated."""
    return type_of(prim) in _SUPPORTED


def is_rope(prim: Usd.Prim) -> bool:
    """Return whether a joint without a type of its own limits the distance of its ends, and nothing else."""
    if type_of(prim) or not has_api(prim, ROPE):
        return False
    found = [name for name in prim.GetAppliedSchemas() if name.startswith(("PhysicsLimitAPI:", "PhysicsDriveAPI:"))]
    if found == [ROPE]:
        return True
    warn_once(
        f"{prim.GetPath()}: limit:distance has no effect beside {', '.join(sorted({*found} - {ROPE}))}: a joint that "
        "limits the distance of its ends has no other limits and drives. Author a PhysicsDistanceJoint beside it."
    )
    return False
