"""The capture loop against the schedule of Isaac Sim's example, with fake physics and a fake orchestrator."""

from __future__ import annotations

import signal
from contextlib import nullcontext

import pytest
from pxr import Sdf, UsdGeom, UsdPhysics

import usdsdg as rep
from usdsdg.capture.render_settings import render_mode
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.object_based import capture_loop, randomizers
from usdsdg.scenarios.object_based import job as object_based
from usdsdg.scenarios.object_based.cameras import Cameras
from usdsdg.scenarios.object_based.capture_loop import Scene
from usdsdg.scenarios.object_based.config import ObjectBasedConfig, PathTracing
from usdsdg.scenarios.object_based.objects import Bodies
from usdsdg.session import engines, stage_context
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.stage.schemas import physx
from usdsdg.writers import Writer


class Product:
    """A render product that only knows whether it is enabled."""

    def __init__(self) -> None:
        self.enabled = False
        self.hydra_texture = self

    def set_updates_enabled(self, enabled: bool) -> None:
        self.enabled = enabled


class Physics:
    """Physics that notifies step listeners and returns the overlaps that a test sets."""

    def __init__(self) -> None:
        self.advanced = 0.0
        self.overlaps = []

    def play(self, *, time: float | None = None) -> None: ...

    def stop(self) -> None: ...

    def advance(self, seconds: float, *, until: float | None = None) -> int:
        self.advanced += seconds
        current().engines.step_listeners.call(seconds)
        return 1

    def stage_unread(self):
        return nullcontext()

    def overlap_box(self, half_extent, origin, rotation_xyzw):
        self.box = (half_extent, origin)
        return self.overlaps

    def overlap_sphere(self, radius, origin):
        return []


@pytest.fixture
def physics(stage, monkeypatch):
    fake = Physics()
    monkeypatch.setattr(engines, "physics", lambda: fake)
    return fake


@pytest.fixture
def log(monkeypatch):
    """What happened, in order: events by name, captures with their settings."""
    happened = []
    monkeypatch.setattr(rep.utils, "send_og_event", lambda event_name: happened.append(event_name))

    def step(rt_subframes=-1, pause_timeline=True, delta_time=None, wait_for_render=True):
        happened.append(("capture", rt_subframes, delta_time, get_settings().get("/rtx/rendermode")))

    monkeypatch.setattr(rep.orchestrator, "step", step)
    return happened


def config(**changes) -> ObjectBasedConfig:
    asset = {"url": "/Isaac/a.usd", "label": "a"}
    return ObjectBasedConfig.model_validate({"labeled_assets_and_properties": [asset], "rt_subframes": 4, **changes})


def scene(chosen: ObjectBasedConfig) -> Scene:
    stage = stage_context.current_stage()
    target = UsdGeom.Cube.Define(stage, "/World/target").GetPrim()
    target.CreateAttribute("xformOp:translate", Sdf.ValueTypeNames.Double3).Set((0.5, 0.0, 0.0))
    UsdPhysics.RigidBodyAPI.Apply(target)
    physics_scene = UsdPhysics.Scene.Define(stage, "/PhysicsScene").GetPrim()
    physx.PhysxSceneAPI.Apply(physics_scene).GetTimeStepsPerSecondAttr().Set(60)
    camera = stage.DefinePrim("/World/Cameras/cam_0", "Camera")
    sphere = UsdGeom.Sphere.Define(stage, "/World/Cameras/cam_0/CollisionSphere").GetPrim()
    UsdPhysics.CollisionAPI.Apply(sphere).CreateCollisionEnabledAttr(False)
    return Scene(
        stage, physics_scene, Bodies(floating=[target]), Bodies(), Bodies(), Cameras([camera], [sphere]), [Product()]
    )


def test_events_fire_on_the_schedule_of_isaac_sims_example(physics, log):
    chosen = config(num_frames=60)
    assert capture_loop.capture_frames(chosen, scene(chosen), Draws(0)) == 60
    frames, events = [], []
    for entry in log:
        if isinstance(entry, tuple):
            frames.append((set(events), entry))
            events = []
        else:
            events.append(entry)
    assert len(frames) == 60
    for frame, (fired, (_, rt_subframes, delta_time, mode)) in enumerate(frames):
        expected = {
            name
            for name, every in {
                "randomize_lights": 5,
                "randomize_shape_distractor_colors": 15,
                "randomize_dome_background": 25,
                "randomize_floating_distractor_velocities": 17,
            }.items()
            if frame % every == 0
        }
        assert fired == expected
        assert (mode, delta_time) == (("PathTracing", 0.025) if frame % 5 == 0 else ("RaytracedLighting", 0.0))
        assert frame % 5 == 0 or rt_subframes == 4


