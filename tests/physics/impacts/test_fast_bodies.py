"""What has physxRigidBody:enableCCD passes through nothing, and costs short substeps only where something is near."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics

from tests.physics.impacts.test_small_bodies import ORDINARY, substeps
from tests.physics.scenes import add, collide, make_body, mesh, new_stage, playing, position, set_value
from tests.sampled_cases import sampled
from usdsdg import errors

HALF = 0.01  # m, of the thickness of a wall
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def _shoot(stage, *, speed, radius, continuous, count=5):
    """Balls in free flight to x = 0, in the middle of a step when they arrive, each at another time of it."""
    balls = []
    for index in range(count):
        x = -(1.5 + index / count) * speed / 60 - radius
        ball = add(stage, f"/World/ball{index}", "Sphere", at=(x, index, 0), scale=(radius,) * 3, gravity=False)
        ball.CreateAttribute("physics:velocity", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(speed, 0, 0))
        ball.CreateAttribute("physxRigidBody:enableCCD", Sdf.ValueTypeNames.Bool).Set(continuous)
        balls.append(ball)
    return balls


def _wall(stage, kind):
    points = np.array([[x, y, z] for x in (-HALF, HALF) for y in (-50, 50) for z in (-2, 2)], float)
    if kind == "sheet":
        faces = [(0, 1, 3), (0, 3, 2)]
        collide(mesh(stage, "/World/wall", points * (0, 1, 1), np.array(faces)).GetPrim(), approximation="none")
    elif kind in ("mesh", "kinematic mesh"):
        faces = [each for a, b, c, d in SIDES for each in ((a, b, c), (a, c, d))]
        wall = mesh(stage, "/World/wall", points, np.array(faces)).GetPrim()
        collide(wall, approximation="none")
        if kind == "kinematic mesh":
            UsdGeom.Xformable(wall).AddTranslateOp()
            make_body(wall)
            UsdPhysics.RigidBodyAPI(wall).CreateKinematicEnabledAttr(True)
    else:
        wall = add(stage, "/World/wall", scale=(HALF, 50, 2), body=kind == "body", gravity=False)


@pytest.mark.parametrize("kind", sampled(["box", "sheet", "mesh", "kinematic mesh", "body"], 3))
@pytest.mark.parametrize(("speed", "radius"), sampled([(90.0, 0.05), (40.0, 0.005)]))
def test_a_fast_ball_does_not_pass_a_thin_wall(kind, speed, radius):
    stage = new_stage()
    _wall(stage, kind)
    balls = _shoot(stage, speed=speed, radius=radius, continuous=True)
    playing(stage).advance(0.2)
    wall = position(stage.GetPrimAtPath("/World/wall"))[0]
    assert all(position(ball)[0] < wall for ball in balls)


def test_without_it_some_pass_as_in_physx():
    stage = new_stage()
    _wall(stage, "box")
    balls = _shoot(stage, speed=90.0, radius=0.05, continuous=False)
    playing(stage).advance(0.2)
    assert any(position(ball)[0] > 1 for ball in balls)


def test_two_balls_that_fly_at_each_other_meet():
    stage = new_stage()
    balls = []
    for x, speed in ((-1.0, 70.0), (1.13, -70.0)):
        ball = add(stage, f"/World/ball{len(balls)}", "Sphere", at=(x, 0, 0), scale=(0.03,) * 3, gravity=False)
        ball.CreateAttribute("physics:velocity", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(speed, 0, 0))
        ball.CreateAttribute("physxRigidBody:enableCCD", Sdf.ValueTypeNames.Bool).Set(True)
        balls.append(ball)
    playing(stage).advance(0.2)
    # Without restitution they stay together, in the middle between them.
    assert [position(ball)[0] for ball in balls] == pytest.approx([0.065 - 0.03, 0.065 + 0.03], abs=0.01)


def test_substeps_are_short_near_something_only():
    stage = new_stage()
    _wall(stage, "box")
    (ball,) = _shoot(stage, speed=20.0, radius=0.05, continuous=True, count=1)
    set_value(ball, "xformOp:translate", Gf.Vec3d(-5.1, 0, 0))
    counts = substeps(playing(stage), 30)
    # It arrives in the 16th step, and rests at the wall.
    assert counts[:14] == [ORDINARY] * 14
    assert max(counts[14:16]) >= 20 / 60 / 0.05
    assert counts[17:] == [ORDINARY] * 13


def test_a_fast_ball_stops_at_a_wall_that_was_moved_while_playing():
    stage = new_stage()
    _wall(stage, "box")
    (ball,) = _shoot(stage, speed=90.0, radius=0.05, continuous=True, count=1)
    engine = playing(stage)
    set_value(stage.GetPrimAtPath("/World/wall"), "xformOp:translate", Gf.Vec3d(9.4, 0, 0))
    engine.advance(0.3)
    assert position(ball)[0] == pytest.approx(9.4 - HALF - 0.05, abs=2e-3)


def test_it_is_not_named_as_unread(recwarn):
    errors.forget_warnings()
    stage = new_stage()
    _shoot(stage, speed=1.0, radius=0.05, continuous=True, count=1)
    playing(stage).advance(1 / 60)
    assert not [each for each in recwarn if "CCD" in str(each.message)]
