"""What turns a prim into a collider or a rigid body."""

from __future__ import annotations

from pxr import Usd, UsdGeom, UsdPhysics

from usdsdg.errors import warn_once
from usdsdg.stage.schemas import physx


def add_colliders(root: Usd.Prim) -> None:
    """Make every gprim at or below `root` collide, meshes through their convex hull."""
    for prim in Usd.PrimRange(root):
        if not prim.IsA(UsdGeom.Gprim):
            continue
        UsdPhysics.CollisionAPI.Apply(prim).CreateCollisionEnabledAttr(True)
        offsets = physx.PhysxCollisionAPI.Apply(prim)
        offsets.CreateContactOffsetAttr(0.001)
        offsets.CreateRestOffsetAttr(0.0)
        if prim.IsA(UsdGeom.Mesh):
            UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(UsdPhysics.Tokens.convexHull)


def add_rigid_body(prim: Usd.Prim, *, floating: bool) -> None:
    """Let physics move a prim and all below it; `floating` takes gravity off. Warns where nothing can collide."""
    if not any(below.HasAPI(UsdPhysics.CollisionAPI) for below in Usd.PrimRange(prim)):
        warn_once(f"{prim.GetPath()} has no geometry that could collide, so it stays where it is; check its asset")
        return
    UsdPhysics.RigidBodyAPI.Apply(prim).CreateRigidBodyEnabledAttr(True)
    physx.PhysxRigidBodyAPI.Apply(prim).GetDisableGravityAttr().Set(floating)
