"""Make prims of a scenario colliders and rigid bodies."""

from pxr import Usd, UsdPhysics

from usdsdg.errors import warn_once
from usdsdg.stage.physics.rigid_bodies import (
    apply_collision_schemas,
    apply_rigid_body_schemas,
    gprims_below,
    set_approximation,
)
from usdsdg.stage.schemas import physx


def add_colliders(root: Usd.Prim, approximation: str = UsdPhysics.Tokens.convexHull) -> None:
    """Make every gprim at or below `root` a collider, meshes through an approximation, by default their convex hull."""
    for prim in gprims_below(root):
        apply_collision_schemas(prim)
        UsdPhysics.CollisionAPI(prim).CreateCollisionEnabledAttr(True)
        offsets = physx.PhysxCollisionAPI(prim)
        offsets.CreateContactOffsetAttr(0.001)
        offsets.CreateRestOffsetAttr(0.0)
        set_approximation(prim, approximation)


def add_rigid_body(prim: Usd.Prim, *, floating: bool) -> None:
    """Make a prim a rigid body; `floating` switches its gravity off. Warns where no collider is at or below it."""
    if not any(below.HasAPI(UsdPhysics.CollisionAPI) for below in Usd.PrimRange(prim)):
        warn_once(f"{prim.GetPath()} has no geometry that could collide, so it stays where it is; check its asset")
        return
    apply_rigid_body_schemas(prim).CreateRigidBodyEnabledAttr(True)
    physx.PhysxRigidBodyAPI(prim).GetDisableGravityAttr().Set(floating)
