"""Spinning tops on a ball joint, against the equations of a rigid body that turns about a fixed point."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdPhysics

from tests.physics.mechanisms import cross_matrix, joint, runge_kutta
from tests.physics.scenes import add, new_stage, playing, position, set_value
from usdsdg.errors import UsdsdgWarning

G, TILT, SPIN = 9.81, 0.5, 100.0  # rad, and rad/s: the default limit
RADIUS, HEIGHT = 0.1, 0.04
INERTIA = np.array([(3 * RADIUS**2 + HEIGHT**2) / 12] * 2 + [RADIUS**2 / 2])  # of a disk of 1 kg
AXIS = np.array([np.sin(TILT), 0.0, np.cos(TILT)])


def _exact(arm: float, spin: np.ndarray, seconds: float, steps: int = 1000) -> np.ndarray:
    """Directions of the axis (steps, 3), by Euler's equations in the axes of the top, with Runge and Kutta's steps.

    A step is a tenth of a radian of the spin, of which the error after a second is 1e-5.
    """
    inertia = INERTIA + np.array([arm**2, arm**2, 0.0])
    turn = np.array([[np.cos(TILT), 0, np.sin(TILT)], [0, 1, 0], [-np.sin(TILT), 0, np.cos(TILT)]])

    def change(turn, omega):
        torque = turn.T @ np.cross(arm * turn[:, 2], (0, 0, -G))
        return turn @ cross_matrix(omega), (torque - np.cross(omega, inertia * omega)) / inertia

    return np.array([turn[:, 2] for turn, _ in runge_kutta(change, turn, turn.T @ spin, seconds, steps)])


def _top(arm: float, rate: int, speed: float, *, swapped: bool = False) -> tuple[Usd.Stage, np.ndarray]:
    """A stage with a top, and its angular velocity [rad/s], most of which is about its own axis."""
    stage = new_stage()
    set_value(stage.GetPrimAtPath("/PhysicsScene"), "physxScene:timeStepsPerSecond", rate)
    tilt = (0.0, float(np.degrees(TILT)), 0.0)
    top = add(stage, "/World/top", "Cylinder", at=tuple((arm * AXIS).tolist()), rotate=tilt, scale=(0.1, 0.1, 0.02))
    mass = UsdPhysics.MassAPI.Apply(top)
    mass.CreateMassAttr(1.0)
    mass.CreateDiagonalInertiaAttr(Gf.Vec3f(*INERTIA.tolist()))
    precession = G * arm / (INERTIA[2] * speed)  # the slow one of a fast top: m g arm / (I3 spin)
    spin = precession * np.array([0, 0, 1]) + (speed - precession * np.cos(TILT)) * AXIS
    body = UsdPhysics.RigidBodyAPI(top)
    body.CreateAngularVelocityAttr(Gf.Vec3f(*np.degrees(spin).tolist()))
    body.CreateVelocityAttr(Gf.Vec3f(*np.cross(spin, arm * AXIS).tolist()))
    body0, body1 = ("/World/top", "") if swapped else ("", "/World/top")
    turn = Gf.Quatf(0.6, 0.0, 0.8, 0.0)
    joint(stage, "/World/joint", UsdPhysics.SphericalJoint, body0, body1, (0, 0, 0), rotate=turn)
    limit = top.CreateAttribute("physxRigidBody:maxAngularVelocity", Sdf.ValueTypeNames.Float)
    limit.Set(float(np.degrees(max(speed, SPIN))) + 100.0)
    return stage, spin


@pytest.mark.parametrize("rate", [60, 240])
@pytest.mark.parametrize("arm", [0.05, 0.1])
def test_a_top_precesses_and_does_not_fall(arm, rate):
    """It gained energy from step to step, and fell within a second."""
    stage, spin = _top(arm, rate, SPIN)
    top, engine = stage.GetPrimAtPath("/World/top"), playing(stage)
    found = []
    for _ in range(rate):
        engine.step(1 / rate)
        found.append(position(top) / arm)
    found, exact = np.array(found), _exact(arm, spin, 1.0)
    phases = [np.unwrap(np.arctan2(each[:, 1], each[:, 0]))[-1] for each in (found, exact)]
    assert phases[0] == pytest.approx(phases[1], rel=1e-3)
    assert found[:, 2] == pytest.approx(np.full(rate, exact[:, 2].mean()), rel=2e-3)


@pytest.mark.parametrize("speed", [10.0, 20.0, 40.0])
@pytest.mark.parametrize(("arm", "swapped"), [(0.05, False), (0.1, True)])
def test_a_slow_top_sways_as_it_should(arm, swapped, speed):
    """At 40 rad/s, 10 cm above its joint, one precessed by half as much again, and rose where it should fall."""
    rate = 50
    stage, spin = _top(arm, rate, speed, swapped=swapped)
    top, engine = stage.GetPrimAtPath("/World/top"), playing(stage)
    found = []
    for _ in range(rate):
        engine.step(1 / rate)
        found.append(position(top) / arm)
    exact = _exact(arm, spin, 1.0)[19::20]
    assert np.array(found) == pytest.approx(exact, abs=1e-3)


def test_a_top_on_a_kinematic_body_sways_as_on_the_world():
    stage, spin = _top(0.1, 50, 40.0)
    hand = add(stage, "/World/hand", at=(0, 0, -0.5), scale=(0.01, 0.01, 0.01))
    UsdPhysics.RigidBodyAPI(hand).CreateKinematicEnabledAttr(True)
    stage.RemovePrim("/World/joint")
    joint(stage, "/World/joint", UsdPhysics.SphericalJoint, "/World/hand", "/World/top", (0, 0, 0))
    top, engine = stage.GetPrimAtPath("/World/top"), playing(stage)
    found = []
    for _ in range(50):
        engine.step(1 / 50)
        found.append(position(top) / 0.1)
    assert np.array(found) == pytest.approx(_exact(0.1, spin, 1.0)[19::20], abs=1e-3)


def test_a_top_below_a_hand_that_moves_goes_with_it():
    stage, _ = _top(0.1, 60, 1.0)
    hand = add(stage, "/World/hand", at=(0, 0, -0.5), scale=(0.01, 0.01, 0.01))
    UsdPhysics.RigidBodyAPI(hand).CreateKinematicEnabledAttr(True)
    stage.RemovePrim("/World/joint")
    joint(stage, "/World/joint", UsdPhysics.SphericalJoint, "/World/hand", "/World/top", (0, 0, 0))
    engine, top = playing(stage), stage.GetPrimAtPath("/World/top")
    for step in range(1, 61):
        set_value(hand, "xformOp:translate", Gf.Vec3d(0.01 * min(step, 30), 0, -0.5))
        engine.step(1 / 60)
        joint_at = np.array([0.01 * min(step, 30), 0, 0])
        assert np.linalg.norm(position(top) - joint_at) == pytest.approx(0.1, abs=1e-3)


def test_a_top_that_leans_on_something_stays_there():
    """It is turned by its momentum about the joint only where nothing is near."""
    stage, _ = _top(0.1, 60, SPIN)
    top = stage.GetPrimAtPath("/World/top")
    for name in ("physics:velocity", "physics:angularVelocity"):
        set_value(top, name, Gf.Vec3f(0))
    add(stage, "/World/table", at=(0, 0, -0.2 + 0.1 * np.cos(TILT) - 0.06), scale=(1, 1, 0.2), body=False)
    engine = playing(stage)
    for _ in range(120):
        engine.step(1 / 60)
    assert np.linalg.norm(position(top)) == pytest.approx(0.1, abs=1e-4)
    leaning = position(top)
    for _ in range(60):
        engine.step(1 / 60)
    assert position(top) == pytest.approx(leaning, abs=1e-4)


def test_a_top_that_is_faster_than_the_default_limit_keeps_its_spin():
    """It gained energy without end at a quarter of the substeps: thousands of rad/s within a second."""
    stage, spin = _top(0.1, 60, 1000.0)
    top, engine = stage.GetPrimAtPath("/World/top"), playing(stage)
    for _ in range(6):
        engine.step(1 / 60)
    found = np.radians(top.GetAttribute("physics:angularVelocity").Get())
    assert np.linalg.norm(found) == pytest.approx(np.linalg.norm(spin), rel=1e-4)
    assert position(top)[2] == pytest.approx(0.1 * np.cos(TILT), rel=0.002)


def test_a_top_that_is_too_fast_is_named():
    stage, _ = _top(0.1, 60, 4000.0)
    engine = playing(stage)
    with pytest.warns(UsdsdgWarning, match=r"^/World/top turns at 4\d\d\d rad/s on a ball joint"):
        engine.step(1 / 60)
