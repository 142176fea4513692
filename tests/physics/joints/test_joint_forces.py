"""Forces and torques in the joints of articulations, against closed forms and PhysX."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from tests.physics.mechanisms import drive, joint
from tests.physics.scenes import add, new_stage, playing, set_value
from usdsdg.errors import PhysicsError

STEP, G = 1 / 60, 9.81
PATHS = ["/World/robot/fix", "/World/robot/shoulder", "/World/robot/lift"]


def _arm(*, swapped=False, turn=None, meters=1.0):
    """A fixed base, a link of 1 kg on a driven hinge about Y, and one of 3 kg on a driven slide along Z."""
    stage, unit = new_stage(meters_per_unit=meters), 1.0 / meters
    UsdPhysics.ArticulationRootAPI.Apply(UsdGeom.Xform.Define(stage, "/World/robot").GetPrim())
    for name, x, mass in (("base", 0.0, 2.0), ("link", 0.3, 1.0), ("hand", 0.6, 3.0)):
        prim = add(stage, f"/World/robot/{name}", at=(x * unit, 0, unit), scale=(0.1 * unit,) * 3)
        UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(mass)
    ends = [("base", "link"), ("link", "hand")]
    pairs = [[f"/World/robot/{name}" for name in (pair[::-1] if swapped else pair)] for pair in ends]
    joint(stage, PATHS[0], UsdPhysics.FixedJoint, "", "/World/robot/base", (0, 0, unit))
    hinge = joint(stage, PATHS[1], UsdPhysics.RevoluteJoint, *pairs[0], (0.15 * unit, 0, unit), axis="Y", rotate=turn)
    slide = joint(stage, PATHS[2], UsdPhysics.PrismaticJoint, *pairs[1], (0.45 * unit, 0, unit), axis="Z", rotate=turn)
    drive(hinge, "angular", stiffness=1e4 * unit**2, damping=1e3 * unit**2)
    drive(slide, "linear", stiffness=1e5, damping=1e4)
    return stage, unit


# What holds 1 kg at 15 cm and 3 kg at 45 cm from the hinge, and 3 kg at 15 cm from the slide.
HELD = np.array([[0, 0, 4 * G, 0, -G * (0.15 + 3 * 0.45), 0], [0, 0, 3 * G, 0, -3 * G * 0.15, 0]])


@pytest.mark.parametrize("meters", [1.0, 0.01])
def test_joints_bear_the_weight_that_they_hold_and_its_torque(meters):
    """PhysX (ovphysx 0.7.0) has 39.28 N and -14.73 N m, 29.47 N and -4.42 N m."""
    stage, unit = _arm(meters=meters)
    engine = playing(stage)
    engine.advance(2.0)
    found = engine.joint_forces(PATHS)
    assert found[0].tolist() == [0.0] * 6
    assert found[1:] / ([unit] * 3 + [unit**2] * 3) == pytest.approx(HELD, rel=1e-3, abs=2e-2)


def test_forces_are_what_body_0_exerts_on_body_1_in_its_frame():
    """PhysX gives the opposite where body 1 is nearer to the base, and likewise turns signs with the frame."""
    stage, _ = _arm(swapped=True)
    engine = playing(stage)
    engine.advance(2.0)
    assert engine.joint_forces(PATHS[1:]) == pytest.approx(-HELD, rel=1e-3, abs=2e-2)
    stage, _ = _arm(turn=Gf.Quatf(0, 0, 0, 1))
    engine = playing(stage)
    engine.advance(2.0)
    assert engine.joint_forces(PATHS[1:]) == pytest.approx(HELD * [-1, -1, 1, -1, -1, 1], rel=1e-3, abs=2e-2)


def test_a_weight_that_turns_pulls_at_its_hinge():
    stage = new_stage()
    UsdPhysics.Scene(stage.GetPrimAtPath("/PhysicsScene")).CreateGravityMagnitudeAttr(0.0)
    base, weight = add(stage, "/World/base"), add(stage, "/World/weight", at=(0.5, 0, 0))
    UsdPhysics.MassAPI.Apply(weight).CreateMassAttr(2.0)
    UsdPhysics.ArticulationRootAPI.Apply(base)
    joint(stage, "/World/fix", UsdPhysics.FixedJoint, "", "/World/base", (0, 0, 0))
    joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "/World/base", "/World/weight", (0, 0, 0), axis="Z")
    engine = playing(stage)
    engine.set_joint_state(["/World/hinge"], velocities=[4.0])
    engine.advance(1.0)
    # Along the frame at the weight, which turns with it.
    assert engine.joint_forces(["/World/hinge"])[0] == pytest.approx([-2 * 4.0**2 * 0.5, 0, 0, 0, 0, 0], abs=0.2)
    engine.apply_joint_efforts(["/World/hinge"], [3.0])
    engine.step(STEP)
    assert engine.joint_forces(["/World/hinge"])[0, 5] == pytest.approx(3.0, abs=1e-3)


def test_what_is_no_joint_of_an_articulation_is_not_measured():
    stage, _ = _arm()
    stage.GetPrimAtPath("/World/robot").RemoveAPI(UsdPhysics.ArticulationRootAPI)
    engine = playing(stage)
    engine.advance(STEP)
    with pytest.raises(PhysicsError, match="/World/robot/fix is no joint of a simulated articulation"):
        engine.joint_forces(PATHS)
    assert engine.joint_forces([]).shape == (0, 6)


def test_measured_forces_are_there_after_an_edit_too():
    stage, _ = _arm()
    engine = playing(stage)
    engine.advance(2.0)
    set_value(stage.GetPrimAtPath("/World/robot/hand"), "physics:mass", 6.0)
    engine.advance(2.0)
    assert engine.joint_forces(PATHS)[2, 2] == pytest.approx(6 * G, rel=1e-3)
