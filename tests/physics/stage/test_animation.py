"""Colliders and kinematic bodies that time samples or edits move, and what they carry and push."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from tests.physics.scenes import add, fallen, mesh, new_stage, physics_material, playing, position, set_value, velocity
from tests.sampled_cases import crossed
from usdsdg import errors

STEP = 1 / 60
SPEED = 0.6  # m/s


def _slide(prim, *, until=60, speed=SPEED, z=0.0):
    """Samples of a motion along x, a time code for each step of 1/60 s."""
    op = UsdGeom.Xformable(prim).GetOrderedXformOps()[0]
    for code in (0, until):
        op.Set(Gf.Vec3d(speed * code / 60, 0, z), code)


def _stage():
    stage = new_stage()
    stage.SetTimeCodesPerSecond(60)
    return stage


@pytest.mark.parametrize(("kinematic", "kind"), crossed([True, False], ["Cube", "Mesh"]))
def test_a_sampled_platform_carries_a_box(kinematic, kind):
    stage = _stage()
    material = physics_material(stage, "/World/m", friction=0.8)
    if kind == "Cube":
        platform = add(stage, "/World/platform", scale=(1, 1, 0.1), body=False, material=material)
    else:
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-0.1, 0.1)], float)
        top = [[1, 7, 3], [1, 5, 7]]
        bottom = [[0, 2, 6], [0, 6, 4]]
        platform = mesh(stage, "/World/platform", corners, np.array(top + bottom)).GetPrim()
        UsdGeom.Xformable(platform).AddTranslateOp()
        UsdPhysics.CollisionAPI.Apply(platform)
    if kinematic:
        UsdPhysics.RigidBodyAPI.Apply(platform).CreateKinematicEnabledAttr(True)
    _slide(platform)
    box = add(stage, "/World/box", at=(0, 0, 0.2), material=material)
    engine = playing(stage)
    engine.advance(30 * STEP)
    assert velocity(box) == pytest.approx([SPEED, 0, 0], abs=0.02)
    # It slips while friction accelerates it: v² / (2 mu g).
    expected = SPEED * 0.5 - SPEED**2 / (2 * 0.65 * 9.81)
    assert position(box)[0] == pytest.approx(expected, abs=0.01)
    assert engine.rigid_bodies == (("/World/platform", "/World/box") if kinematic else ("/World/box",))
    engine.stop()
    assert platform.GetAttribute("xformOp:translate").GetTimeSamples() == [0, 60]


def test_a_sampled_wall_pushes_a_box_at_its_own_speed():
    stage = _stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(9, 9, 0.1), body=False)
    wall = add(stage, "/World/wall", scale=(0.1, 1, 1), body=False)
    _slide(wall)
    box = add(stage, "/World/box", at=(0.25, 0, 0.1))
    playing(stage).advance(60 * STEP)
    assert position(box)[0] == pytest.approx(SPEED + 0.2, abs=5e-3)


def test_a_collider_follows_the_samples_of_its_parent_and_its_queries_too():
    stage = _stage()
    parent = UsdGeom.Xform.Define(stage, "/World/parent")
    parent.AddTranslateOp()
    _slide(parent.GetPrim(), until=600)
    add(stage, "/World/parent/wall", scale=(0.1, 1, 1), body=False)
    add(stage, "/World/box", at=(0, 9, 0), gravity=False)
    engine = playing(stage)
    engine.advance(60 * STEP)
    assert engine.raycast((SPEED, -5, 0), (0, 1, 0), 9).collision == "/World/parent/wall"
    assert engine.raycast((0, -5, 0), (0, 1, 0), 9) is None


def test_scenes_of_animated_colliders_alone_are_queried_without_newton():
    stage = _stage()
    wall = add(stage, "/World/wall", scale=(0.1, 1, 1), body=False)
    _slide(wall, until=600)
    engine = playing(stage)
    engine.advance(60 * STEP)
    assert engine._session.world is None
    assert [hit.collision for hit in engine.overlap_sphere(0.05, (SPEED, 0, 0))] == ["/World/wall"]


def test_time_that_goes_back_moves_nothing_with_speed():
    """At the end of a loop the platform is at its start at once, and what lies on it stays where it is."""
    stage = _stage()
    material = physics_material(stage, "/World/m", friction=0.8)
    platform = add(stage, "/World/platform", scale=(3, 1, 0.1), body=False, material=material)
    _slide(platform)
    box = add(stage, "/World/box", at=(0, 0, 0.2), material=material)
    engine = playing(stage)
    engine.advance(60 * STEP)
    before = position(box)[0]
    engine.step(STEP, until=0.0)
    assert position(box)[0] == pytest.approx(before + SPEED * STEP, abs=2e-3)


def test_a_play_begins_at_its_time():
    stage = _stage()
    platform = add(stage, "/World/platform", scale=(1, 1, 0.1), body=False)
    _slide(platform)
    box = add(stage, "/World/box", at=(SPEED, 0, 1))
    engine = playing(stage)
    engine.stop()
    engine.play(time=1.0)
    engine.advance(1.0)
    assert position(box)[2] == pytest.approx(0.2, abs=2e-3)


def test_samples_of_dynamic_bodies_are_named():
    stage = _stage()
    box = add(stage, "/World/box", at=(0, 0, 5))
    box.GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, 9), 10)
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning, match="/World/box.*kinematicEnabled"):
        engine = playing(stage)
    errors.forget_warnings()
    engine.advance(10 * STEP)
    at = box.GetAttribute("xformOp:translate").Get(Usd.TimeCode.Default())
    assert at[2] == pytest.approx(5 - fallen(10), abs=1e-3)


@pytest.mark.parametrize(
    ("name", "sample", "words"), [("scale", (2, 2, 2), "scale"), ("translate", (np.inf, 0, 0), "finite")]
)
def test_samples_that_colliders_cannot_follow_are_named(name, sample, words):
    stage = _stage()
    wall = add(stage, "/World/wall", body=False)
    box = add(stage, "/World/box", at=(0, 0, 0.2))
    op = wall.GetAttribute(f"xformOp:{name}")
    op.Set(op.Get(), 0)
    op.Set(type(op.Get())(*sample), 60)
    errors.forget_warnings()
    engine = playing(stage)
    with pytest.warns(errors.UsdsdgWarning, match=f"/World/wall: .*time samples.*{words}"):
        engine.advance(10 * STEP)
    errors.forget_warnings()
    assert position(box) == pytest.approx([0, 0, 0.2], abs=1e-3)


@pytest.mark.parametrize("turns", [False, True])
def test_a_static_collider_that_a_script_moves_carries_what_lies_on_it(turns):
    """As a kinematic one: the box slips until friction has its speed, v = 0.8 g t, less a step; then it goes along."""
    stage, speed = new_stage(), 0.6
    material = physics_material(stage, "/World/m", friction=0.8)
    platform = add(stage, "/World/platform", scale=(1, 1, 0.1), rotate=(0, 0, 0), body=False, material=material)
    at = (0.5, 0, 0.2) if turns else (0, 0, 0.2)
    box = add(stage, "/World/box", at=at, material=material)
    engine = playing(stage)
    engine.advance(30 * STEP)  # it is at rest
    for step in range(1, 61):
        if turns:
            set_value(platform, "xformOp:rotateXYZ", Gf.Vec3f(0, 0, float(np.degrees(speed * step * STEP))))
        else:
            set_value(platform, "xformOp:translate", Gf.Vec3d(speed * step * STEP, 0, 0))
        engine.step(STEP)
    slip = (0.5 if turns else 1.0) * speed
    slip = slip**2 / (2 * 0.8 * 9.81) + slip * STEP
    if turns:
        angle = np.arctan2(position(box)[1], position(box)[0])
        assert angle == pytest.approx(speed - slip / 0.5, abs=0.01)
        assert np.linalg.norm(position(box)[:2]) == pytest.approx(0.5, abs=0.01)
    else:
        assert velocity(box) == pytest.approx([speed, 0, 0], abs=0.01)
        assert position(box)[0] == pytest.approx(speed - slip, abs=0.01)
    for _ in range(60):
        engine.step(STEP)
    assert velocity(box) == pytest.approx([0, 0, 0], abs=1e-3)


def test_a_static_collider_that_is_put_elsewhere_carries_nothing():
    """A camera's collider jumps, once in a while or at every step, and shall not throw what it touches."""
    stage = new_stage()
    platform = add(stage, "/World/platform", scale=(2, 2, 0.1), body=False)
    box = add(stage, "/World/box", at=(0, 0, 0.2))
    engine = playing(stage)
    engine.advance(30 * STEP)
    for step in range(4):
        set_value(platform, "xformOp:translate", Gf.Vec3d(0.5 if step % 2 else -0.5, 0, 0))
        engine.advance(2 * STEP)
    assert position(box) == pytest.approx([0, 0, 0.2], abs=1e-4)
