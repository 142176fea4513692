"""Highest velocities of bodies that joints hold, against closed forms.

PhysX (ovphysx 0.7.0) gives the same numbers to three digits, in articulations and outside.
"""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdPhysics

from tests.physics.mechanisms import drive, joint
from tests.physics.scenes import add, new_stage, playing

STEP, G = 1 / 60, 9.81
MOMENT = 0.2**2 / 6  # of a cube per mass [m²]


def _body(stage, path="/World/b", *, at=(0, 0, 0), gravity=True, velocity=(0, 0, 0), spin=(0, 0, 0), **limits):
    prim = add(stage, path, at=at, gravity=gravity)
    prim.CreateAttribute("physxRigidBody:linearDamping", Sdf.ValueTypeNames.Float).Set(0.0)
    for name, limit in limits.items():
        prim.CreateAttribute(f"physxRigidBody:{name}", Sdf.ValueTypeNames.Float).Set(limit)
    api = UsdPhysics.RigidBodyAPI(prim)
    api.CreateVelocityAttr(Gf.Vec3f(*velocity))
    api.CreateAngularVelocityAttr(Gf.Vec3f(*np.degrees(spin)))
    return prim


def _velocity(engine, path="/World/b", *, steps):
    for _ in range(steps):
        engine.step(STEP)
    return engine.velocities([path])[0]


def test_a_slide_falls_no_faster_than_its_body_may():
    """At the end of a step it has what gravity added to the limit."""
    stage = new_stage()
    _body(stage, maxLinearVelocity=2.0)
    joint(stage, "/World/joint", UsdPhysics.PrismaticJoint, "", "/World/b", (0, 0, 0), axis="Z")
    assert _velocity(playing(stage), steps=30)[2] == pytest.approx(-2.0 - G * STEP, rel=1e-3)


@pytest.mark.parametrize(("limit", "expected"), [(None, 100.0), (1000.0, np.radians(1000.0))])
def test_a_wheel_on_an_axle_turns_no_faster_than_its_body_may(limit, expected):
    """Without a limit of its own, 100 rad/s."""
    stage = new_stage()
    _body(stage, spin=(150, 0, 0), **({} if limit is None else {"maxAngularVelocity": limit}))
    joint(stage, "/World/joint", UsdPhysics.RevoluteJoint, "", "/World/b", (0, 0, 0), axis="X")
    assert _velocity(playing(stage), steps=2)[3] == pytest.approx(expected, rel=1e-3)


def test_a_motor_turns_a_wheel_faster_than_its_body_may():
    stage = new_stage()
    _body(stage, maxAngularVelocity=720.0)
    made = joint(stage, "/World/joint", UsdPhysics.RevoluteJoint, "", "/World/b", (0, 0, 0), axis="X")
    drive(made, "angular", damping=10.0, target_velocity=20000.0)
    assert _velocity(playing(stage), steps=30)[3] == pytest.approx(np.radians(20000), rel=1e-3)


def test_a_pendulum_loses_the_spin_above_its_limit_but_not_its_speed():
    """The limit takes an impulse of the spin alone, of which the arm leaves a small part."""
    arm, most = 1.0, np.radians(100.0)
    stage = new_stage()
    _body(stage, at=(arm, 0, 0), gravity=False, velocity=(0, 3, 0), spin=(0, 0, 3), maxAngularVelocity=100.0)
    joint(stage, "/World/joint", UsdPhysics.RevoluteJoint, "", "/World/b", (0, 0, 0), axis="Z")
    expected = 3.0 - MOMENT / (MOMENT + arm**2) * (3.0 - most)
    assert _velocity(playing(stage), steps=1)[5] == pytest.approx(expected, rel=1e-3)


def test_a_body_above_its_limit_slows_what_floats_with_it():
    """An impulse on one end of a dumbbell: half of it slows the whole, and its moment turns the whole."""
    arm = 0.25
    stage = new_stage()
    _body(stage, "/World/a", gravity=False, velocity=(0, 5, 0))
    _body(stage, at=(2 * arm, 0, 0), gravity=False, velocity=(0, 5, 0), maxLinearVelocity=2.0)
    joint(stage, "/World/joint", UsdPhysics.RevoluteJoint, "/World/a", "/World/b", (arm, 0, 0), axis="X")
    engine = playing(stage)
    # In the step the dumbbell turns by 5 degrees.
    spin = -3.0 * arm / (2 * (MOMENT + arm**2))
    assert _velocity(engine, steps=1)[[1, 5]] == pytest.approx([3.5 + spin * arm, spin], abs=0.01)
    assert engine.velocities(["/World/a"])[0][[1, 5]] == pytest.approx([3.5 - spin * arm, spin], abs=0.01)
