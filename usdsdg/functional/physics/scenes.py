"""Define PhysicsScenes, and read arguments that name one."""

from typing import Any

from pxr import Sdf, Usd, UsdPhysics

from usdsdg.arguments.prims import one_prim
from usdsdg.errors import BadPrim, warn_once
from usdsdg.functional.physics.schema_attributes import set_attributes
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.paths import prim_path
from usdsdg.stage.schemas import physx

# The PhysicsScene that `physics.rigid_body` makes where there is none.
DEFAULTS_PHYSICS_SCENE: dict[str, Any] = {
    "path": "/PhysicsScene", "enableCCD": True, "enableGPUDynamics": False, "broadphaseType": "MBP",
    "timeStepsPerSecond": 240,
}  # fmt: skip


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
    where = prim_path(DEFAULTS_PHYSICS_SCENE["path"] if path is None else str(path))
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


def take_owner(attributes: dict[str, Any], physics_scene: Any) -> Sdf.Path | None:
    """Return the path of the scene given as `simulationOwner`, which is removed from `attributes`, or `physics_scene`.

    There may be no prim at it yet, of which is warned.

    Raises:
        BadPrim: it is no path, or another kind of prim is there.
    """
    for name in ("simulationOwner", "physics:simulationOwner"):
        if (given := attributes.pop(name, None)) is not None:
            return _owner(given)
    return None if physics_scene is None else _owner(physics_scene)


def _owner(value: Any) -> Sdf.Path:
    [given] = value if isinstance(value, (list, tuple)) and len(value) == 1 else [value]
    if isinstance(given, (str, Sdf.Path)) and not current_stage().GetPrimAtPath(where := prim_path(str(given))):
        warn_once(
            f"physics_scene={str(where)!r}: there is no prim yet. Until a PhysicsScene is made there, the first one of "
            "the stage simulates the prims"
        )
        return Sdf.Path(where)
    return scene_of(value).GetPath()
