"""Settled start: bodies that overlap are moved apart, and come to rest near where they were put."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import UsdPhysics

from tests.physics.impacts import calm_scenes
from tests.physics.scenes import add, new_stage, playing, position
from usdsdg.errors import PhysicsError
from usdsdg_physics import NewtonEngine


def _positions(stage):
    return np.array([position(thing) for thing in calm_scenes.things(stage)])


def test_a_box_inside_another_ends_on_top_of_it_and_never_higher():
    stage = calm_scenes.overlapping_pair()
    assert playing(stage).settle() == []
    np.testing.assert_allclose(_positions(stage), [(0, 0, 0.1), (0, 0, 0.3)], atol=1e-3)


def test_sixty_bodies_at_one_place_end_in_a_heap():
    """Within six sizes of 10 cm sideways, and a second later where they were."""
    stage = calm_scenes.one_place()
    engine = playing(stage)
    assert engine.settle() == []
    settled = _positions(stage)
    assert np.linalg.norm(settled[:, :2], axis=1).max() < 0.6
    # The smallest distance of two centers is that of capsules side by side, at least 10 cm * 0.5.
    distances = np.linalg.norm(settled[:, None] - settled[None], axis=2) + np.eye(len(settled))
    assert distances.min() > 0.049
    engine.advance(1.0)
    np.testing.assert_allclose(_positions(stage), settled, atol=1e-3)


def test_what_still_moves_is_named():
    stage = new_stage()
    for name in ("falling", "other"):
        add(stage, f"/World/{name}", at=(0 if name == "other" else 5, 0, 5))
    engine = playing(stage)
    assert engine.settle(max_time=0.2) == ["/World/falling", "/World/other"]
    assert engine.settle(["/World/other"], max_time=0.2) == ["/World/other"]


def test_gravity_and_damping_are_those_of_the_stage_afterwards():
    stage = new_stage()
    add(stage, "/World/floor", at=(0, 0, -0.5), scale=(9, 9, 0.5), body=False)
    add(stage, "/World/box", at=(0, 0, 0.1))
    engine = playing(stage)
    assert engine.settle() == []
    ball = add(stage, "/World/ball", "Sphere", at=(3, 0, 6))
    UsdPhysics.RigidBodyAPI(ball).CreateVelocityAttr((0, 0, 0))
    engine.advance(1.0)
    assert position(ball)[2] == pytest.approx(6 - 9.81 / 3600 * 60 * 61 / 2, abs=2e-3)


def test_settling_needs_a_running_simulation_and_may_have_no_bodies():
    engine = NewtonEngine(new_stage(), device="cpu")
    with pytest.raises(PhysicsError, match="play"):
        engine.settle()
    engine.play()
    assert engine.settle() == []
