"""Time samples, splines and value clips of bodies and colliders: where they begin, what is drawn, what is restored."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from pxr import Gf, Sdf, Ts, Usd, UsdGeom, UsdPhysics, Vt

from tests.physics.scenes import add, collide, fallen, mesh, new_stage, playing, position
from tests.sampled_cases import crossed
from usdsdg import errors

STEP = 1 / 60


def _stage(start=0.0):
    """A time code is a step."""
    stage = new_stage()
    stage.SetTimeCodesPerSecond(60)
    stage.SetStartTimeCode(start)
    return stage


def _sample(prim, name, samples):
    """Nothing but samples: no default value."""
    attribute = prim.GetAttribute(name)
    attribute.Clear()
    for code, value in samples.items():
        attribute.Set(value, code)
    return attribute


def _spline(first, last, until=60):
    made = Ts.Spline("double")
    for code, number in ((0, first), (until, last)):
        made.SetKnot(Ts.Knot(typeName="double", time=code, value=float(number), nextInterp=Ts.InterpLinear))
    return made


def _drawn(prim, code):
    return np.array(UsdGeom.XformCache(code).GetLocalToWorldTransform(prim).ExtractTranslation())


def _text(stage):
    return stage.GetRootLayer().ExportToString()


@pytest.mark.parametrize("above", [False, True])
def test_a_body_with_one_sample_falls_from_there_and_is_drawn_where_it_is(above):
    """Of its own or of a prim above it; exporters write exactly one sample of each attribute."""
    stage = _stage(start=1)
    parent = UsdGeom.Xform.Define(stage, "/World/parent")
    parent.AddTranslateOp()
    box = add(stage, "/World/parent/box", at=(0, 0, 5))
    if above:
        _sample(parent.GetPrim(), "xformOp:translate", {1: Gf.Vec3d(0, 0, 3)})
    else:
        _sample(box, "xformOp:translate", {1: Gf.Vec3d(0, 0, 5)})
    begin, before = _drawn(box, 1)[2], _text(stage)
    with warnings.catch_warnings():
        warnings.simplefilter("error", errors.UsdsdgWarning)
        engine = playing(stage)
    for step in range(1, 11):
        engine.step(STEP)
        assert _drawn(box, 1 + step)[2] == pytest.approx(begin - fallen(step), abs=1e-3)
    engine.stop()
    assert _text(stage) == before


def test_all_ops_may_have_one_sample():
    """Scale and rotation too, in single ops and in a matrix."""
    stage = _stage(start=1)
    turned = Gf.Matrix4d(Gf.Rotation((0, 0, 1), 30), (0, 0, 5))
    ops = add(stage, "/World/ops", rotate=(0, 0, 0))
    _sample(ops, "xformOp:translate", {1: Gf.Vec3d(0, 0, 5)})
    _sample(ops, "xformOp:rotateXYZ", {1: Gf.Vec3f(0, 0, 30)})
    _sample(ops, "xformOp:scale", {1: Gf.Vec3f(0.5, 0.2, 0.1)})
    matrix = add(stage, "/World/matrix", at=(0, 0, 0))
    UsdGeom.Xformable(matrix).ClearXformOpOrder()
    scale = Gf.Matrix4d().SetScale((0.5, 0.2, 0.1))
    UsdGeom.Xformable(matrix).AddTransformOp().Set(scale * turned * Gf.Matrix4d().SetTranslate((3, 0, 0)), 1)
    before = _text(stage)
    engine = playing(stage)
    engine.advance(10 * STEP)
    for prim, x in ((ops, 0), (matrix, 3)):
        expected = scale * turned * Gf.Matrix4d().SetTranslate((x, 0, -fallen(10)))
        found = UsdGeom.XformCache(11).GetLocalToWorldTransform(prim)
        np.testing.assert_allclose(np.array(found), np.array(expected), atol=1e-3)
    engine.stop()
    assert _text(stage) == before


def test_a_fall_ends_on_a_floor_with_one_sample():
    stage = _stage(start=1)
    floor = add(stage, "/World/floor", scale=(5, 5, 0.1), body=False)
    _sample(floor, "xformOp:translate", {1: Gf.Vec3d(0, 0, 1.5)})
    box = add(stage, "/World/box")
    _sample(box, "xformOp:translate", {1: Gf.Vec3d(0, 0, 2)})
    engine = playing(stage)
    assert engine.rigid_bodies == ("/World/box",)
    assert engine._session is not None
    assert engine._session.scene.animated == ()
    engine.advance(1.0)
    assert _drawn(box, 61)[2] == pytest.approx(1.7, abs=2e-3)


@pytest.mark.parametrize("kind", ["samples", "spline"])
def test_a_dynamic_body_with_an_animation_is_drawn_where_physics_has_it(kind):
    stage = _stage()
    box = add(stage, "/World/box")
    xformable = UsdGeom.Xformable(box)
    up, scale = xformable.AddTranslateZOp(), xformable.GetOrderedXformOps()[1]
    xformable.SetXformOpOrder([up, scale])
    up = up.GetAttr()
    if kind == "spline":
        up.SetSpline(_spline(5, 9))
    else:
        up.Set(5.0, 0)
        up.Set(9.0, 60)
    before = _text(stage)
    with pytest.warns(errors.UsdsdgWarning, match="/World/box.*kinematicEnabled"):
        engine = playing(stage)
    for step in range(1, 11):
        engine.step(STEP)
        assert _drawn(box, step)[2] == pytest.approx(5 - fallen(step), abs=1e-3)
        assert position(box)[2] == pytest.approx(5 - fallen(step), abs=1e-3)
    engine.stop()
    assert _text(stage) == before
    assert up.Get(30) == 7


def test_a_play_begins_with_the_samples_at_its_time():
    stage = _stage()
    box = add(stage, "/World/box")
    _sample(box, "xformOp:translate", {0: Gf.Vec3d(0, 0, 5), 60: Gf.Vec3d(0, 0, 9)})
    engine = playing(stage)
    engine.stop()
    engine.play(time=0.5)
    engine.step(STEP)
    assert _drawn(box, 31)[2] == pytest.approx(7 - fallen(1), abs=1e-4)


def test_a_body_starts_again_from_its_sample():
    stage = _stage(start=1)
    box, other = add(stage, "/World/box"), add(stage, "/World/other", at=(3, 0, 5))
    _sample(box, "xformOp:translate", {1: Gf.Vec3d(0, 0, 5)})
    _sample(box, "physics:velocity", {1: Gf.Vec3f(2, 0, 0)})
    before = _text(stage)
    engine = playing(stage)
    engine.advance(10 * STEP)
    engine.reset(["/World/box"])
    engine.step(STEP)
    assert _drawn(box, 12) == pytest.approx([2 * STEP, 0, 5 - fallen(1)], abs=1e-4)
    assert _drawn(other, 12)[2] == pytest.approx(5 - fallen(11), abs=1e-3)
    engine.stop()
    assert _text(stage) == before


def test_a_sample_counts_more_than_the_default_value_of_a_weaker_layer():
    """As of an asset whose pose a scene sets, with one sample."""
    stage = _stage(start=1)
    box = add(stage, "/World/box", at=(0, 0, 1))
    layer = Sdf.Layer.CreateAnonymous()
    layer.TransferContent(stage.GetRootLayer())
    stage.GetRootLayer().subLayerPaths.append(layer.identifier)
    stage.RemovePrim("/World/box")
    box.GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, 5), 1)
    playing(stage).advance(10 * STEP)
    assert _drawn(box, 11)[2] == pytest.approx(5 - fallen(10), abs=1e-3)


@pytest.mark.parametrize("weaker", [True, False])
def test_samples_of_other_layers(weaker):
    """Those of weaker ones give way to what steps write; those of stronger ones are named."""
    stage = _stage(start=1)
    box = add(stage, "/World/box", at=(0, 0, 5))
    box.GetAttribute("xformOp:translate").Clear()
    layer = Sdf.Layer.CreateAnonymous()
    if weaker:
        stage.GetRootLayer().subLayerPaths.append(layer.identifier)
    with Usd.EditContext(stage, layer if weaker else stage.GetSessionLayer()):
        box.GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, 5), 1)
    before, sampled = _text(stage), layer.ExportToString()
    if weaker:
        engine = playing(stage)
        engine.advance(10 * STEP)
        assert _drawn(box, 11)[2] == pytest.approx(5 - fallen(10), abs=1e-3)
    else:
        with pytest.warns(errors.UsdsdgWarning, match=r"/World/box.xformOp:translate .*stronger.*samples"):
            engine = playing(stage)
    engine.stop()
    assert _text(stage) == before
    assert layer.ExportToString() == sampled


def test_a_body_below_a_moving_prim_does_not_go_along():
    stage = _stage()
    cart = UsdGeom.Xform.Define(stage, "/World/cart")
    cart.AddTranslateOp()
    cart.AddRotateZOp()
    _sample(cart.GetPrim(), "xformOp:translate", {0: Gf.Vec3d(1, 0, 0), 60: Gf.Vec3d(4, 2, 0)})
    _sample(cart.GetPrim(), "xformOp:rotateZ", {0: 0.0, 60: 90.0})
    box = add(stage, "/World/cart/box", at=(0, 0, 5))
    resting = add(stage, "/World/cart/resting", at=(0, 2, 5), gravity=False)
    with pytest.warns(errors.UsdsdgWarning, match="above them: /World/cart/box"):
        engine = playing(stage)
    for step in range(1, 21):
        engine.step(STEP)
        assert _drawn(box, step) == pytest.approx([1, 0, 5 - fallen(step)], abs=1e-3)
        assert _drawn(resting, step) == pytest.approx([1, 2, 5], abs=1e-5)


def test_samples_that_a_script_records_stay_and_disturb_nothing():
    stage = _stage()
    box = add(stage, "/World/box", at=(0, 0, 5))
    translate = box.GetAttribute("xformOp:translate")
    engine = playing(stage)
    for step in range(1, 21):
        engine.step(STEP)
        assert translate.Get()[2] == pytest.approx(5 - fallen(step), abs=1e-3)
        translate.Set(translate.Get(), 100 + 2 * step)  # at codes of the script's own
    engine.stop()
    assert translate.Get()[2] == 5
    assert [translate.Get(100 + 2 * step)[2] for step in range(1, 21)] == pytest.approx(
        [5 - fallen(step) for step in range(1, 21)], abs=1e-3
    )


@pytest.mark.parametrize(("moves", "kinematic"), crossed(["samples", "spline", "clips"], [True, False]))
def test_what_an_animation_moves_carries_a_box(tmp_path, moves, kinematic):
    """The box slips until friction has made it as fast: v² / (2 mu g)."""
    stage = _stage()
    platform = add(stage, "/World/platform", scale=(1, 1, 0.1), body=False)
    if kinematic:
        UsdPhysics.RigidBodyAPI.Apply(platform).CreateKinematicEnabledAttr(True)
    xformable = UsdGeom.Xformable(platform)
    along = xformable.AddTranslateXOp().GetAttr()
    xformable.SetXformOpOrder([xformable.GetOrderedXformOps()[-1], *xformable.GetOrderedXformOps()[:-1]])
    if moves == "spline":
        along.SetSpline(_spline(0, 0.3))
    elif moves == "samples":
        along.Set(0.0, 0)
        along.Set(0.3, 60)
    else:
        (tmp_path / "clip.usda").write_text(
            '#usda 1.0\ndef "p"\n{\n    double xformOp:translateX.timeSamples = {0: 0, 60: 0.3}\n}\n'
        )
        clip = Sdf.AssetPath(str(tmp_path / "clip.usda"))
        files = {"assetPaths": Sdf.AssetPathArray([clip]), "manifestAssetPath": clip, "primPath": "/p"}
        times = {"active": Vt.Vec2dArray([(0, 0)]), "times": Vt.Vec2dArray([(0, 0), (60, 60)])}
        platform.SetMetadata("clips", {"default": {**files, **times}})
    box = add(stage, "/World/box", at=(0, 0, 0.2))
    engine = playing(stage)
    engine.advance(60 * STEP)
    slip = 0.3**2 / (2 * 0.5 * 9.81)
    assert _drawn(platform, 60)[0] == pytest.approx(0.3)
    assert _drawn(box, 60)[0] == pytest.approx(0.3 - slip, abs=0.01)


@pytest.mark.parametrize("name", ["size", "points"])
def test_shapes_are_read_at_the_time_of_the_play(name):
    """A box falls onto the top at z = 2, which the fallback or no points would not give."""
    stage = _stage(start=1)
    if name == "size":
        ground = add(stage, "/World/ground", scale=(1, 1, 1), body=False)
        ground.GetAttribute("size").Set(4.0, 1)
    else:
        corners = np.array([[-5, -5, 2], [5, -5, 2], [5, 5, 2], [-5, 5, 2]], float)
        ground = mesh(stage, "/World/ground", corners, np.array([[0, 1, 2], [0, 2, 3]])).GetPrim()
        collide(ground, approximation="none")
        _sample(ground, "points", {1: Vt.Vec3fArray([Gf.Vec3f(*map(float, corner)) for corner in corners])})
    box = add(stage, "/World/box", at=(0, 0, 2.4))
    with warnings.catch_warnings():
        warnings.simplefilter("error", errors.UsdsdgWarning)
        playing(stage).advance(1.0)
    assert position(box)[2] == pytest.approx(2.1, abs=2e-3)


@pytest.mark.parametrize("name", ["size", "drive:linear:physics:targetPosition"])
def test_attributes_that_are_read_once_are_named_where_they_vary(name):
    stage = _stage()
    box = add(stage, "/World/box", at=(0, 0, 0.2))
    joint = UsdPhysics.PrismaticJoint.Define(stage, "/World/joint")
    joint.CreateBody1Rel().SetTargets([box.GetPath()])
    UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "linear").CreateTargetPositionAttr(0.0)
    prim = box if name == "size" else joint.GetPrim()
    prim.GetAttribute(name).Set(1.0, 0)
    prim.GetAttribute(name).Set(2.0, 60)
    with pytest.warns(errors.UsdsdgWarning, match=f"{prim.GetPath()}: .*time samples.*{name}"):
        playing(stage)


def test_instances_with_sampled_positions_fall_from_there():
    stage = _stage(start=1)
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/points")
    add(stage, "/World/points/box")
    stage.GetPrimAtPath("/World/points/box").GetAttribute("xformOp:translate").Clear()
    instancer.CreatePrototypesRel().SetTargets(["/World/points/box"])
    instancer.CreateProtoIndicesAttr().Set([0, 0], 1)
    instancer.CreatePositionsAttr().Set([Gf.Vec3f(0, 0, 5), Gf.Vec3f(2, 0, 6)], 1)
    before = _text(stage)
    engine = playing(stage)
    engine.advance(10 * STEP)
    found = np.array(instancer.GetPositionsAttr().Get(11))
    assert found[:, 2] == pytest.approx([5 - fallen(10), 6 - fallen(10)], abs=1e-3)
    engine.stop()
    assert _text(stage) == before


@pytest.mark.parametrize("kinematic", [False, True])
@pytest.mark.parametrize("nested", [False, True])
def test_bodies_without_size_are_named_and_nothing_else_is_said(kinematic, nested):
    stage = _stage()
    flat = add(stage, "/World/flat", at=(0, 0, 1), scale=(0, 0, 0))
    UsdPhysics.RigidBodyAPI(flat).CreateKinematicEnabledAttr(kinematic)
    if nested:
        add(stage, "/World/flat/below", at=(0, 0, 5), scale=(1, 1, 1))
    box = add(stage, "/World/box", at=(0, 0, 5))
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        playing(stage).advance(10 * STEP)
    assert position(box)[2] == pytest.approx(5 - fallen(10), abs=1e-3)
    assert all(issubclass(each.category, errors.UsdsdgWarning) for each in said), [str(each.message) for each in said]
    assert any("/World/flat" in str(each.message) and "scale" in str(each.message) for each in said)
