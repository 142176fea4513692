"""The contact solver of CUDA, on the CPU: closed forms, stacks, and more pairs at one body than there are colors."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from unittest import mock

import numpy as np
import pytest
import warp as wp
from pxr import Usd, UsdPhysics

from tests.physics.impacts import calm_scenes, test_calm, test_rebounds, test_small_bodies, test_squeezes
from tests.physics.joints import test_locked_axes
from tests.physics.scenes import add, new_stage, physics_material, playing
from usdsdg.kernels.compilation import ModuleLoad
from usdsdg_physics import NewtonEngine
from usdsdg_physics.contact_solver.arrays import COLORS, GROUND, OVERFLOW
from usdsdg_physics.contact_solver.solver import ContactSolver
from usdsdg_physics.model import build
from usdsdg_physics.world import compile_kernels
from usdsdg_physics.world.world import World

G, STEP = 9.81, 1.0 / 60.0


@pytest.fixture(autouse=True)
def _contact_solver() -> Iterator[None]:
    with mock.patch.object(build, "has_contacts_alone", lambda built: not built.joints.trees):
        yield


def moved(stage: Usd.Stage, seconds: float) -> World:
    """Play a stage for some time, and return its world."""
    engine = playing(stage)
    engine.advance(seconds)
    assert engine._session is not None
    world = engine._session.world
    assert world is not None
    assert isinstance(world.solver, ContactSolver)
    return world


def groups(world: World) -> np.ndarray:
    assert isinstance(world.solver, ContactSolver)
    return world.solver._pairs.group_size.numpy()


def floor(stage: Usd.Stage) -> None:
    add(stage, "/World/floor", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False)


def test_things_of_all_kinds_rest_at_their_heights():
    stage = new_stage()
    floor(stage)
    for i, kind in enumerate(("Cube", "Sphere", "Cylinder", "Capsule")):
        add(stage, f"/World/{kind}", kind, at=(i, 0, 0.3))
    world = moved(stage, 2.0)
    heights = world.poses()[:, 2]
    assert heights[:3] == pytest.approx([0.1, 0.1, 0.1], abs=5e-5)
    assert (world.velocities() == 0.0).all()


def test_a_stack_of_ten_cubes_stands():
    world = moved(calm_scenes.stack(0.1), 4.0)
    poses = world.poses()
    assert np.abs(poses[:, :2]).max() < 1e-3
    assert poses[:, 2] == pytest.approx(0.1 + 0.2 * np.arange(10), abs=2e-3)


def test_a_box_slides_on_a_slope_as_friction_lets_it():
    """a = g (sin 35° - mu cos 35°); a box on a slope of less than the friction angle stays."""
    for tilt, expected in ((35.0, G * (np.sin(np.radians(35.0)) - 0.5 * np.cos(np.radians(35.0)))), (20.0, 0.0)):
        stage = new_stage()
        rubber = physics_material(stage, "/World/rubber", friction=0.5)
        up = np.array([np.sin(np.radians(tilt)), 0, np.cos(np.radians(tilt))])
        add(
            stage,
            "/World/slope",
            at=tuple(-0.5 * up),
            rotate=(0, tilt, 0),
            scale=(20, 5, 0.5),
            body=False,
            material=rubber,
        )
        add(stage, "/World/box", at=tuple(0.1 * up), rotate=(0, tilt, 0), material=rubber)
        world = moved(stage, 1.0)
        assert np.linalg.norm(world.velocities()[0, :3]) == pytest.approx(expected, rel=0.02, abs=1e-3)


def test_a_rebound_keeps_the_share_of_speed_that_restitution_says():
    impact = np.sqrt(2.0 / G)
    steps = np.ceil(impact / STEP) + 1
    world = moved(calm_scenes.rebounds(), steps * STEP)
    speed = world.velocities()[1:, 2] + G * (steps * STEP - impact)
    assert speed / np.sqrt(2.0 * G) == pytest.approx([0.5, 0.9], abs=0.03)


def test_rebounds_have_the_height_that_restitution_says():
    test_rebounds.test_a_rebound_has_the_height_that_restitution_says("Sphere", 240)


def test_a_tray_carries_more_things_than_there_are_colors():
    """A plate with 49 boxes on it, which lies on four feet that are boxes too."""
    stage = new_stage()
    floor(stage)
    add(stage, "/World/tray", at=(0, 0, 0.25), scale=(1, 1, 0.05))
    for i, (x, y) in enumerate(((-0.8, -0.8), (-0.8, 0.8), (0.8, -0.8), (0.8, 0.8))):
        add(stage, f"/World/foot_{i}", at=(x, y, 0.1))
    for i in range(49):
        add(stage, f"/World/box_{i}", at=(-0.75 + 0.25 * (i % 7), -0.75 + 0.25 * (i // 7), 0.4), scale=(0.1, 0.1, 0.1))
    world = moved(stage, 2.0)
    size = groups(world)
    assert (size[:COLORS] > 0).all()
    assert size[OVERFLOW] == 49 + 4 - COLORS
    assert size[GROUND] == 4
    poses = world.poses()
    tray, boxes = world.body_index["/World/tray"], [world.body_index[f"/World/box_{i}"] for i in range(49)]
    assert poses[tray, 2] == pytest.approx(0.25, abs=2e-3)
    assert poses[boxes, 2] == pytest.approx(0.4, abs=3e-3)
    assert np.abs(world.velocities()).max() < 0.02


def test_pairs_of_one_color_share_no_moving_body():
    world = moved(calm_scenes.bin_of(60), 1.0)
    assert isinstance(world.solver, ContactSolver)
    pairs = world.solver._pairs
    begins = pairs.group_begin.numpy()
    order, bodies = pairs.order.numpy(), np.stack([pairs.first.numpy(), pairs.second.numpy()], axis=1)
    assert begins[-1] == pairs.count.numpy()[0] > 60
    for color in range(COLORS):
        named = bodies[order[begins[color] : begins[color + 1]]].ravel()
        assert len(named) == len(np.unique(named))


def test_a_box_with_a_locked_axis_is_pushed_straight():
    """The hand's face turns it back: a turn of the sweeps that push bodies apart, of which no velocity tells."""
    test_locked_axes.test_a_box_that_may_not_tip_about_one_axis_is_pushed_without_giving_way()


