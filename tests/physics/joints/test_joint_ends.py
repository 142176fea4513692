"""Ends of joints: names of prims that are none, frames that do not meet, and joints that hold whatever the load."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from tests.physics.mechanisms import joint
from tests.physics.scenes import add, new_stage, playing, position
from tests.sampled_cases import crossed

STEP, G = 1 / 60, 9.81


def _fixed(stage: Usd.Stage, bodies=("", ""), at0=(0, 0, 0), at1=(0, 0, 0), kind=UsdPhysics.FixedJoint):
    made = kind.Define(stage, "/World/joint")
    for number, (path, at) in enumerate(zip(bodies, (at0, at1))):
        if path:
            made.GetPrim().GetRelationship(f"physics:body{number}").SetTargets([Sdf.Path(path)])
        made.GetPrim().GetAttribute(f"physics:localPos{number}").Set(Gf.Vec3f(*at))
    return made


@pytest.mark.parametrize(
    ("first", "name"),
    crossed([True, False], ["/nowhere", "/World/nowhere", "/World/inactive", "/World/inactive/below"]),
)
def test_the_world_takes_the_place_of_a_prim_that_is_missing(name, first):
    """A body of 0.2 m, fixed to what is none: held at the joint's point of the world, and said once."""
    stage = new_stage()
    add(stage, "/World/inactive", at=(5, 0, 0)).SetActive(False)
    body = add(stage, "/World/body", at=(1, 2, 3))
    if first:
        _fixed(stage, (name, "/World/body"), at0=(1, 2, 3))
    else:
        _fixed(stage, ("/World/body", name), at1=(1, 2, 3))
    with pytest.warns(
        match=f"/World/joint: physics:body{int(not first)} names {name}, which is no active prim"
    ) as said:
        engine = playing(stage)
    assert len([each for each in said if "no active prim" in str(each.message)]) == 1
    for _ in range(30):
        engine.step(STEP)
    assert position(body) == pytest.approx([1, 2, 3], abs=1e-5)


@pytest.mark.parametrize("name", ["/World/group/gone", "/World/group/gone/below", "/World/body/gone"])
def test_the_nearest_prim_above_takes_the_place_of_a_prim_that_is_missing(name):
    """A group that is turned and scaled, or a body that is fixed to it; values are PhysX's."""
    stage = new_stage()
    group = UsdGeom.Xform.Define(stage, "/World/group")
    group.AddTranslateOp().Set(Gf.Vec3d(0, 30, 0))
    group.AddRotateXYZOp().Set(Gf.Vec3f(0, 0, 90))
    group.AddScaleOp().Set(Gf.Vec3f(2))
    base = add(stage, "/World/body", at=(18, 0, 3), gravity=False, scale=(1, 1, 1))
    UsdPhysics.RigidBodyAPI(base).CreateKinematicEnabledAttr(True)
    body = add(stage, "/World/held", at=(9, 0, 3))
    made = UsdPhysics.FixedJoint.Define(stage, "/World/joint")
    made.CreateBody0Rel().SetTargets([Sdf.Path(name)])
    made.CreateBody1Rel().SetTargets([Sdf.Path("/World/held")])
    made.CreateLocalPos0Attr(Gf.Vec3f(2, 0, 0))
    nearest = "/World/group" if "group" in name else "/World/body"
    with pytest.warns(match=f"{name}, which is no active prim, so as in PhysX {nearest} takes its place"):
        engine = playing(stage)
    engine.step(STEP)
    assert position(body) == pytest.approx([0, 34, 0] if "group" in name else [20, 0, 3], abs=1e-5)


def test_a_hinge_to_a_prim_that_is_missing_swings_about_the_world():
    """A cube that hangs 0.5 m below: its height says that it keeps its distance."""
    stage = new_stage()
    body = add(stage, "/World/body", at=(0.5, 0, 3))
    made = _fixed(stage, ("/World/gone", "/World/body"), (0, 0, 3), (-5, 0, 0), kind=UsdPhysics.RevoluteJoint)
    made.CreateAxisAttr("Y")
    with pytest.warns(match="/World/gone"):
        engine = playing(stage)
    for _ in range(30):
        engine.step(STEP)
        assert np.linalg.norm(position(body) - (0, 0, 3)) == pytest.approx(0.5, abs=1e-4)
    assert position(body)[2] < 2.8


def _pair(stage: Usd.Stage, *, articulation: bool, force: float) -> tuple[Usd.Prim, UsdPhysics.FixedJoint]:
    """A weight of 2 kg, 19.6 N, on a base that is fixed to the world."""
    base, weight = add(stage, "/World/base", at=(0, 0, 3)), add(stage, "/World/weight", at=(0, 0, 2))
    UsdPhysics.MassAPI.Apply(weight).CreateMassAttr(2.0)
    joint(stage, "/World/root", UsdPhysics.FixedJoint, "", "/World/base", (0, 0, 3))
    made = joint(stage, "/World/hook", UsdPhysics.FixedJoint, "/World/base", "/World/weight", (0, 0, 2.5))
    made.CreateBreakForceAttr(force)
    if articulation:
        UsdPhysics.ArticulationRootAPI.Apply(base)
    return weight, made


