"""Define PhysicsScenes, and read arguments that name one."""

from typing import Any

from pxr import Usd, UsdPhysics

from usdsdg.arguments.prims import one_prim
from usdsdg.errors import BadPrim
from usdsdg.functional.physics.schema_attributes import set_attributes
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.paths import prim_path
from usdsdg.stage.schemas import physx


def create_physics_scene(path: Any = "/PhysicsScene", **attributes: Any) -> Usd.Prim:
    """Define a PhysicsScene, or use the one at the path, and set its attributes; return its prim.

    Attributes are those of UsdPhysics.Scene and PhysxSceneAPI, with or without the prefix: `gravityMagnitude` [stage
    units/s²], `enableCCD`, `broadphaseType`, `enableGPUDynamics`, `timeStepsPerSecond`, ... The others keep the
    fallbacks of the schemas.

    Raises:
        BadPrim: there is no such attribute, or another kind of prim is at the path.
        BadValue: an attribute does not take its value.
    """
    stage = current_stage()
    where = prim_path("/PhysicsScene" if path is None else str(path))
    existing = stage.GetPrimAtPath(where)
    if existing and existing.GetTypeName() and not existing.IsA(UsdPhysics.Scene):
        raise BadPrim(f"{where} is a {existing.GetTypeName()}, not a PhysicsScene; choose another path")
    scene = UsdPhysics.Scene.Define(stage, where).GetPrim()
    physx.PhysxSceneAPI.Apply(scene)
    set_attributes(scene, attributes, ("physxScene", "physics"))
    return scene


def scene_of(value: Any) -> Usd.Prim:
    """Return the PhysicsScene that an argument names as a prim or path (or a list with one of these).

    Raises:
        BadPrim: it is not one PhysicsScene on the stage.
    """
    scene = one_prim("physics_scene", value)
    if not scene.IsA(UsdPhysics.Scene):
        kind = scene.GetTypeName() or "prim without a type"
        raise BadPrim(
            f"{scene.GetPath()} is a {kind}, not a PhysicsScene; make one with functional.physics.create_physics_scene"
        )
    return scene


def take_owner(attributes: dict[str, Any], physics_scene: Any) -> Usd.Prim | None:
    """Return the PhysicsScene given as `simulationOwner`, which is removed from `attributes`, or `physics_scene`."""
    for name in ("simulationOwner", "physics:simulationOwner"):
        if (given := attributes.pop(name, None)) is not None:
            return scene_of(given)
    return None if physics_scene is None else scene_of(physics_scene)
