"""Cameras that look at labeled objects, each with a collision sphere that pushes other objects away."""

from collections.abc import Sequence
from dataclasses import dataclass

from pxr import Gf, Usd, UsdGeom, UsdPhysics

from usdsdg.errors import warn_once
from usdsdg.scenarios import rigid_bodies
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.object_based.config import ObjectBasedConfig
from usdsdg.session import engines
from usdsdg.stage.poses.xform_ops import author_pose

# Free space required around a camera [stage units]; after MAX_ATTEMPTS occupied positions the last one is used.
CLEARANCE = 0.1
MAX_ATTEMPTS = 30


@dataclass(frozen=True)
class Cameras:
    """Camera prims and their collision spheres, which collide only while space around the cameras is cleared."""

    prims: list[Usd.Prim]
    spheres: list[Usd.Prim]

    def set_colliding(self, enabled: bool) -> None:
        """Switch collisions of all spheres on or off."""
        for sphere in self.spheres:
            UsdPhysics.CollisionAPI(sphere).GetCollisionEnabledAttr().Set(enabled)


def add_cameras(stage: Usd.Stage, config: ObjectBasedConfig) -> Cameras:
    """Create `num_cameras` cameras below /World/Cameras, with the properties of the configuration."""
    prims = [stage.DefinePrim(f"/World/Cameras/cam_{index}", "Camera") for index in range(config.num_cameras)]
    for prim in prims:
        for name, value in config.camera_properties_kwargs.items():
            prim.GetAttribute(name).Set(value)
    _warn_if_targets_are_clipped(prims, config)
    radius = config.camera_collider_radius
    return Cameras(prims, [_add_sphere(prim, radius) for prim in prims] if radius > 0.0 else [])


def _warn_if_targets_are_clipped(cameras: list[Usd.Prim], config: ObjectBasedConfig) -> None:
    nearest = config.camera_distance_to_target_min_max[0]
    near = max((UsdGeom.Camera(camera).GetClippingRangeAttr().Get()[0] for camera in cameras), default=0.0)
    if nearest < round(near, 6):  # the stage stores float32
        warn_once(
            f"cameras come as near as {nearest:g} to what they look at and see nothing nearer than {near:g}, their "
            "clipping plane: add clippingRange: [0.01, 1000] to camera_properties_kwargs"
        )


def look_at_targets(
    cameras: Cameras, targets: list[Usd.Prim], config: ObjectBasedConfig, draws: Draws, index: int
) -> None:
    """Place every camera at a random distance and direction from a random target, aimed at a point near it.

    A camera inside an object would see nothing, so poses are drawn until one is free. `index` counts the calls, so
    that each of them gives different poses.
    """
    for number, camera in enumerate(cameras.prims):
        for attempt in range(MAX_ATTEMPTS):
            position, orientation = _pose(f"camera/{number}/{attempt}", index, targets, config, draws)
            if not engines.physics().overlap_sphere(CLEARANCE, position):
                break
        author_pose(camera, translate=position, orient=orientation)


def _pose(
    purpose: str, index: int, targets: list[Usd.Prim], config: ObjectBasedConfig, draws: Draws
) -> tuple[Gf.Vec3d, Gf.Quatf]:
    _, aim, distance = drawn_aim(purpose, index, targets, config, draws)
    return draws.pose_on_sphere(f"{purpose}/pose", index, aim, distance)


def drawn_aim(
    purpose: str, index: int, targets: Sequence[Usd.Prim], config: ObjectBasedConfig, draws: Draws
) -> tuple[Usd.Prim, Gf.Vec3d, float]:
    """Draw what a camera looks at: the target, a point near it, and how far from that point the camera is."""
    offset = config.camera_look_at_target_offset
    target = draws.choice(f"{purpose}/target", index, targets)
    generator = draws.generator(f"{purpose}/aim", index)
    aim = Gf.Vec3d(target.GetAttribute("xformOp:translate").Get()) + Gf.Vec3d(*generator.uniform(-offset, offset, 3))
    return target, aim, float(generator.uniform(*config.camera_distance_to_target_min_max))


def _add_sphere(camera: Usd.Prim, radius: float) -> Usd.Prim:
    path = camera.GetPath().AppendChild("CollisionSphere")
    sphere = camera.GetStage().DefinePrim(path, "Sphere")
    UsdGeom.Sphere(sphere).GetRadiusAttr().Set(radius)
    rigid_bodies.add_colliders(sphere)
    UsdPhysics.CollisionAPI(sphere).GetCollisionEnabledAttr().Set(False)
    UsdGeom.Imageable(sphere).MakeInvisible()
    return sphere
