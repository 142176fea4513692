"""Simulated poses land in whatever ops a prim has, and nowhere else."""

from __future__ import annotations

from contextlib import nullcontext

import numpy as np
import pytest
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdPhysics

from tests.physics.scenes import DEVICE, add, collide, make_body, new_stage, playing, position, set_value, velocity
from usdsdg import errors
from usdsdg_physics import simulate
from usdsdg_physics.engine import NewtonEngine
from usdsdg_physics.writeback.stage_writer import StageWriter

OP = UsdGeom.XformOp
EULER_ORDERS = ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"]


def _thrown(prim: Usd.Prim) -> None:
    """Weightless, moving and tumbling, so that the pose after t seconds is known."""
    collide(prim)
    make_body(prim, gravity=False)
    UsdPhysics.RigidBodyAPI(prim).CreateVelocityAttr(Gf.Vec3f(1, 2, 3))
    UsdPhysics.RigidBodyAPI(prim).CreateAngularVelocityAttr(Gf.Vec3f(0, 0, 60))


def _check(stage: Usd.Stage, prim: Usd.Prim, before: Gf.Matrix4d, seconds: float = 0.5) -> None:
    """World pose after a throw: moved by v t, turned by ω t about the world's z through the moving center."""
    start = np.array(before)
    turn = np.array(Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(0, 0, 1), 60 * seconds)))
    expected = start @ turn
    expected[3, :3] = start[3, :3] + np.array([1, 2, 3]) * seconds
    found = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim))
    assert found == pytest.approx(expected, abs=2e-3)


def _cube(stage: Usd.Stage, path: str = "/World/cube") -> UsdGeom.Xformable:
    return UsdGeom.Xformable(stage.DefinePrim(path, "Cube"))


def _euler(order: str):
    def build(x: UsdGeom.Xformable) -> None:
        x.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
        x.AddXformOp(getattr(OP, f"TypeRotate{order}")).Set(Gf.Vec3f(10, 20, 30))
        x.AddScaleOp().Set(Gf.Vec3f(0.2, 0.2, 0.2))

    return build


def _orient(precision):
    def build(x: UsdGeom.Xformable) -> None:
        x.AddTranslateOp(precision).Set(x.GetOrderedXformOps()[0].GetAttr().GetTypeName().defaultValue)
        x.AddOrientOp(precision)
        kind = {OP.PrecisionDouble: Gf.Quatd, OP.PrecisionFloat: Gf.Quatf, OP.PrecisionHalf: Gf.Quath}[precision]
        x.GetOrderedXformOps()[1].Set(kind(Gf.Rotation(Gf.Vec3d(1, 1, 0), 40).GetQuat()))

    return build


def _matrix(x: UsdGeom.Xformable) -> None:
    matrix = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 2, 3), 50))
    x.AddTransformOp().Set(matrix * Gf.Matrix4d().SetTranslate((1, 2, 3)))


def _single_axes(x: UsdGeom.Xformable) -> None:
    x.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    for axis, angle in zip("ZYX", (30, 20, 10)):
        x.AddXformOp(getattr(OP, f"TypeRotate{axis}")).Set(float(angle))


def _only_translate(x: UsdGeom.Xformable) -> None:
    x.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))


def _nothing(x: UsdGeom.Xformable) -> None:
    pass


def _pivot(x: UsdGeom.Xformable) -> None:
    x.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    pivot = x.AddTranslateOp(opSuffix="pivot")
    pivot.Set(Gf.Vec3d(0.5, 0, 0))
    x.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, 30))
    x.AddScaleOp().Set(Gf.Vec3f(2, 2, 2))
    x.AddTranslateOp(opSuffix="pivot", isInverseOp=True)


def _rotate_first(x: UsdGeom.Xformable) -> None:
    x.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, 30))
    x.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))


def _lone_axis(x: UsdGeom.Xformable) -> None:
    x.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    x.AddRotateZOp().Set(25.0)
    x.AddScaleOp().Set(Gf.Vec3f(0.5, 0.5, 0.5))


def _mirrored(x: UsdGeom.Xformable) -> None:
    x.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    x.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, 30))
    x.AddScaleOp().Set(Gf.Vec3f(-2, 2, 2))


STACKS = {
    **{f"rotate{order}": _euler(order) for order in EULER_ORDERS},
    "orient double": _orient(OP.PrecisionDouble),
    "orient float": _orient(OP.PrecisionFloat),
    "orient half": _orient(OP.PrecisionHalf),
    "matrix": _matrix,
    "three axes": _single_axes,
    "translate only": _only_translate,
    "no ops": _nothing,
    "pivot": _pivot,
    "rotate before translate": _rotate_first,
    "one axis": _lone_axis,
    "mirrored": _mirrored,
}