@pytest.mark.parametrize(
    ("articulation", "excluded", "breaks"), [(False, False, True), (True, False, False), (True, True, True)]
)
def test_joints_of_an_articulation_do_not_break(articulation, excluded, breaks):
    """15 N are not enough for the weight, but PhysX has no forces of an articulation's joints."""
    stage = new_stage()
    weight, made = _pair(stage, articulation=articulation, force=15.0)
    made.CreateExcludeFromArticulationAttr(excluded)
    engine = playing(stage)
    for _ in range(30):
        engine.step(STEP)
    assert 2 - position(weight)[2] == pytest.approx(G / 8 if breaks else 0.0, abs=0.1 if breaks else 1e-5)


def test_limits_that_an_articulation_ignores_are_named():
    stage = new_stage()
    _pair(stage, articulation=True, force=15.0)
    with pytest.warns(match="no effect on the joints of an articulation: /World/hook"):
        playing(stage)


@pytest.mark.parametrize("where", ["below the root", "beside it", "of a kinematic body", "disabled"])
def test_an_articulation_is_what_its_joints_connect(where):
    """Also beside the prim with ArticulationRootAPI; but not kinematic bodies, nor where it is disabled."""
    stage = new_stage()
    group = UsdGeom.Xform.Define(stage, "/World/group").GetPrim()
    UsdPhysics.ArticulationRootAPI.Apply(group)
    base = add(stage, "/World/group/base", at=(0, 0, 3))
    if where == "of a kinematic body":
        UsdPhysics.RigidBodyAPI(base).CreateKinematicEnabledAttr(True)
    if where == "disabled":
        group.AddAppliedSchema("PhysxArticulationAPI")
        group.CreateAttribute("physxArticulation:articulationEnabled", Sdf.ValueTypeNames.Bool).Set(False)
    path = "/World/weight" if where == "beside it" else "/World/group/weight"
    weight = add(stage, path, at=(0, 0, 2))
    UsdPhysics.MassAPI.Apply(weight).CreateMassAttr(2.0)
    joint(stage, "/World/hook", UsdPhysics.FixedJoint, "/World/group/base", path, (0, 0, 2.5)).CreateBreakForceAttr(15)
    joint(stage, "/World/root", UsdPhysics.FixedJoint, "", "/World/group/base", (0, 0, 3))
    engine = playing(stage)
    for _ in range(30):
        engine.step(STEP)
    breaks = where in ("of a kinematic body", "disabled")
    assert 2 - position(weight)[2] == pytest.approx(G / 8 if breaks else 0.0, abs=0.1 if breaks else 1e-5)


@pytest.mark.parametrize("articulation", [False, True])
def test_a_body_whose_joint_to_the_world_is_elsewhere_goes_there_unless_it_is_a_base(articulation):
    """1 m higher and turned by 45 degrees, which is said."""
    stage = new_stage()
    body = add(stage, "/World/body", at=(0, 0, 1))
    made = _fixed(stage, ("", "/World/body"), at0=(0, 0, 2))
    made.GetLocalRot0Attr().Set(Gf.Quatf(Gf.Rotation(Gf.Vec3d(0, 1, 0), 45.0).GetQuat()))
    if articulation:
        UsdPhysics.ArticulationRootAPI.Apply(body)
    engine = playing(stage)
    if articulation:
        engine.step(STEP)
    else:
        with pytest.warns(match="/World/joint: its frames are 1 m apart"):
            engine.step(STEP)
    for _ in range(10):
        engine.step(STEP)
    assert position(body) == pytest.approx([0, 0, 1 if articulation else 2], abs=1e-5)
    x_axis = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(body))[0, :3] / 0.1
    turned = (1, 0, 0) if articulation else (np.sqrt(0.5), 0, -np.sqrt(0.5))
    assert x_axis == pytest.approx(turned, abs=1e-5)


def test_a_body_that_a_joint_holds_is_back_where_a_script_takes_it_away():
    """And the stage has it there, though it has not moved for the solver."""
    stage = new_stage()
    body = add(stage, "/World/body", at=(0, 0, 2))
    _fixed(stage, ("", "/World/body"), at0=(0, 0, 2))
    engine = playing(stage)
    for _ in range(5):
        engine.step(STEP)
    UsdGeom.Xformable(body).GetOrderedXformOps()[0].Set(Gf.Vec3d(1, 0, 2))
    engine.step(STEP)
    assert position(body) == pytest.approx([0, 0, 2], abs=1e-5)


@pytest.mark.parametrize("masses", [(1.0, 1.0), (1.0, 3.0)])
def test_two_bodies_whose_frames_do_not_meet_go_to_each_other(masses):
    """They are 0.3 m apart, and keep their center of mass."""
    stage = new_stage()
    bodies = [add(stage, f"/World/{name}", at=(x, 0, 0), gravity=False) for name, x in (("a", 0), ("b", 1))]
    for body, mass in zip(bodies, masses):
        UsdPhysics.MassAPI.Apply(body).CreateMassAttr(mass)
    _fixed(stage, ("/World/a", "/World/b"), (7, 0, 0), (0, 0, 0))
    engine = playing(stage)
    with pytest.warns(match="its frames are 0.3 m apart"):
        engine.step(STEP)
    a, b = (position(body)[0] for body in bodies)
    assert b - a == pytest.approx(0.7, abs=1e-5)
    assert np.average([a, b], weights=masses) == pytest.approx(np.average([0.0, 1.0], weights=masses), abs=1e-5)
