"""Randomizers of the scenario: colors, lights, background, and velocities that keep the objects moving."""

from collections.abc import Callable, Iterable

import numpy as np
from pxr import Gf, Sdf, Usd, UsdPhysics

import usdsdg as rep
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.object_based.config import ObjectBasedConfig
from usdsdg.session import engines
from usdsdg.stage import assets

DOME_TEXTURES = (
    "/NVIDIA/Assets/Skies/Indoor/autoshop_01_4k.hdr",
    "/NVIDIA/Assets/Skies/Indoor/carpentry_shop_01_4k.hdr",
    "/NVIDIA/Assets/Skies/Indoor/hotel_room_4k.hdr",
    "/NVIDIA/Assets/Skies/Indoor/wooden_lounge_4k.hdr",
)
BOUNCE_THICKNESS = 0.1
# Fraction of the floor area in which bodies are thrown up: just inside the walls.
BOUNCE_MARGIN = 0.99

COLORS = "randomize_shape_distractor_colors"
VELOCITIES = "randomize_floating_distractor_velocities"
LIGHTS = "randomize_lights"
BACKGROUND = "randomize_dome_background"


def add_color_randomizer(shapes: Iterable[Usd.Prim]) -> None:
    """Give every shape a random color at each event COLORS."""
    paths = [str(prim.GetPath()) for prim in shapes]
    trigger = rep.trigger.on_custom_event(event_name=COLORS)
    if paths:
        with trigger, rep.create.group(paths):
            rep.randomizer.color(colors=rep.distribution.uniform((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))


def add_velocity_randomizer(floating: Iterable[Usd.Prim]) -> None:
    """Give every floating distractor a random linear and angular velocity at each event VELOCITIES."""
    paths = [str(prim.GetPath()) for prim in floating]
    trigger = rep.trigger.on_custom_event(event_name=VELOCITIES)
    if paths:
        with trigger, rep.create.group(paths):
            rep.physics.rigid_body(
                velocity=rep.distribution.uniform((-2.5, -2.5, -2.5), (2.5, 2.5, 2.5)),
                angular_velocity=rep.distribution.uniform((-45.0, -45.0, -45.0), (45.0, 45.0, 45.0)),
            )


def add_light_randomizer(config: ObjectBasedConfig) -> None:
    """Give three sphere lights random positions, sizes, colors and intensities at each event LIGHTS."""
    high = tuple(extent / 2.0 for extent in config.working_area_size)
    low = tuple(-extent for extent in high)
    with rep.trigger.on_custom_event(event_name=LIGHTS):
        rep.create.light(
            light_type="Sphere",
            color=rep.distribution.uniform((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)),
            temperature=rep.distribution.normal(6500, 500),
            intensity=rep.distribution.normal(35000, 5000),
            position=rep.distribution.uniform(low, high),
            scale=rep.distribution.uniform(0.1, 1.0),
            count=3,
        )


def add_background_randomizer() -> None:
    """Give the dome light a random texture and rotation at each event BACKGROUND."""
    textures = [assets.resolve(url) for url in DOME_TEXTURES]
    with rep.trigger.on_custom_event(event_name=BACKGROUND):
        dome = rep.create.light(light_type="Dome")
        with dome:
            rep.modify.attribute("inputs:texture:file", rep.distribution.choice(textures))
            rep.randomizer.rotation()


def pull_to_center(prims: Iterable[Usd.Prim], draws: Draws, index: int) -> None:
    """Set velocities toward the origin that would reach it in one to ten seconds. `index` counts the calls."""
    with Sdf.ChangeBlock():
        for prim in prims:
            position = Gf.Vec3f(prim.GetAttribute("xformOp:translate").Get())
            strength = float(draws.generator(f"pull{prim.GetPath()}", index).uniform(0.1, 1.0))
            _set_velocity(prim, -position * strength)


def bounce_at_floor(stage: Usd.Stage, config: ObjectBasedConfig, draws: Draws) -> Callable[[], None]:
    """Throw bodies that have reached the floor up again after every physics step; return a function that ends this."""
    width, depth, height = config.working_area_size
    half_extent = tuple(half * BOUNCE_MARGIN for half in (width / 2.0, depth / 2.0, BOUNCE_THICKNESS / 2.0))
    origin = (0.0, 0.0, (BOUNCE_THICKNESS - height) / 2.0)
    steps = 0

    def on_step(_seconds: float) -> None:
        nonlocal steps
        hits = engines.physics().overlap_box(half_extent, origin, (0.0, 0.0, 0.0, 1.0))
        with Sdf.ChangeBlock():
            for path in dict.fromkeys(str(hit.rigid_body) for hit in hits if hit.rigid_body):
                # Camera spheres and walls overlap as well, but are not rigid bodies.
                prim = stage.GetPrimAtPath(path)
                if prim and prim.HasAPI(UsdPhysics.RigidBodyAPI):
                    speed = draws.generator(f"bounce{path}", steps).uniform((-2.0, -2.0, 4.0), (2.0, 2.0, 8.0))
                    _set_velocity(prim, speed)
        steps += 1

    return engines.subscribe_step(on_step)


def _set_velocity(prim: Usd.Prim, velocity: Gf.Vec3f | np.ndarray) -> None:
    """Set a velocity [stage units per second, world axes]; prims that are no rigid bodies are left alone."""
    attribute = prim.GetAttribute("physics:velocity")
    if attribute:
        attribute.Set(Gf.Vec3f(*(float(part) for part in velocity)))
