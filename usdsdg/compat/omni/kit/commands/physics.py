"""Commands that add physics to prims."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Sdf, Usd, UsdPhysics, UsdShade

from usdsdg.compat.omni.kit.commands.registry import command
from usdsdg.compat.omni.physx.scripts import joints
from usdsdg.compat.physics_schema_tools import addGroundPlane
from usdsdg.errors import ArgumentError, BadPrim
from usdsdg.functional.physics import bodies, scenes
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.paths import next_free_path

AnyPath = str | Sdf.Path

_COMPONENTS = {
    "PhysicsCollisionAPI": bodies.apply_collider,
    "PhysicsRigidBodyAPI": bodies.apply_rigid_body,
}


@command("AddPhysicsScene")
def add_physics_scene(path: AnyPath, stage: Usd.Stage | None = None) -> str:
    """Define a PhysicsScene; return its path."""
    return str(scenes.create_physics_scene(str(path)).GetPath())


@command("AddGroundPlane")
def add_ground_plane(
    planePath: AnyPath,
    axis: str = "Z",
    size: float = 25.0,
    position: Sequence[float] = (0.0, 0.0, 0.0),
    color: Sequence[float] = (0.5, 0.5, 0.5),
    stage: Usd.Stage | None = None,
) -> str:
    """Define a ground plane that is seen and collides; return its path."""
    target = stage or current_stage()
    path = next_free_path(target, str(planePath), prepend_default_prim=True)
    return addGroundPlane(target, path, axis, size, position, color)


@command("AddPhysicsComponent")
def add_physics_component(usd_prim: Usd.Prim, component: str) -> None:
    """Apply "PhysicsRigidBodyAPI" or "PhysicsCollisionAPI" to a prim, with the schemas of PhysX that belong to it.

    Raises:
        ArgumentError: another component.
    """
    if component not in _COMPONENTS:
        raise ArgumentError(f"AddPhysicsComponent: {component!r} is not known; there are {', '.join(_COMPONENTS)}")
    _COMPONENTS[component](usd_prim)


@command("SetRigidBody")
def set_rigid_body(path: AnyPath, approximationShape: str = "convexHull", kinematic: bool = False) -> None:
    """Make a prim a rigid body with colliders on all geometry below it."""
    prim = _prim("SetRigidBody", path)
    bodies.apply_rigid_body(prim)
    bodies.apply_collider(prim, approximation=approximationShape)
    UsdPhysics.RigidBodyAPI(prim).CreateKinematicEnabledAttr(kinematic)


@command("SetStaticCollider")
def set_static_collider(path: AnyPath, approximationShape: str = "none") -> None:
    """Add colliders to all geometry at and below a prim."""
    bodies.apply_collider(_prim("SetStaticCollider", path), approximation=approximationShape)


@command("CreateJoint")
def create_joint(
    joint_type: str,
    from_prim: Usd.Prim | None = None,
    to_prim: Usd.Prim | None = None,
    stage: Usd.Stage | None = None,
) -> Usd.Prim:
    """Define a joint between two prims where they are, as `omni.physx.scripts.utils.createJoint`; return it."""
    return joints.createJoint(stage or current_stage(), joint_type, from_prim, to_prim)


@command("CreateJoints")
def create_joints(
    joint_type: str, paths: Sequence[AnyPath], join_to_parent: bool = False, stage: Usd.Stage | None = None
) -> list[Usd.Prim]:
    """Define a joint between each prim and its parent, or the world; return them."""
    return joints.createJoints(stage or current_stage(), joint_type, paths, join_to_parent)


@command("AddRigidBodyMaterial")
def add_rigid_body_material(
    path: AnyPath,
    density: float | None = None,
    staticFriction: float = 0.5,
    dynamicFriction: float = 0.5,
    restitution: float = 0.0,
    stage: Usd.Stage | None = None,
) -> str:
    """Define a physics material; return its path."""
    material = UsdShade.Material.Define(stage or current_stage(), str(path))
    physics = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    physics.CreateStaticFrictionAttr(staticFriction)
    physics.CreateDynamicFrictionAttr(dynamicFriction)
    physics.CreateRestitutionAttr(restitution)
    if density is not None:
        physics.CreateDensityAttr(density)
    return str(path)


@command("ApplyAPISchema")
def apply_api_schema(api: type, prim: Usd.Prim, multiple_api_token: str | None = None) -> None:
    """Apply a schema to a prim, with an instance name if it takes one."""
    api.Apply(prim, multiple_api_token) if multiple_api_token else api.Apply(prim)


@command("UnapplyAPISchema")
def unapply_api_schema(api: type, prim: Usd.Prim, multiple_api_token: str | None = None) -> None:
    """Remove a schema from a prim."""
    prim.RemoveAPI(api, multiple_api_token) if multiple_api_token else prim.RemoveAPI(api)


def _prim(caller: str, path: AnyPath) -> Usd.Prim:
    prim = current_stage().GetPrimAtPath(str(path))
    if not prim:
        raise BadPrim(f"{caller}: {path} is not on the stage")
    return prim