def test_the_impulses_of_a_box_at_rest_bear_its_weight():
    stage = new_stage()
    floor(stage)
    box = add(stage, "/World/box", at=(0, 0, 0.1))
    box.AddAppliedSchema("PhysxContactReportAPI")
    world = moved(stage, 0.5)
    rows = world.reported_contacts()[-1]
    sign = np.where(rows.shapes[:, 0] == world.shape_index["/World/box"], 1.0, -1.0)
    assert (sign[:, None] * rows.impulse).sum(axis=0) == pytest.approx(
        [0, 0, world.mass[0] * G / 120.0], rel=1e-3, abs=1e-3
    )


def test_launches_that_are_noted_do_not_take_place():
    world: Any = moved(calm_scenes.stack(0.1, count=2), 0.1)
    steps = world._launches
    before, launch, done = world.poses(), wp.launch, []
    loaded = []
    kernels = set(compile_kernels._loaded_variants)
    with (
        mock.patch.object(compile_kernels, "_loaded_variants", set()) as found,
        mock.patch.object(ModuleLoad, "is_cached", return_value=False),
        mock.patch.object(ModuleLoad, "run", lambda load: loaded.append(load.module.name)),
    ):
        compile_kernels.load_launched_kernels(
            lambda: world.solver.step(
                steps._state, steps._next, steps._control, steps._contacts, STEP, observables=steps._observables
            ),
            world.model.device,
            progress=lambda label, count, total: done.append((count, total)),
        )
        names = {name for _, name, _ in found}
    assert {f"usdsdg_physics.contact_solver.{each}_kernels" for each in ("sweep", "rows", "pairs", "colors")} < names
    assert sorted(loaded) == sorted([*names, "usdsdg_physics.queries.overlap_kernels"])
    assert (done[0], done[-1]) == ((0, 100), (100, 100))
    assert wp.launch is launch
    assert compile_kernels._loaded_variants == kernels
    assert (world.poses() == before).all()


@pytest.mark.cuda
@pytest.mark.skipif(not wp.is_cuda_available(), reason="no CUDA device")
def test_cuda_gives_the_same_bits_twice_and_what_the_cpu_gives_in_a_short_time():
    def run(device: str, seconds: float) -> np.ndarray:
        engine = NewtonEngine(calm_scenes.bin_of(60), device=device)
        engine.play()
        engine.advance(seconds)
        assert engine._session is not None
        assert engine._session.world is not None
        return engine._session.world.poses()

    assert (run("cuda:0", 2.0) == run("cuda:0", 2.0)).all()
    assert run("cuda:0", 0.2) == pytest.approx(run("cpu", 0.2), abs=1e-3)


@pytest.mark.parametrize("heavy", [20.0, 100.0])
def test_what_is_light_carries_what_is_heavy(heavy):
    test_calm.test_a_light_cube_carries_a_heavy_one(heavy)


@pytest.mark.parametrize("masses", [(1, 11, 21, 31, 41, 51), (1, 15, 15, 15, 15, 15)])
def test_what_is_light_carries_a_stack_of_what_is_heavier(masses):
    test_calm.test_a_light_body_carries_a_stack_of_heavier_ones("Cube", masses)


def test_what_is_light_carries_what_is_heavy_beside_a_pile():
    """The tower gets sweeps of its own, and the pile, of other pairs than it has, those that it has without it."""

    def ends(tower: bool) -> tuple[np.ndarray, np.ndarray]:
        stage = new_stage()
        floor(stage)
        for i in range(40):
            at = (2 + 0.21 * (i % 4), 0.21 * (i // 4 % 4), 0.1 + 0.21 * (i // 16))
            add(stage, f"/World/box_{i:02}", at=at)
        for k in range(3 if tower else 0):
            cube = add(stage, f"/World/tower_{k}", at=(0, 0, 0.05 + 0.1 * k), scale=(0.05, 0.05, 0.05))
            UsdPhysics.MassAPI.Apply(cube).CreateMassAttr(100.0 if k == 2 else 1.0)
        poses = moved(stage, 1.0).poses()
        return poses[:40], poses[40:]

    pile, tower = ends(True)
    assert tower[:, :3] == pytest.approx(np.array([[0, 0, 0.05 + 0.1 * k] for k in range(3)]), abs=2e-3)
    assert pile == pytest.approx(ends(False)[0], abs=1e-5)


def test_what_is_light_lifts_what_is_heavy():
    test_squeezes.test_a_small_thing_lifts_one_that_is_ten_thousand_times_heavier()
    test_squeezes.test_a_plate_that_a_box_presses_into_the_floor_rises(0.6)


def test_what_rolls_over_something_small_pushes_it():
    test_small_bodies.test_one_at_rest_gets_them_again_when_something_hits_it()
