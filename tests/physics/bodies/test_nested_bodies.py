"""Rigid bodies below others: kinematic ones stay, those that are disabled are static colliders, as in PhysX."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from tests.physics.scenes import add, fallen, make_body, new_stage, playing, position

STEP, STEPS = 1 / 60, 20
FALL = fallen(STEPS)


def _falling(stage: Usd.Stage, *, rotate=(0, 0, 30)) -> UsdGeom.Xform:
    """A body of one collider, 5 m up, that turns about x while it falls; no collider reaches 2 m beside it."""
    above = UsdGeom.Xform.Define(stage, "/World/above")
    above.AddTranslateOp().Set(Gf.Vec3d(0, 0, 5))
    above.AddRotateXYZOp().Set(Gf.Vec3f(*rotate))
    above.AddScaleOp().Set(Gf.Vec3f(2))
    make_body(above.GetPrim())
    above.GetPrim().GetAttribute("physics:angularVelocity").Set(Gf.Vec3f(90, 0, 0))
    add(stage, "/World/above/shape", body=False)
    return above


def _matrix(prim: Usd.Prim) -> np.ndarray:
    return np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim))


def _steps(engine) -> None:
    for _ in range(STEPS):
        engine.step(STEP)


@pytest.mark.parametrize("below", ["", "/group", "/kinematic"])
def test_a_kinematic_body_below_one_that_moves_stays_where_it_is(below):
    """Whatever is between them; what lies on it stays too, and all is undone at the end."""
    stage = new_stage()
    above = _falling(stage)
    if below:
        between = UsdGeom.Xform.Define(stage, f"/World/above{below}")
        between.AddTranslateOp().Set(Gf.Vec3d(0, 0.5, 0))
        if below == "/kinematic":
            UsdPhysics.RigidBodyAPI.Apply(between.GetPrim()).CreateKinematicEnabledAttr(True)
            add(stage, "/World/above/kinematic/shape", body=False)
    held = add(stage, f"/World/above{below}/held", at=(1, 0, 0), rotate=(0, 0, 20), scale=(0.2, 0.2, 0.1))
    UsdPhysics.RigidBodyAPI(held).CreateKinematicEnabledAttr(True)
    start, local = _matrix(held), UsdGeom.Xformable(held).GetLocalTransformation()
    x, y, z = start[3, :3]
    load = add(stage, "/World/load", at=(float(x), float(y), float(z) + 0.3))
    engine = playing(stage)
    _steps(engine)
    assert position(above.GetPrim())[2] == pytest.approx(5 - FALL, abs=1e-3)
    assert _matrix(held) == pytest.approx(start, abs=1e-5)
    assert position(load) == pytest.approx([x, y, z + 0.3], abs=1e-3)
    assert not held.GetAttribute("physics:velocity").Get()[2]
    engine.stop()
    assert UsdGeom.Xformable(held).GetLocalTransformation() == local


def test_a_kinematic_body_below_one_that_moves_goes_where_a_script_puts_it():
    stage = new_stage()
    above = _falling(stage, rotate=(0, 0, 0))
    above.GetPrim().GetAttribute("physics:angularVelocity").Set(Gf.Vec3f(0))
    held = add(stage, "/World/above/held", at=(1, 0, 0))
    UsdPhysics.RigidBodyAPI(held).CreateKinematicEnabledAttr(True)
    engine = playing(stage)
    _steps(engine)
    translate = UsdGeom.Xformable(held).GetOrderedXformOps()[0]
    translate.Set(translate.Get() + Gf.Vec3d(0, 0, 0.25))  # twice as much in the world
    put = position(held)
    assert put == pytest.approx([2, 0, 5.5], abs=1e-4)
    _steps(engine)
    assert position(held) == pytest.approx(put, abs=1e-4)


def test_a_kinematic_body_below_one_that_moves_follows_its_own_time_samples():
    """They are relative to the body above."""
    stage = new_stage()
    above = _falling(stage, rotate=(0, 0, 0))
    above.GetPrim().GetAttribute("physics:angularVelocity").Set(Gf.Vec3f(0))
    held = add(stage, "/World/above/held")
    UsdPhysics.RigidBodyAPI(held).CreateKinematicEnabledAttr(True)
    translate = UsdGeom.Xformable(held).GetOrderedXformOps()[0]
    for code in (0.0, 24.0):
        translate.Set(Gf.Vec3d(1 + code / 24, 0, 0), code)
    engine = playing(stage)
    _steps(engine)
    assert translate.GetAttr().GetTimeSamples() == [0.0, 24.0]
    assert position(above.GetPrim())[2] == pytest.approx(5 - FALL, abs=1e-3)


@pytest.mark.parametrize("kinematic", [False, True])
def test_a_body_below_a_prim_that_resets_its_transform_moves_by_itself(kinematic):
    """Nothing of the body above is in its transform."""
    stage = new_stage()
    _falling(stage)
    group = UsdGeom.Xform.Define(stage, "/World/above/group")
    group.SetResetXformStack(True)
    body = add(stage, "/World/above/group/body", at=(3, 0, 4))
    UsdPhysics.RigidBodyAPI(body).CreateKinematicEnabledAttr(kinematic)
    engine = playing(stage)
    _steps(engine)
    assert position(body) == pytest.approx([3, 0, 4 if kinematic else 4 - FALL], abs=1e-4)


def test_colliders_of_a_disabled_body_below_one_that_moves_stay_and_are_named():
    """They have no mass, nothing takes them along, and others lie on them."""
    stage = new_stage()
    above = _falling(stage, rotate=(0, 0, 0))
    above.GetPrim().GetAttribute("physics:angularVelocity").Set(Gf.Vec3f(0))
    off = UsdGeom.Xform.Define(stage, "/World/above/off")
    off.AddTranslateOp().Set(Gf.Vec3d(1, 0, 0))
    UsdPhysics.RigidBodyAPI.Apply(off.GetPrim()).CreateRigidBodyEnabledAttr(False)
    add(stage, "/World/above/off/shape", body=False)
    load = add(stage, "/World/load", at=(2, 0, 5.3))
    with pytest.warns(match="static, and stay where they are.*/World/above/off"):
        engine = playing(stage)
    # A cube of 0.4 m at 1000 kg/m³.
    assert engine.mass_properties(["/World/above"]).mass == pytest.approx([64.0])
    _steps(engine)
    assert position(above.GetPrim())[2] == pytest.approx(5 - FALL, abs=1e-3)
    assert position(load) == pytest.approx([2, 0, 5.3], abs=1e-3)


def test_a_joint_to_a_disabled_body_is_one_to_the_world():
    stage = new_stage()
    _falling(stage)
    off = add(stage, "/World/above/off", at=(1, 0, 0))
    UsdPhysics.RigidBodyAPI(off).CreateRigidBodyEnabledAttr(False)
    body = add(stage, "/World/body", at=(4, 0, 5))
    made = UsdPhysics.FixedJoint.Define(stage, "/World/fix")
    made.CreateBody0Rel().SetTargets([Sdf.Path("/World/above/off")])
    made.CreateBody1Rel().SetTargets([Sdf.Path("/World/body")])
    x, y, z = np.linalg.solve(_matrix(off).T, [4, 0, 5, 1])[:3]
    made.CreateLocalPos0Attr(Gf.Vec3f(float(x), float(y), float(z)))
    turn = Gf.Rotation(Gf.Vec3d(0, 0, 1), -30.0).GetQuat()
    made.CreateLocalRot0Attr(Gf.Quatf(turn))
    with pytest.warns(match="static, and stay where they are"):
        engine = playing(stage)
    _steps(engine)
    assert position(body) == pytest.approx([4, 0, 5], abs=1e-4)