@pytest.fixture(scope="module")
def thrown():
    """One cube per op stack, far apart, after half a second; and their matrices before."""
    stage = new_stage()
    prims, before = {}, {}
    for row, (name, build) in enumerate(STACKS.items()):
        parent = UsdGeom.Xform.Define(stage, f"/World/p{row}")
        parent.AddTranslateOp().Set(Gf.Vec3d(30.0 * row, 0, 0))
        parent.AddRotateXYZOp().Set(Gf.Vec3f(0, 90, 10 * row))
        parent.AddScaleOp().Set(Gf.Vec3f(0.5, 0.5, 0.5))
        build(_cube(stage, f"/World/p{row}/cube"))
        prims[name] = stage.GetPrimAtPath(f"/World/p{row}/cube")
        before[name] = UsdGeom.XformCache().GetLocalToWorldTransform(prims[name])
        _thrown(prims[name])
    orders = {name: list(UsdGeom.Xformable(prim).GetXformOpOrderAttr().Get() or []) for name, prim in prims.items()}
    exported = stage.GetRootLayer().ExportToString()
    engine = playing(stage)
    engine.advance(0.5)
    return stage, prims, before, orders, engine, exported


@pytest.mark.parametrize("name", STACKS)
def test_pose_lands_in_the_ops(thrown, name):
    """Half-float ops keep three digits; everything else is exact to the integrator."""
    stage, prims, before, *_ = thrown
    _check(stage, prims[name], before[name])


@pytest.mark.parametrize("name", [name for name in STACKS if name not in ("translate only", "no ops")])
def test_op_order_is_kept(thrown, name):
    """Only what has no place for the pose gets ops added, and no op is ever dropped."""
    _, prims, _, orders, *_ = thrown
    now = list(UsdGeom.Xformable(prims[name]).GetXformOpOrderAttr().Get())
    if name in ("rotate before translate", "one axis"):
        assert [op for op in now if op in orders[name]] == orders[name]
    else:
        assert now == orders[name]


def test_stop_restores_every_layer_to_the_letter(thrown):
    """Runs last in this module: the exported layer is the one from before play."""
    stage, _, _, _, engine, exported = thrown
    engine.stop()
    assert stage.GetRootLayer().ExportToString() == exported


def test_velocities_are_world_vectors_of_the_prims_units():
    stage = new_stage(meters_per_unit=0.01)
    prim = add(stage, "/World/box", rotate=(90, 0, 0), scale=(10, 10, 10), gravity=False)
    prim.GetAttribute("physics:velocity").Set(Gf.Vec3f(100, 0, 50))
    prim.GetAttribute("physics:angularVelocity").Set(Gf.Vec3f(0, 0, 90))
    playing(stage).advance(1.0)
    assert position(prim) == pytest.approx([100, 0, 50], abs=0.01)
    assert velocity(prim) == pytest.approx([100, 0, 50], abs=1e-3)
    assert prim.GetAttribute("physics:angularVelocity").Get() == pytest.approx((0, 0, 90), abs=0.01)


def test_writes_go_to_the_edit_target():
    stage = new_stage()
    prim = add(stage, "/World/box", at=(0, 0, 5))
    root = stage.GetRootLayer().ExportToString()
    stage.SetEditTarget(stage.GetSessionLayer())
    engine = playing(stage)
    engine.advance(0.2)
    assert position(prim)[2] < 5
    assert stage.GetRootLayer().ExportToString() == root
    engine.stop()
    assert not stage.GetSessionLayer().rootPrims
    assert position(prim)[2] == 5


def test_only_bodies_that_moved_are_written():
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(5, 5, 0.1), body=False)
    add(stage, "/World/still", at=(0, 0, 0.1), gravity=False)
    falling = add(stage, "/World/falling", at=(2, 0, 5))
    engine = playing(stage)
    engine.advance(1 / 60)
    written = []

    def hear(notice, sender):
        written.extend(notice.GetChangedInfoOnlyPaths())

    listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, hear, stage)
    engine.advance(1 / 60)
    listener.Revoke()
    assert {path.GetPrimPath() for path in written} == {falling.GetPath()}
    # What falls keeps its rotation and its spin.
    assert {path.name for path in written} == {"xformOp:translate", "physics:velocity"}


def test_a_rotation_is_written_when_a_body_only_turns():
    stage = new_stage()
    prim = add(stage, "/World/box", rotate=(0, 0, 0), gravity=False)
    set_value(prim, "physics:angularVelocity", Gf.Vec3f(0, 0, 60))
    engine = playing(stage)
    engine.advance(0.5)
    set_value(prim, "physics:velocity", Gf.Vec3f(1, 0, 0))
    engine.advance(0.25)
    assert np.array(prim.GetAttribute("xformOp:rotateXYZ").Get()) == pytest.approx([0, 0, 45], abs=0.1)
    assert position(prim) == pytest.approx([0.25, 0, 0], abs=1e-3)


