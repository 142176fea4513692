"""Small bodies get short substeps where they touch something or soon may, and only there."""

import numpy as np
import pytest
from pxr import Gf, UsdPhysics

from tests.physics.scenes import add, new_stage, playing, position, set_value

HALF = 0.005
FINE, ORDINARY = 4, 2  # substeps of a step of 1/60 s


def substeps(engine, frames):
    found = []
    for _ in range(frames):
        engine.advance(1 / 60)
        found.append(engine._session.world._latest_substeps)
    return found


def test_they_are_short_from_before_an_impact_until_the_body_is_at_rest():
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False)
    small = add(stage, "/World/small", at=(0, 0, 0.5 + HALF), scale=(HALF,) * 3)
    engine = playing(stage)
    counts = substeps(engine, 90)
    # It falls for 0.32 s, 19 steps, and is held 0.4 s after it came to rest.
    assert counts[:15] == [ORDINARY] * 15
    assert counts[17:40] == [FINE] * 23
    assert counts[60:] == [ORDINARY] * 30
    assert position(small) == pytest.approx([0, 0, HALF], abs=5e-5)


def test_one_at_rest_gets_them_again_when_something_hits_it():
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False)
    small = add(stage, "/World/small", at=(0, 0, HALF), scale=(HALF,) * 3)
    ball = add(stage, "/World/ball", "Sphere", at=(-1.0, 0, 0.1), scale=(0.1,) * 3)
    engine = playing(stage)
    assert substeps(engine, 60)[-1] == ORDINARY
    set_value(ball, "physics:velocity", Gf.Vec3f(2, 0, 0))
    counts = substeps(engine, 60)
    assert FINE in counts[20:]
    assert position(small)[0] > HALF / 2
    assert np.isfinite(position(small)).all()


def test_they_do_not_change_for_bodies_without_small_ones_near():
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False)
    add(stage, "/World/box", at=(0, 0, 0.2))
    add(stage, "/World/floats", at=(0, 0, 1.5), scale=(HALF,) * 3, gravity=False)
    assert substeps(playing(stage), 30) == [ORDINARY] * 30


@pytest.mark.parametrize("switch", ["scene", "bodies"])
def test_a_stack_stands_when_gravity_begins_to_act_while_physics_plays(switch):
    half = 0.001
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False)
    starts = np.array([[0, 0, (2 * number + 1) * half] for number in range(5)])
    stack = [
        add(stage, f"/World/cube_{number}", at=start, scale=(half,) * 3, gravity=switch == "scene")
        for number, start in enumerate(starts)
    ]
    magnitude = UsdPhysics.Scene(stage.GetPrimAtPath("/PhysicsScene")).CreateGravityMagnitudeAttr(9.81)
    if switch == "scene":
        magnitude.Set(0.0)
    engine = playing(stage)
    assert substeps(engine, 2) == [ORDINARY] * 2
    magnitude.Set(9.81)
    for cube in stack:
        set_value(cube, "physxRigidBody:disableGravity", False)
    counts = substeps(engine, 240)
    assert counts[0] == 2 * FINE
    assert [position(cube) for cube in stack] == pytest.approx(starts, abs=0.1 * half)
