"""What changes between captures: colours, lights, background, and pushes that keep the objects moving."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from pxr import Gf, Usd, UsdPhysics

import usdsdg as rep
from usdsdg.scenarios.config import ObjectBasedConfig
from usdsdg.scenarios.draws import Draws
from usdsdg.session import engines
from usdsdg.stage import assets

DOME_TEXTURES = (
    "/NVIDIA/Assets/Skies/Indoor/autoshop_01_4k.hdr",
    "/NVIDIA/Assets/Skies/Indoor/carpentry_shop_01_4k.hdr",
    "/NVIDIA/Assets/Skies/Indoor/hotel_room_4k.hdr",
    "/NVIDIA/Assets/Skies/Indoor/wooden_lounge_4k.hdr",
)
BOUNCE_THICKNESS = 0.1
# Just inside the walls.
BOUNCE_MARGIN = 0.99

COLORS = "randomize_shape_distractor_colors"
VELOCITIES = "randomize_floating_distractor_velocities"
LIGHTS = "randomize_lights"
BACKGROUND = "randomize_dome_background"


def on_colors(shapes: Iterable[Usd.Prim]) -> None:
    """On the event COLORS every shape gets a colour of its own."""
    paths = [str(prim.GetPath()) for prim in shapes]
    trigger = rep.trigger.on_custom_event(event_name=COLORS)
    if paths:
        with trigger, rep.create.group(paths):
            rep.randomizer.color(colors=rep.distribution.uniform((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))


def on_velocities(floating: Iterable[Usd.Prim]) -> None:
    """On the event VELOCITIES every floating distractor gets a push and a spin."""
    paths = [str(prim.GetPath()) for prim in floating]
    trigger = rep.trigger.on_custom_event(event_name=VELOCITIES)
    if paths:
        with trigger, rep.create.group(paths):
            rep.physics.rigid_body(
                velocity=rep.distribution.uniform((-2.5, -2.5, -2.5), (2.5, 2.5, 2.5)),
                angular_velocity=rep.distribution.uniform((-45.0, -45.0, -45.0), (45.0, 45.0, 45.0)),
            )


def on_lights(config: ObjectBasedConfig) -> None:
    """On the event LIGHTS three sphere lights in the working area change place, size, colour and strength."""
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


def on_background() -> None:
    """On the event BACKGROUND the dome light shows another room, turned any way."""
    textures = [assets.resolve(url) for url in DOME_TEXTURES]
    with rep.trigger.on_custom_event(event_name=BACKGROUND):
        dome = rep.create.light(light_type="Dome")
        with dome:
            rep.modify.attribute("inputs:texture:file", rep.distribution.choice(textures))
            rep.randomizer.rotation()


def pull_to_centre(prims: Iterable[Usd.Prim], draws: Draws, index: int) -> None:
    """Send every prim towards the origin, to be there in one to ten seconds. `index` counts the calls."""
    for prim in prims:
        position = Gf.Vec3f(prim.GetAttribute("xformOp:translate").Get())
        strength = float(draws.generator(f"pull{prim.GetPath()}", index).uniform(0.1, 1.0))
        _set_velocity(prim, -position * strength)


def bounce_at_floor(stage: Usd.Stage, config: ObjectBasedConfig, draws: Draws) -> Callable[[], None]:
    """After every physics step throw whatever has reached the floor up again; returns what ends it."""
    width, depth, height = config.working_area_size
    half_extent = tuple(half * BOUNCE_MARGIN for half in (width / 2.0, depth / 2.0, BOUNCE_THICKNESS / 2.0))
    origin = (0.0, 0.0, (BOUNCE_THICKNESS - height) / 2.0)
    steps = 0

    def on_step(_seconds: float) -> None:
        nonlocal steps
        hits = engines.physics().overlap_box(half_extent, origin, (0.0, 0.0, 0.0, 1.0))
        for path in dict.fromkeys(str(hit.rigid_body) for hit in hits if hit.rigid_body):
            # Camera spheres and walls overlap as well, but are no bodies.
            prim = stage.GetPrimAtPath(path)
            if prim and prim.HasAPI(UsdPhysics.RigidBodyAPI):
                speed = draws.generator(f"bounce{path}", steps).uniform((-2.0, -2.0, 4.0), (2.0, 2.0, 8.0))
                _set_velocity(prim, speed)
        steps += 1

    return engines.subscribe_step(on_step)


def _set_velocity(prim: Usd.Prim, velocity: Gf.Vec3f | np.ndarray) -> None:
    """Metres per second along world axes; nothing happens to a prim that is no rigid body."""
    attribute = prim.GetAttribute("physics:velocity")
    if attribute:
        attribute.Set(Gf.Vec3f(*(float(part) for part in velocity)))