def test_body_below_a_moving_body():
    """The child keeps its own world motion although its parent moves away from under it."""
    stage = new_stage()
    add(stage, "/World/parent", gravity=False)
    child = add(stage, "/World/parent/child", at=(50, 0, 0), gravity=False)
    before = position(child)
    set_value(stage.GetPrimAtPath("/World/parent"), "physics:velocity", Gf.Vec3f(3, 0, 0))
    set_value(child, "physics:velocity", Gf.Vec3f(0, 1, 0))
    playing(stage).advance(1.0)
    assert position(child) == pytest.approx(before + np.array([0, 1, 0]), abs=1e-4)


def test_time_samples_and_comments_of_other_attributes_stay():
    stage = new_stage()
    prim = add(stage, "/World/box", at=(0, 0, 5))
    prim.CreateAttribute("user:note", Sdf.ValueTypeNames.String).Set("keep me")
    engine = playing(stage)
    engine.advance(0.1)
    engine.stop()
    assert prim.GetAttribute("user:note").Get() == "keep me"
    assert not prim.GetAttribute("physics:velocity").HasAuthoredValue()


def test_stronger_opinion_is_named():
    stage = new_stage()
    prim = add(stage, "/World/box", at=(0, 0, 5))
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        set_value(prim, "xformOp:translate", Gf.Vec3d(0, 0, 3))
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning, match="/World/box.xformOp:translate.*stronger"):
        playing(stage)
    errors.forget_warnings()


@pytest.mark.parametrize("listens", [False, True])
def test_several_steps_in_one_advance_leave_what_single_steps_leave(listens):
    def simulate(calls, seconds):
        stage = new_stage()
        add(stage, "/World/ground", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False)
        for i in range(6):
            add(stage, f"/World/b{i}", at=(0.05 * i, 0, 0.3 + 0.25 * i), rotate=(10 * i, 20, 0))
        engine = playing(stage)
        seen = []
        if listens:
            engine.subscribe_step(lambda dt: seen.append(tuple(position(stage.GetPrimAtPath("/World/b5")))))
        for _ in range(calls):
            engine.advance(seconds)
        return stage.GetRootLayer().ExportToString(), seen

    single, each = simulate(30, 1 / 60)
    several, every = simulate(6, 5 / 60)
    assert several == single
    assert every == each
    assert len(set(every)) == (30 if listens else 0)


@pytest.mark.parametrize("velocities", [False, True])
def test_an_unread_stage_is_written_at_the_end_with_velocities_that_were_set_within(velocities):
    def simulate(unread):
        stage = new_stage()
        add(stage, "/World/ground", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False)
        prims = [add(stage, f"/World/b{i}", at=(0.05 * i, 0, 0.3 + 0.25 * i), rotate=(10 * i, 20, 0)) for i in range(4)]
        engine = NewtonEngine(stage, device=DEVICE, writes_velocities=lambda: velocities)
        engine.play()
        heights = []

        def on_step(dt):
            heights.append(position(prims[3])[2])
            if len(heights) % 5 == 3:
                set_value(prims[1], "physics:velocity", Gf.Vec3f(0.5, 0, 2 + 0.1 * len(heights)))

        engine.subscribe_step(on_step)
        engine.advance(1 / 60)
        with engine.stage_unread() if unread else nullcontext():
            for _ in range(12):
                engine.advance(1 / 60)
        left = [position(prim) for prim in prims]
        engine.advance(1 / 60)
        return heights, left, stage.GetRootLayer().ExportToString()

    seen, left, final = simulate(unread=True)
    heights, expected, text = simulate(unread=False)
    assert final == text
    np.testing.assert_array_equal(left, expected)
    assert len(set(heights)) == 14
    assert len(set(seen)) == 2


def test_a_simulation_that_nobody_watches_is_written_once(monkeypatch):
    def simulated(on_frame):
        stage = new_stage()
        add(stage, "/World/ground", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False)
        for i in range(3):
            add(stage, f"/World/b{i}", at=(0.05 * i, 0, 0.3 + 0.25 * i), rotate=(10 * i, 20, 0))
        # The last frame may be over before a step is due.
        steps = simulate(stage, 0.25, frames_per_second=100, on_frame=on_frame)
        return steps, stage.GetRootLayer().ExportToString()

    writes, original = [], StageWriter.write
    monkeypatch.setattr(StageWriter, "write", lambda self, *state: (writes.append(1), original(self, *state)))
    unwatched = simulated(None)
    assert len(writes) == 1
    assert unwatched == simulated(lambda frame: None)
    assert len(writes) == 1 + unwatched[0]


