"""Forces on bodies, against closed forms.

PhysX (ovphysx 0.7.0) gives the same velocities for forces, accelerations and torques in either frame, and 1.4 % less
spin for a force at a prim below the body.
"""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics

from tests.physics.scenes import add, new_stage, playing, position, velocity
from usdsdg import errors
from usdsdg.errors import PhysicsError
from usdsdg.stage.schemas import physx

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


@pytest.mark.parametrize("mass", [2.0, 4.0])
def test_a_force_acts_although_physics_reads_the_stage_again_before_the_step(mass):
    stage = new_stage()
    prim = _box(stage)
    engine = playing(stage)
    engine.advance(STEP)
    engine.apply_forces(["/World/box"], [(30.0, 0.0, 0.0)], [(0.0, 0.0, 0.3)])
    add(stage, "/World/late", at=(9, 0, 0), gravity=False)
    UsdPhysics.MassAPI(prim).GetMassAttr().Set(mass)
    engine.advance(3 * STEP)
    assert velocity(prim) == pytest.approx([30.0 / mass * STEP, 0, 0], rel=1e-4)
    spin = 0.3 / (mass * 0.2**2 / 6) * STEP
    assert np.radians(prim.GetAttribute("physics:angularVelocity").Get()) == pytest.approx([0, 0, spin], rel=1e-3)


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


def _steady(prim, *, force=(0.0, 0.0, 0.0), torque=(0.0, 0.0, 0.0), mode="force", world=True):
    api = physx.PhysxForceAPI.Apply(prim)
    api.CreateForceAttr(Gf.Vec3f(*force))
    api.CreateTorqueAttr(Gf.Vec3f(*torque))
    api.CreateModeAttr(mode)
    api.CreateWorldFrameEnabledAttr(world)


def _spin(prim):
    return np.radians(np.array(prim.GetAttribute("physics:angularVelocity").Get()))


@pytest.mark.parametrize(("mode", "expected"), [("force", 3.0 / 2.0), ("acceleration", 3.0)])
def test_an_authored_force_acts_at_every_step(mode, expected):
    stage = new_stage()
    prim = _box(stage)
    _steady(prim, force=(3, 0, 0), mode=mode)
    playing(stage).advance(60 * STEP)
    assert velocity(prim) == pytest.approx([expected, 0, 0], rel=1e-4, abs=1e-6)


def test_an_authored_force_turns_with_the_body_unless_it_is_the_worlds():
    for world, expected in ((False, [0, 3, 0]), (True, [3, 0, 0])):
        stage = new_stage()
        prim = _box(stage, rotate=(0, 0, 90))
        _steady(prim, force=(3, 0, 0), mode="acceleration", world=world)
        playing(stage).advance(60 * STEP)
        assert velocity(prim) == pytest.approx(expected, rel=1e-4, abs=1e-5)


def test_an_authored_torque():
    """A cube of edge 0.2 m has a moment of inertia of m a² / 6; an acceleration needs none."""
    for mode, expected in (("force", 0.05 / (2.0 * 0.2**2 / 6.0)), ("acceleration", 0.05)):
        stage = new_stage()
        prim = _box(stage)
        _steady(prim, torque=(0, 0, 0.05), mode=mode)
        playing(stage).advance(60 * STEP)
        assert _spin(prim)[2] == pytest.approx(expected, rel=1e-3)


def test_a_force_of_a_prim_below_a_body_acts_at_its_origin():
    """0.1 m beside the center of mass; in the first step the body has not turned yet."""
    stage = new_stage()
    prim = _box(stage)
    point = UsdGeom.Xform.Define(stage, "/World/box/thruster")
    point.AddTranslateOp().Set(Gf.Vec3d(0, 1, 0))
    _steady(point.GetPrim(), force=(3, 0, 0))
    playing(stage).advance(STEP)
    assert velocity(prim) == pytest.approx([3.0 / 2.0 * STEP, 0, 0], rel=1e-3, abs=1e-5)
    assert _spin(prim)[2] == pytest.approx(-0.1 * 3.0 / (2.0 * 0.2**2 / 6.0) * STEP, rel=1e-3)


def test_an_authored_force_is_changed_and_switched_off_while_playing():
    stage = new_stage()
    prim = _box(stage)
    _steady(prim, force=(6, 0, 0))
    engine = playing(stage)
    engine.advance(STEP)
    prim.GetAttribute("physxForce:force").Set(Gf.Vec3f(0, 6, 0))
    engine.advance(STEP)
    prim.CreateAttribute("physxForce:forceEnabled", Sdf.ValueTypeNames.Bool).Set(False)
    engine.advance(STEP)
    assert velocity(prim) == pytest.approx([3 * STEP, 3 * STEP, 0], rel=1e-4, abs=1e-6)


def test_a_force_without_a_body_is_named():
    stage = new_stage()
    prim = add(stage, "/World/table", body=False)
    _steady(prim, force=(1, 0, 0))
    add(stage, "/World/box")
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning, match="/World/table has PhysxForceAPI but no rigid body"):
        playing(stage)
    errors.forget_warnings()