def test_path_traced_frames_raise_the_physics_rate_and_restore_all_settings(physics, monkeypatch):
    chosen = config(num_frames=1, path_tracing={"every": 1, "spp": 32, "sub_frames": 8, "duration": 0.025})
    made = scene(chosen)
    rate = physx.PhysxSceneAPI(made.physics_scene).GetTimeStepsPerSecondAttr()
    keys = ("/rtx/rendermode", "/rtx/pathtracing/totalSpp", "/omni/replicator/captureMotionBlur")
    before = [get_settings().get(key) for key in keys]
    seen = []
    monkeypatch.setattr(
        rep.orchestrator, "step", lambda **_: seen.append((rate.Get(), *[get_settings().get(key) for key in keys]))
    )
    capture_loop.capture_frames(chosen, made, Draws(0))
    # Eight sub-frames in 25 ms need 320 steps a second.
    assert seen == [(pytest.approx(320.0), "PathTracing", 32, True)]
    assert rate.Get() == 60
    assert [get_settings().get(key) for key in keys] == before


def test_settings_are_restored_after_a_failure(physics, monkeypatch):
    def fail(**_):
        raise RuntimeError("no picture")

    monkeypatch.setattr(rep.orchestrator, "step", fail)
    chosen = config(num_frames=1)
    made = scene(chosen)
    with pytest.raises(RuntimeError, match="no picture"):
        capture_loop.capture_frames(chosen, made, Draws(0))
    assert get_settings().get("/rtx/rendermode") == "RaytracedLighting"
    assert physx.PhysxSceneAPI(made.physics_scene).GetTimeStepsPerSecondAttr().Get() == 60


@pytest.mark.parametrize("toggled", [True, False])
def test_render_products_are_enabled_while_capturing(physics, monkeypatch, toggled):
    chosen = config(num_frames=2, disable_render_products_between_captures=toggled)
    made = scene(chosen)
    seen = []
    monkeypatch.setattr(rep.orchestrator, "step", lambda **_: seen.append(made.render_products[0].enabled))
    capture_loop.capture_frames(chosen, made, Draws(0))
    assert seen == [toggled, toggled]
    assert made.render_products[0].enabled is False


@pytest.mark.parametrize(("seconds", "updates"), [(0.0, 1), (0.05, 4), (0.1, 7)])
def test_the_configured_time_is_simulated_between_captures(physics, log, seconds, updates):
    chosen = config(num_frames=1, num_cameras=0, simulation_duration_between_captures=seconds)
    made = scene(chosen)
    capture_loop.capture_frames(chosen, Scene(**{**vars(made), "cameras": Cameras([], [])}), Draws(0))
    # Updates of 1/60 s until more than that has passed.
    assert physics.advanced == pytest.approx(updates / 60.0)


def test_camera_spheres_collide_for_four_updates_of_every_third_frame(physics, log):
    chosen = config(num_frames=7, simulation_duration_between_captures=0.0)
    made = scene(chosen)
    enabled = UsdPhysics.CollisionAPI(made.cameras.spheres[0]).GetCollisionEnabledAttr()
    states = []
    end = engines.subscribe_step(lambda _dt: states.append(enabled.Get()))
    capture_loop.capture_frames(chosen, made, Draws(0))
    end()
    # Frames 0, 3 and 6 clear the space around cameras; one update follows every frame.
    clearing, plain = [True] * 4 + [False], [False]
    assert states == clearing + plain * 2 + clearing + plain * 2 + clearing


def test_bodies_that_reach_the_floor_are_thrown_up_again(physics):
    chosen = config(working_area_size=(4, 6, 3))
    made = scene(chosen)
    target = made.labeled.floating[0]
    end = randomizers.bounce_at_floor(made.stage, chosen, Draws(0))

    class Hit:
        def __init__(self, path: str) -> None:
            self.rigid_body = self.collision = path

    physics.overlaps = [Hit("/World/target"), Hit("/World/Cameras/cam_0/CollisionSphere")]
    physics.advance(1 / 60)
    first = target.GetAttribute("physics:velocity").Get()
    physics.advance(1 / 60)
    second = target.GetAttribute("physics:velocity").Get()
    for velocity in (first, second):
        assert abs(velocity[0]) <= 2.0
        assert abs(velocity[1]) <= 2.0
        assert 4.0 <= velocity[2] <= 8.0
    assert first != second
    assert physics.box == (
        (pytest.approx(1.98), pytest.approx(2.97), pytest.approx(0.0495)),
        (0, 0, pytest.approx(-1.45)),
    )
    assert not made.cameras.spheres[0].GetAttribute("physics:velocity")
    end()
    target.GetAttribute("physics:velocity").Set((0, 0, 0))
    physics.advance(1 / 60)
    assert target.GetAttribute("physics:velocity").Get() == (0, 0, 0)


