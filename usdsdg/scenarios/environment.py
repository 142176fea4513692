"""The stage around the objects: an environment or an empty stage, collision walls, and the physics scene."""

from pxr import Sdf, Usd, UsdGeom

from usdsdg.scenarios import rigid_bodies
from usdsdg.session import stage_context
from usdsdg.stage import assets
from usdsdg.stage.physics.scenes import needed_physics_scene
from usdsdg.stage.poses.xform_ops import author_pose
from usdsdg.stage.schemas import physx
from usdsdg.stage.semantics import labels

WALL_THICKNESS = 0.5
PHYSICS_RATE = 60.0


def open_environment(env_url: str) -> Usd.Stage:
    """Open a stage and remove all of its labels, or create an empty one with an oblique distant light."""
    if env_url:
        stage = stage_context.open_stage(assets.resolve(env_url))
        for prim in stage.GetPseudoRoot().GetChildren():
            labels.remove_labels(prim, recursive=True)
        return stage
    stage = stage_context.new_stage()
    light = stage.DefinePrim("/World/Lights/DistantLight", "DistantLight")
    light.CreateAttribute("inputs:intensity", Sdf.ValueTypeNames.Float).Set(400.0)
    author_pose(light, rotate_xyz=(0, 60, 0))
    return stage


def add_walls(stage: Usd.Stage, size: tuple[float, float, float]) -> None:
    """Enclose the working area in six invisible walls, so that nothing leaves it; they extend outward."""
    for axis, names in enumerate((("left_wall", "right_wall"), ("back_wall", "front_wall"), ("floor", "ceiling"))):
        for name, side in zip(names, (-1.0, 1.0)):
            extents, position = list(size), [0.0, 0.0, 0.0]
            extents[axis] = WALL_THICKNESS
            position[axis] = side * (size[axis] + WALL_THICKNESS) / 2.0
            wall = stage.DefinePrim(f"/World/CollisionWalls/{name}", "Cube")
            # The default size of a Cube is 2 units.
            author_pose(wall, translate=position, scale=[extent / 2.0 for extent in extents])
            rigid_bodies.add_colliders(wall)
            UsdGeom.Imageable(wall).MakeInvisible()


def add_physics_scene(stage: Usd.Stage) -> Usd.Prim:
    """Return the stage's physics scene, created at /PhysicsScene if it has none, with 60 steps per second."""
    scene = needed_physics_scene(stage)
    physx.PhysxSceneAPI.Apply(scene).GetTimeStepsPerSecondAttr().Set(PHYSICS_RATE)
    return scene
