"""Bodies that spin in free flight, against Euler's equations of a body that nothing turns."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdPhysics
from scipy.spatial.transform import Rotation

from tests.physics.mechanisms import cross_matrix, rotation, runge_kutta
from tests.physics.scenes import add, new_stage, playing, position

STEP = 1 / 60
HALF = np.array([0.05, 0.1, 0.15])
INERTIA = ((HALF**2).sum() - HALF**2) / 3.0  # of a box of 1 kg


def _spinning(spin, *, damping=0.0):
    """A stage with a box that turns at `spin` [rad/s] about its axes, which are those of the world."""
    stage = new_stage()
    box = add(stage, "/World/box", at=(0, 0, 1), scale=tuple(HALF), gravity=False, angular_damping=damping)
    UsdPhysics.MassAPI.Apply(box).CreateMassAttr(1.0)
    UsdPhysics.RigidBodyAPI(box).CreateAngularVelocityAttr(Gf.Vec3f(*np.degrees(spin).tolist()))
    return stage, box


def _spin(box):
    return np.radians(np.array(box.GetAttribute("physics:angularVelocity").Get()))


def _exact(spin, seconds, steps=6000):
    """The rotation (3, 3) after some time, columns are the axes of the body, with Runge and Kutta's steps."""

    def change(turn, omega):
        return turn @ cross_matrix(omega), -np.cross(omega, INERTIA * omega) / INERTIA

    *_, (turn, _) = runge_kutta(change, np.eye(3), np.array(spin, float), seconds, steps)
    return turn


def _angle(first, second):
    """Degrees between two rotations."""
    return float(np.degrees(Rotation.from_matrix(first @ second.T).magnitude()))


def test_a_body_turns_by_its_angular_velocity_times_the_time():
    """At 90 rad/s it turned by 86 rad in a second."""
    stage, box = _spinning((90.0, 0.0, 0.0))
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    assert _angle(rotation(box).T, Rotation.from_rotvec((90.0, 0, 0)).as_matrix()) < 0.1
    assert position(box) == pytest.approx([0, 0, 1], abs=1e-5)


@pytest.mark.parametrize("spin", [(0.4, 20.0, 0.2), (16.0, 9.6, 8.0)])
def test_a_body_that_tumbles_keeps_its_angular_momentum(spin):
    """About the axis of the middle moment, where it flips over and over, and about none of its axes.

    Its angular momentum swayed by 5 %, and it was up to 4 degrees from where it belongs after a second.
    """
    stage, box = _spinning(spin)
    engine, kept = playing(stage), INERTIA * spin
    for _ in range(60):
        engine.step(STEP)
        axes = rotation(box)
        momentum = (INERTIA * (axes @ _spin(box))) @ axes
        assert momentum == pytest.approx(kept, abs=3e-3 * float(np.linalg.norm(kept)))
    own = rotation(box) @ _spin(box)
    assert own @ (INERTIA * own) == pytest.approx(float(np.array(spin) @ kept), rel=1e-3)
    assert _angle(rotation(box).T, _exact(spin, 1.0)) < 1.0


def test_torque_and_damping_act_on_a_body_that_spins():
    """About a main axis; damping leaves 1 - c dt of the speed in each substep, of which there are 120 a second."""
    stage, box = _spinning((0.0, 0.0, 30.0), damping=0.5)
    box.AddAppliedSchema("PhysxForceAPI")
    box.CreateAttribute("physxForce:mode", Sdf.ValueTypeNames.Token).Set("acceleration")
    box.CreateAttribute("physxForce:torque", Sdf.ValueTypeNames.Vector3f).Set(Gf.Vec3f(0, 0, 10))
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    limit = 10.0 / 0.5
    assert _spin(box) == pytest.approx([0, 0, limit + (30.0 - limit) * np.exp(-0.5)], rel=3e-3, abs=1e-3)