def test_ctrl_c_finishes_the_frame_and_then_stops(physics, monkeypatch, capfd):
    captured = []

    def step(**_):
        if len(captured) == 1:
            signal.raise_signal(signal.SIGINT)
        captured.append("whole frame")

    monkeypatch.setattr(rep.orchestrator, "step", step)
    handler = signal.getsignal(signal.SIGINT)
    chosen = config(num_frames=5)
    assert capture_loop.capture_frames(chosen, scene(chosen), Draws(0)) == 2
    assert len(captured) == 2
    assert "Ctrl-C again stops at once" in capfd.readouterr().err
    assert signal.getsignal(signal.SIGINT) is handler


@pytest.fixture
def interruptible():
    """Python's own SIGINT handler, also where tests run in the background with SIGINT ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_a_second_ctrl_c_stops_at_once(physics, interruptible, monkeypatch):
    def step(**_):
        # Raised in this thread, since two signals from outside may be merged; each is handled at the next iteration.
        for _press in range(2):
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(rep.orchestrator, "step", step)
    chosen = config(num_frames=5)
    with pytest.raises(KeyboardInterrupt):
        capture_loop.capture_frames(chosen, scene(chosen), Draws(0))


@pytest.fixture
def only_the_loop(physics, monkeypatch):
    """A run without assets, objects and files."""
    monkeypatch.setattr(object_based, "check_assets", lambda config: None)
    monkeypatch.setattr(object_based, "build_scene", lambda config, draws: scene(config))
    monkeypatch.setattr(Writer, "attach", lambda self, products: None)
    monkeypatch.setattr(object_based, "add_randomizers", lambda *_: lambda: None)
    monkeypatch.setattr(capture_loop, "start_timeline", lambda: None)


def test_an_interrupted_run_says_where_its_files_are(only_the_loop, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(capture_loop, "capture_frames", lambda *_: 2)
    finished = []
    monkeypatch.setattr(rep.orchestrator, "wait_until_complete", lambda: finished.append(True))
    with pytest.raises(KeyboardInterrupt):
        object_based.run(config(num_frames=5, writer_type="PoseWriter", writer_kwargs={"output_dir": str(tmp_path)}))
    assert finished == [True]
    assert f"dataset: {tmp_path}" in capsys.readouterr().out


@pytest.mark.parametrize("none", ["num_frames", "num_cameras"])
def test_a_run_without_images_says_that_nothing_was_captured(only_the_loop, monkeypatch, capsys, tmp_path, none):
    monkeypatch.setattr(capture_loop, "capture_frames", lambda config, *_: config.num_frames)
    chosen = config(writer_type="PoseWriter", writer_kwargs={"output_dir": str(tmp_path)}, **{none: 0})
    assert object_based.run(chosen).images == 0
    printed = capsys.readouterr()
    assert "nothing was captured" in printed.err
    assert none in printed.err
    assert "dataset" not in printed.out


@pytest.mark.parametrize("settle", [False, True])
def test_everything_settles_before_the_timeline_starts_where_the_configuration_asks_for_it(
    only_the_loop, monkeypatch, settle
):
    order = []
    monkeypatch.setattr(rep.physics, "simulate_until_rest", lambda: order.append("settled"))
    monkeypatch.setattr(capture_loop, "start_timeline", lambda: order.append("started"))
    monkeypatch.setattr(capture_loop, "capture_frames", lambda config, *_: config.num_frames)
    object_based.run(config(num_frames=1, settle=settle))
    assert order == (["settled", "started"] if settle else ["started"])


def test_the_path_tracing_renderer_takes_samples_and_denoiser_of_the_configuration():
    before = {
        path: get_settings().get(path)
        for path in ("/rtx/rendermode", *capture_loop._path_tracing_settings(PathTracing()))
    }
    options = {"path_tracing": {"every": 0, "spp": 7, "denoise": True}}
    try:
        capture_loop.apply_render_settings(config(launch_config={"renderer": "PathTracing"}, **options))
        mode = render_mode(4)
        assert (mode.path_tracing, mode.samples, mode.denoise, mode.motion_blur) == (True, 7, True, False)
        capture_loop.apply_render_settings(config(**options))
        assert not render_mode(4).path_tracing
    finally:
        for path, value in before.items():
            get_settings().set(path, value)
