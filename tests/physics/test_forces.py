"""Forces on bodies during one step, against closed forms."""

import numpy as np
import pytest
from pxr import Gf, UsdPhysics

from tests.physics.scenes import add, new_stage, playing, position, velocity
from usdsdg.errors import PhysicsError

STEP = 1 / 60


def _box(stage, mass: float = 2.0, **options):
    prim = add(stage, "/World/box", gravity=False, **options)
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(mass)
    return prim


def test_a_force_acts_during_one_step_only():
    stage = new_stage()
    prim = _box(stage)
    engine = playing(stage)
    engine.apply_forces(["/World/box"], [(30.0, 0.0, 0.0)])
    engine.advance(3 * STEP)
    assert velocity(prim) == pytest.approx([30.0 / 2.0 * STEP, 0, 0], rel=1e-5)


def test_forces_add_up_and_are_in_units_of_the_stage():
    stage = new_stage(meters_per_unit=0.01)
    prim = _box(stage, scale=(10, 10, 10))
    engine = playing(stage)
    for _ in range(2):
        engine.apply_forces(["/World/box"], [(0.0, 100.0, 0.0)])  # kg cm/s²
    engine.advance(STEP)
    assert velocity(prim) == pytest.approx([0, 200.0 / 2.0 * STEP, 0], rel=1e-4)


def test_a_force_beside_the_center_of_mass_turns_the_body():
    stage = new_stage()
    prim = _box(stage, at=(1, 0, 0))
    engine = playing(stage)
    engine.apply_forces(["/World/box"], [(0.0, 6.0, 0.0)], positions=[(1.1, 0.0, 0.0)])
    engine.advance(STEP)
    # A cube of edge 0.2 m has a moment of inertia of m a² / 6.
    expected = 0.1 * 6.0 / (2.0 * 0.2**2 / 6.0) * STEP
    assert prim.GetAttribute("physics:angularVelocity").Get()[2] == pytest.approx(np.degrees(expected), rel=1e-3)


def test_a_torque_turns_the_body_where_it_is():
    stage = new_stage()
    prim = _box(stage)
    engine = playing(stage)
    engine.apply_forces(["/World/box"], torques=[(0.0, 0.0, 0.5)])
    engine.advance(STEP)
    expected = 0.5 / (2.0 * 0.2**2 / 6.0) * STEP
    assert prim.GetAttribute("physics:angularVelocity").Get()[2] == pytest.approx(np.degrees(expected), rel=1e-3)
    assert position(prim) == pytest.approx([0, 0, 0], abs=1e-6)


def test_a_force_lifts_a_body_at_rest():
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(5, 5, 0.1), body=False)
    prim = add(stage, "/World/box", at=(0, 0, 0.1))
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(1.0)
    engine = playing(stage)
    engine.advance(1.0)
    engine.apply_forces(["/World/box"], [(0.0, 0.0, 120.0)])
    engine.advance(STEP)
    assert velocity(prim)[2] == pytest.approx((120.0 - 9.81) * STEP, rel=1e-2)


def test_no_force_moves_a_kinematic_body():
    stage = new_stage()
    prim = _box(stage)
    UsdPhysics.RigidBodyAPI(prim).CreateKinematicEnabledAttr(True)
    engine = playing(stage)
    engine.apply_forces(["/World/box"], [(0.0, 0.0, 500.0)])
    engine.advance(STEP)
    assert prim.GetAttribute("xformOp:translate").Get() == Gf.Vec3d(0, 0, 0)


def test_a_force_on_a_prim_that_is_no_body_is_an_error():
    engine = playing(new_stage())
    with pytest.raises(PhysicsError, match="/World/none is not a simulated rigid body"):
        engine.apply_forces(["/World/none"], [(0.0, 0.0, 1.0)])
