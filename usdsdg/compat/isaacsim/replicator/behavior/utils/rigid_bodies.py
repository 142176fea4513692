"""Rigid bodies, colliders and physics materials, as behaviors author them."""

from __future__ import annotations

from pxr import Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg.stage.schemas import physx


def create_physics_material(
    stage: Usd.Stage, prim_path: str, restitution: float, static_friction: float, dynamic_friction: float
) -> UsdShade.Material:
    """Define a material with the friction and restitution of physics."""
    material = UsdShade.Material.Define(stage, prim_path)
    physics = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    physics.CreateRestitutionAttr(restitution)
    physics.CreateStaticFrictionAttr(static_friction)
    physics.CreateDynamicFrictionAttr(dynamic_friction)
    return material


def add_colliders(
    prim: Usd.Prim, approximation_type: str = "convexHull", physics_scene: UsdPhysics.Scene | None = None
) -> None:
    """Make every gprim at or below `prim` an enabled collider; the approximation is that of its meshes."""
    for gprim in (each for each in Usd.PrimRange(prim) if each.IsA(UsdGeom.Gprim)):
        collision = UsdPhysics.CollisionAPI.Apply(gprim)
        collision.CreateCollisionEnabledAttr().Set(True)
        if physics_scene:
            collision.CreateSimulationOwnerRel().AddTarget(physics_scene.GetPath())
        if gprim.IsA(UsdGeom.Mesh):
            UsdPhysics.MeshCollisionAPI.Apply(gprim).CreateApproximationAttr(approximation_type)


def disable_colliders(prim: Usd.Prim, include_descendants: bool = True) -> None:
    """Switch off the colliders at `prim` and, by default, below it."""
    for each in Usd.PrimRange(prim) if include_descendants else [prim]:
        if each.HasAPI(UsdPhysics.CollisionAPI):
            UsdPhysics.CollisionAPI(each).CreateCollisionEnabledAttr().Set(False)


def add_rigid_body_dynamics(
    prim: Usd.Prim,
    physics_scene: UsdPhysics.Scene | None = None,
    disable_gravity: bool = False,
    angular_damping: float | None = None,
    linear_damping: float | None = None,
) -> None:
    """Make a prim an enabled rigid body; damping in 1/s, None for what is authored or the default."""
    body = UsdPhysics.RigidBodyAPI.Apply(prim)
    body.CreateRigidBodyEnabledAttr().Set(True)
    if physics_scene:
        body.CreateSimulationOwnerRel().AddTarget(physics_scene.GetPath())
    extra = physx.PhysxRigidBodyAPI.Apply(prim)  # pyright: ignore[reportAttributeAccessIssue]
    extra.CreateDisableGravityAttr().Set(disable_gravity)
    if angular_damping is not None:
        extra.CreateAngularDampingAttr().Set(angular_damping)
    if linear_damping is not None:
        extra.CreateLinearDampingAttr().Set(linear_damping)


def disable_rigid_body_dynamics(prim: Usd.Prim, include_descendants: bool = True) -> None:
    """Switch off the rigid bodies at `prim` and, by default, below it."""
    for each in Usd.PrimRange(prim) if include_descendants else [prim]:
        if each.HasAPI(UsdPhysics.RigidBodyAPI):
            UsdPhysics.RigidBodyAPI(each).CreateRigidBodyEnabledAttr().Set(False)
