"""Things that are dropped without restitution lie down, stacks stand, and what overlaps at the start is not thrown.

`python -m tests.soak physics_calm` has the same with full counts and times.
"""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from tests.physics.impacts import calm_scenes
from tests.physics.scenes import DEVICE, add, new_stage, physics_material, playing, position, set_value, velocity
from tests.sampled_cases import crossed


def _paths(stage: Usd.Stage, seconds: float) -> np.ndarray:
    """Positions of the things (steps, N, 3) of a simulation."""
    things = calm_scenes.things(stage)
    engine = playing(stage)
    found = []
    engine.subscribe_step(lambda dt: found.append([position(thing) for thing in things]))
    engine.advance(seconds)
    return np.array(found)


def _highest_after_impact(height: np.ndarray) -> float:
    """Return the largest of the heights (steps,) after the first low point."""
    low = np.flatnonzero(np.diff(height) >= 0.0)
    return float(height[low[0] if len(low) else -1 :].max())


def test_small_things_lie_down():
    """PhysX: at the 90th percentile 1.43 half sizes high after the impact, 1.72 at most; resting cubes are at 1."""
    stage = calm_scenes.small_things(20)
    sizes, starts = calm_scenes.half_sizes(stage), np.array([position(p) for p in calm_scenes.things(stage)])
    paths = _paths(stage, 2.0)
    heights = np.array([_highest_after_impact(paths[:, i, 2]) for i in range(20)]) / sizes
    assert np.percentile(heights, 90) < 1.5
    assert heights.max() < 2.0
    assert np.median(np.linalg.norm(paths[-1, :, :2] - starts[:, :2], axis=1)) < 0.005


def test_falls_from_a_height_end_on_the_floor():
    """A sphere and a box of 10 cm that arrive with 10 to 20 m/s stay within 3 mm of where they will lie."""
    paths = _paths(calm_scenes.drops(), 2.5)
    assert [_highest_after_impact(paths[:, i, 2]) for i in range(6)] == pytest.approx([0.05] * 6, abs=3e-3)


@pytest.mark.parametrize(("kind", "measured"), [("Sphere", (0.0, 0.249, 0.806)), ("Cube", (0.0, 0.246, 0.797))])
def test_rebounds_are_those_of_physx(kind, measured):
    """By the closed form e² of a meter; PhysX's (0.249 for e = 0.5) within 5 %."""
    paths = _paths(calm_scenes.rebounds(kind=kind), 1.5)
    heights = [_highest_after_impact(paths[:, i, 2]) - 0.1 for i in range(3)]
    assert heights == pytest.approx(measured, rel=0.05, abs=1e-3)


@pytest.mark.parametrize(("half", "drift"), [(0.1, 5e-3), (0.01, 1e-3), (0.001, 2e-4)])
def test_stacks_stand(half, drift):
    """Ten cubes. PhysX: 5.4 mm for cubes of 20 cm, 2.4 mm for those of 2 cm, and those of 2 mm fall over."""
    stage = calm_scenes.stack(half)
    starts = np.array([position(p) for p in calm_scenes.things(stage)])
    assert np.linalg.norm(_paths(stage, 2.0)[-1] - starts, axis=1).max() < drift


def test_a_box_inside_another_is_set_on_top_of_it():
    """PhysX throws it 12 cm above the other."""
    paths = _paths(calm_scenes.overlapping_pair(), 1.0)
    assert paths[:, 1, 2].max() < 0.301
    assert paths[-1, :, 2] == pytest.approx([0.1, 0.3], abs=1e-3)


def test_a_rolling_start_keeps_its_speed():
    """A sphere that lands obliquely with friction 0.5 slides, then rolls with 5/7 of its speed along the floor.

    Within 5 %: it turns about the point where the substep of the impact ends, up to 3 cm below the surface.
    """
    stage = calm_scenes.drops((0.8,))
    sphere = calm_scenes.things(stage)[0]
    sphere.GetAttribute("physics:velocity").Set((3.0, 0.0, 0.0))
    sphere.GetAttribute("physxRigidBody:angularDamping").Set(0.0)
    paths = _paths(stage, 1.0)
    assert (paths[-1, 0, 0] - paths[-11, 0, 0]) * 6.0 == pytest.approx(3.0 * 5.0 / 7.0, rel=0.05)