@pytest.mark.parametrize("above", [False, True])
def test_a_scale_that_deforms_a_turning_body_is_named(above):
    errors.forget_warnings()
    stage = new_stage()
    if above:
        UsdGeom.Xform.Define(stage, "/World/group").AddScaleOp().Set(Gf.Vec3f(1, 2, 1))
        add(stage, "/World/group/box", rotate=(0, 0, 30))
    else:
        cube = UsdGeom.Cube.Define(stage, "/World/group/box")
        for op, value in ((cube.AddScaleOp(), Gf.Vec3f(1, 2, 1)), (cube.AddRotateXYZOp(), Gf.Vec3f(0, 0, 30))):
            op.Set(value)
        cube.SetXformOpOrder([*cube.GetOrderedXformOps()])
        collide(cube.GetPrim())
        make_body(cube.GetPrim())
    with pytest.warns(errors.UsdsdgWarning, match="/World/group/box is scaled unevenly"):
        playing(stage)
    errors.forget_warnings()


@pytest.mark.parametrize("order", ["orient", "XYZ"])
def test_a_deformed_body_with_a_pivot_is_drawn_where_it_is(order):
    """Its center flies on straight, though no rotation below an uneven scale is that of the body.

    The axes are those of the rotation that is nearest: no other one makes a better matrix, by more than rounding.
    """
    stage = new_stage()
    UsdGeom.Xform.Define(stage, "/World/group").AddScaleOp().Set(Gf.Vec3f(1, 2, 1))
    cube = UsdGeom.Cube.Define(stage, "/World/group/box")
    cube.AddTranslateOp().Set(Gf.Vec3d(0.3, 0.2, 0.1))
    cube.AddTranslateOp(opSuffix="pivot").Set(Gf.Vec3d(1, 2, 3))
    rotate = cube.AddOrientOp() if order == "orient" else cube.AddRotateXYZOp()
    rotate.Set(Gf.Quatf(1) if order == "orient" else Gf.Vec3f(0))
    cube.AddTranslateOp(opSuffix="pivot", isInverseOp=True)
    prim = cube.GetPrim()
    start = position(prim)
    collide(prim)
    make_body(prim, gravity=False)
    UsdPhysics.RigidBodyAPI(prim).CreateVelocityAttr(Gf.Vec3f(1, 2, 3))
    UsdPhysics.RigidBodyAPI(prim).CreateAngularVelocityAttr(Gf.Vec3f(0, 0, 90))
    UsdPhysics.MassAPI.Apply(prim).CreateDiagonalInertiaAttr(Gf.Vec3f(1, 1, 1))
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning, match="is scaled unevenly"):
        playing(stage).advance(0.5)
    errors.forget_warnings()
    assert position(prim) == pytest.approx(start + np.array((0.5, 1.0, 1.5)), abs=1e-4)
    # A turn of 45 degrees of the box, drawn through the scale (1, 2, 1) of the group, is S R S⁻¹ in the group.
    cosine = np.sqrt(0.5)
    wanted = np.array([[cosine, cosine / 2, 0], [-2 * cosine, cosine, 0], [0, 0, 1]])
    wanted /= np.linalg.norm(wanted, axis=1, keepdims=True)
    drawn = np.array(UsdGeom.Xformable(prim).GetLocalTransformation())[:3, :3]
    angles = np.radians(np.linspace(0.0, 90.0, 181))
    turned = (np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) for a in angles)
    least = min(((wanted[:2, :2] - matrix) ** 2).sum() for matrix in turned)
    assert ((wanted - drawn) ** 2).sum() <= least + 1e-3


def test_a_layer_that_may_not_be_edited_is_named():
    stage = new_stage()
    add(stage, "/World/box")
    stage.GetRootLayer().SetPermissionToEdit(False)
    with pytest.raises(errors.PhysicsError, match=r"may not be edited.*SetPermissionToEdit"):
        playing(stage)
    stage.SetEditTarget(stage.GetSessionLayer())
    playing(stage).advance(1 / 60)
    assert position(stage.GetPrimAtPath("/World/box"))[2] < 0


def test_listeners_hear_once_that_velocities_came_to_the_stage():
    heard = {}
    for count in (2, 9):
        stage = new_stage()
        for index in range(count):
            add(stage, f"/World/box_{index}", at=(0, 0, index), rotate=(0, 0, 0))
        notices = []

        def listen(notice, sender, notices=notices):
            notices.append([str(path) for path in notice.GetResyncedPaths()])

        listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, listen, stage)
        engine = playing(stage)
        heard[count] = notices[:]
        listener.Revoke()
        engine.stop()
    assert len(heard[2]) == len(heard[9]) == 1
    assert {f"/World/box_{index}.physics:velocity" for index in range(9)} <= set(heard[9][0])
