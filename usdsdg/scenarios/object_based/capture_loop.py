"""Capture loop: which randomizers run at which frame, how frames are captured, how much is simulated between them."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from pxr import Usd

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.create.render_products import HydraTexture
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.interruption import stop_request
from usdsdg.scenarios.object_based import cameras as camera_steps
from usdsdg.scenarios.object_based import randomizers
from usdsdg.scenarios.object_based.aiming import Aiming
from usdsdg.scenarios.object_based.cameras import Cameras
from usdsdg.scenarios.object_based.config import ObjectBasedConfig, PathTracing
from usdsdg.scenarios.object_based.objects import Bodies
from usdsdg.session import engines
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.schemas import physx
from usdsdg.writers.journal.run import get_run

# Frames between two runs of each randomizer, and app updates while spheres clear the space around cameras.
CAMERAS_EVERY, PULL_EVERY, LIGHTS_EVERY, COLORS_EVERY = 3, 10, 5, 15
BACKGROUND_EVERY, VELOCITIES_EVERY = 25, 17
CLEARING_UPDATES = 4
WARM_UP_UPDATES = 5


@dataclass(frozen=True)
class Scene:
    """The stage and the prims that the loop acts on."""

    stage: Usd.Stage
    physics_scene: Usd.Prim
    labeled: Bodies
    shapes: Bodies
    meshes: Bodies
    cameras: Cameras
    render_products: list[HydraTexture]


def apply_render_settings(config: ObjectBasedConfig) -> None:
    """Set the render mode of `launch_config`; PathTracing takes samples and denoiser from `path_tracing`."""
    get_settings().set("/rtx/rendermode", config.launch_config.renderer)
    for path, value in _path_tracing_settings(config.path_tracing).items():
        get_settings().set(path, value)


def start_timeline() -> None:
    """Run the first randomizations and a few updates, then play the timeline without an end."""
    rep.utils.send_og_event(event_name=randomizers.COLORS)
    rep.utils.send_og_event(event_name=randomizers.BACKGROUND)
    for _ in range(WARM_UP_UPDATES):
        get_app().update()
    timeline = get_timeline()
    timeline.set_start_time(0)
    timeline.set_end_time(1_000_000)
    timeline.set_looping(False)
    timeline.play()
    timeline.commit()
    get_app().update()


def capture_frames(config: ObjectBasedConfig, scene: Scene, draws: Draws, frames: int | None = None) -> int:
    """Capture `frames` frames, None: all of the job; return how many were captured, which are fewer after Ctrl-C."""
    frames = config.num_frames if frames is None else frames
    aiming = Aiming(scene.cameras, scene.labeled.all, config, draws)
    with stop_request() as stop_requested:
        for frame in range(frames):
            _randomize(frame, config, scene, draws)
            if config.camera_aim_again:
                if frame % CAMERAS_EVERY == 0:
                    aiming.remember_places()
                _let_events_run()
                exposure = config.path_tracing.duration if _is_path_traced(frame, config) else 0.0
                aiming.aim(scene.stage, frame, exposure=exposure)
            _capture(frame, config, scene)
            if stop_requested():
                return frame + 1
            if get_run().is_over:
                return frames
            _simulate_between(config.simulation_duration_between_captures)
    return frames


def _randomize(frame: int, config: ObjectBasedConfig, scene: Scene, draws: Draws) -> None:
    if frame % CAMERAS_EVERY == 0 and scene.cameras.prims:
        camera_steps.look_at_targets(scene.cameras, scene.labeled.all, config, draws, frame // CAMERAS_EVERY)
        _clear_space_around(scene.cameras)
    if frame % PULL_EVERY == 0:
        bodies = [*scene.labeled.all, *scene.shapes.all, *scene.meshes.all]
        randomizers.pull_to_center(bodies, draws, frame // PULL_EVERY)
    for period, event in (
        (LIGHTS_EVERY, randomizers.LIGHTS),
        (COLORS_EVERY, randomizers.COLORS),
        (BACKGROUND_EVERY, randomizers.BACKGROUND),
        (VELOCITIES_EVERY, randomizers.VELOCITIES),
    ):
        if frame % period == 0:
            rep.utils.send_og_event(event_name=event)


def _clear_space_around(cameras: Cameras) -> None:
    """Let the cameras' spheres collide for a few updates, so that nothing is directly in front of a camera."""
    if not cameras.spheres:
        return
    cameras.set_colliding(True)
    get_timeline().play()
    with engines.physics().stage_unread():
        for _ in range(CLEARING_UPDATES):
            get_app().update()
    cameras.set_colliding(False)


def _let_events_run() -> None:
    """Update once, so that what was randomized, such as lights, is where it will be in the image."""
    get_timeline().play()
    get_app().update()


def _is_path_traced(frame: int, config: ObjectBasedConfig) -> bool:
    period = config.path_tracing.every
    return bool(period) and frame % period == 0


def _capture(frame: int, config: ObjectBasedConfig, scene: Scene) -> None:
    toggled = scene.render_products if config.disable_render_products_between_captures else []
    set_updates(toggled, True)
    if _is_path_traced(frame, config):
        _capture_path_traced(config.path_tracing, scene.physics_scene)
    else:
        rep.orchestrator.step(delta_time=0.0, rt_subframes=config.rt_subframes, pause_timeline=False)
    set_updates(toggled, False)


def set_updates(render_products: list[HydraTexture], enabled: bool) -> None:
    """Switch updates of render products on or off."""
    for product in render_products:
        product.hydra_texture.set_updates_enabled(enabled)


def _capture_path_traced(options: PathTracing, physics_scene: Usd.Prim) -> None:
    """Capture one exposure of `duration` seconds, with at least one physics step per sub-frame."""
    wanted = {
        "/omni/replicator/captureMotionBlur": True,
        "/omni/replicator/pathTracedMotionBlurSubSamples": options.sub_frames,
        "/rtx/rendermode": "PathTracing",
        **_path_tracing_settings(options),
    }
    with _temporary_settings(wanted), _minimum_physics_rate(physics_scene, options.sub_frames / options.duration):
        get_timeline().play()
        rep.orchestrator.step(delta_time=options.duration, pause_timeline=False)


def _path_tracing_settings(options: PathTracing) -> dict[str, object]:
    return {
        "/rtx/pathtracing/spp": options.spp,
        "/rtx/pathtracing/totalSpp": options.spp,
        "/rtx/pathtracing/optixDenoiser/enabled": options.denoise,
    }


@contextmanager
def _temporary_settings(wanted: dict[str, object]) -> Iterator[None]:
    settings = get_settings()
    before = {path: settings.get(path) for path in wanted}
    for path, value in wanted.items():
        settings.set(path, value)
    try:
        yield
    finally:
        for path, value in before.items():
            settings.set(path, value)


@contextmanager
def _minimum_physics_rate(physics_scene: Usd.Prim, minimum: float) -> Iterator[None]:
    """Raise the steps per second temporarily where bodies would not move in every sub-frame."""
    rate = physx.PhysxSceneAPI(physics_scene).GetTimeStepsPerSecondAttr()
    before = rate.Get()
    if minimum > before:
        rate.Set(minimum)
    try:
        yield
    finally:
        rate.Set(before)


def _simulate_between(seconds: float) -> None:
    """Update until more than `seconds` of simulation have passed; at least one update."""
    timeline = get_timeline()
    timeline.play()
    start = timeline.get_current_time()
    with engines.physics().stage_unread():
        while True:
            get_app().update()
            if timeline.get_current_time() - start > seconds:
                return