@pytest.mark.parametrize(
    ("friction", "box"),
    crossed([0.3, 0.5], [(0.05, 1.0, 0.1), (0.05, 5.0, 0.5), (0.025, 2.0, 0.5), (0.5, 2.0, 0.1)]),
)
def test_boxes_that_land_flat_slide_without_tipping(friction, box):
    half, speed, drop = box
    """The impact takes friction * impact speed, what is left v slides v² / (2 friction g); PhysX does the same."""
    stage = new_stage()
    material = physics_material(stage, "/World/material", friction=friction)
    add(stage, "/World/ground", at=(0, 0, -0.5), scale=(50, 50, 0.5), body=False, material=material)
    box = add(stage, "/World/box", at=(0, 0, half + drop), scale=(half,) * 3, material=material)
    set_value(box, "physics:velocity", Gf.Vec3f(speed, 0, 0))
    engine = playing(stage)
    tilts = []
    engine.subscribe_step(lambda dt: tilts.append(np.degrees(np.arccos(min(up(box), 1.0)))))
    engine.advance(3.0)
    left = max(speed - friction * np.sqrt(2 * 9.81 * drop), 0.0)
    expected = speed * np.sqrt(2 * drop / 9.81) + left**2 / (2 * friction * 9.81)
    assert max(tilts) < 6.0
    assert position(box) == pytest.approx([expected, 0, half], abs=0.03 * expected + speed / 120)


def test_a_ball_that_lands_rolls_on():
    """Friction spins it up to rolling at 5/7 of its speed, in the impact and after it."""
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.5), scale=(50, 50, 0.5), body=False)
    ball = add(stage, "/World/ball", "Sphere", at=(0, 0, 0.3), scale=(0.1, 0.1, 0.1))
    set_value(ball, "physics:velocity", Gf.Vec3f(1, 0, 0))
    engine = playing(stage)
    engine.advance(1.0)
    assert velocity(ball)[0] == pytest.approx(5 / 7, rel=0.03)


def test_boxes_with_enough_friction_tip_over():
    """Friction above the ratio of its half width to its half height turns a post that lands over its front edge."""
    stage = new_stage()
    material = physics_material(stage, "/World/material", friction=0.9)
    add(stage, "/World/ground", at=(0, 0, -0.5), scale=(50, 50, 0.5), body=False, material=material)
    post = add(stage, "/World/post", at=(0, 0, 0.4), scale=(0.05, 0.05, 0.3), material=material)
    set_value(post, "physics:velocity", Gf.Vec3f(3, 0, 0))
    playing(stage).advance(2.0)
    assert abs(up(post)) < 0.1


def up(prim: Usd.Prim) -> float:
    """The Z component of the direction in which its own Z axis points."""
    z = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim))[2, :3]
    return float(z[2] / np.linalg.norm(z))


@pytest.mark.parametrize("heavy", [20.0, 100.0, *([1000.0] if DEVICE == "cpu" else [])])
def test_a_light_cube_carries_a_heavy_one(heavy):
    """Cubes of 5 cm: two of 1 kg below one of `heavy`, of which PhysX loses that of 100 kg."""
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False)
    cubes = [add(stage, f"/World/cube_{k}", at=(0, 0, 0.025 + 0.05 * k), scale=(0.025,) * 3) for k in range(3)]
    for cube, mass in zip(cubes, (1.0, 1.0, heavy)):
        UsdPhysics.MassAPI.Apply(cube).CreateMassAttr(mass)
    playing(stage).advance(3.0)
    for k, cube in enumerate(cubes):
        assert position(cube) == pytest.approx([0, 0, 0.025 + 0.05 * k], abs=0.15 * 0.05)


# On CUDA only pairs of more than six times are swept again: with 5 a cube drifts by 9 mm, with 6 the stack falls.
@pytest.mark.parametrize("ratio", [3.0, 4.0, 5.0, 6.0] if DEVICE == "cpu" else [3.0, 4.0])
def test_each_carries_a_heavier_one(ratio):
    """Cubes of 20 cm; PhysX's topmost is 6 mm from its place with 4, 20 mm with 5, and falls from 5.5 on."""
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False)
    stack = [add(stage, f"/World/cube_{k}", at=(0, 0, 0.1 + 0.2 * k)) for k in range(4)]
    for k, body in enumerate(stack):
        UsdPhysics.MassAPI.Apply(body).CreateMassAttr(ratio**k)
    playing(stage).advance(4.0)
    for k, body in enumerate(stack):
        assert position(body) == pytest.approx([0, 0, 0.1 + 0.2 * k], abs=8e-3)


@pytest.mark.parametrize(
    ("masses", "kind"), crossed([(1, 11, 21, 31, 41, 51), (1, 15, 15, 15, 15, 15)], ["Cube", "Cylinder"])
)
def test_a_light_body_carries_a_stack_of_heavier_ones(kind, masses):
    """20 cm each; of the first masses PhysX's topmost cube is 14 mm from its place after 3 s."""
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False)
    stack = [add(stage, f"/World/body_{k}", kind, at=(0, 0, 0.1 + 0.2 * k)) for k in range(6)]
    for body, mass in zip(stack, masses):
        UsdPhysics.MassAPI.Apply(body).CreateMassAttr(mass)
    playing(stage).advance(3.0)
    for k, body in enumerate(stack):
        assert position(body) == pytest.approx([0, 0, 0.1 + 0.2 * k], abs=5e-3)
