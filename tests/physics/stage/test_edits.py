"""Edits of the stage between steps take effect at the next step."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics

from tests.physics.mechanisms import drive, joint
from tests.physics.scenes import (
    DEVICE,
    add,
    collide,
    fallen,
    make_body,
    new_stage,
    playing,
    position,
    set_value,
    velocity,
)
from tests.sampled_cases import crossed
from usdsdg import errors
from usdsdg.errors import PhysicsError
from usdsdg_physics import NewtonEngine, simulate

STEP = 1 / 60


def test_velocity_set_while_playing():
    stage = new_stage()
    prim = add(stage, "/World/box", rotate=(0, 0, 90), gravity=False)
    engine = playing(stage)
    engine.advance(STEP)
    set_value(prim, "physics:velocity", Gf.Vec3f(0, 6, 0))
    engine.advance(STEP)
    assert position(prim) == pytest.approx([0, 0.1, 0], abs=1e-5)


@pytest.mark.parametrize("schema", ["SemanticsLabelsAPI", "PhysxRigidBodyAPI"])
@pytest.mark.parametrize("at_parent", [False, True])
def test_pose_and_velocity_set_with_a_schema_that_is_applied(schema, at_parent):
    """An applied schema makes USD announce the whole prim anew, with what is below it."""
    stage = new_stage()
    prim = add(stage, "/World/box", gravity=False)
    engine = playing(stage)
    engine.advance(STEP)
    labeled = prim.GetParent() if at_parent else prim
    labeled.AddAppliedSchema(f"{schema}:class" if schema == "SemanticsLabelsAPI" else schema)
    set_value(prim, "xformOp:translate", Gf.Vec3d(1, 2, 3))
    set_value(prim, "physics:velocity", Gf.Vec3f(0, 6, 0))
    engine.advance(STEP)
    assert position(prim) == pytest.approx([1, 2.1, 3], abs=1e-5)


def test_velocity_set_between_play_and_the_first_step():
    stage = new_stage()
    prim = add(stage, "/World/box", gravity=False)
    engine = playing(stage)
    set_value(prim, "physics:velocity", Gf.Vec3f(0, 6, 0))
    engine.advance(STEP)
    assert position(prim) == pytest.approx([0, 0.1, 0], abs=1e-5)
    engine.stop()
    assert not prim.GetAttribute("physics:velocity").HasAuthoredValue()


def test_velocity_of_a_body_at_rest_wakes_it():
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(5, 5, 0.1), body=False)
    prim = add(stage, "/World/box", at=(0, 0, 0.1))
    engine = playing(stage)
    engine.advance(1.0)
    assert not velocity(prim).any()
    set_value(prim, "physics:velocity", Gf.Vec3f(0, 0, 2))
    engine.advance(0.2)
    assert position(prim)[2] == pytest.approx(0.1 + 2 * 0.2 - 9.81 * 0.02, abs=0.02)


def test_body_at_rest_falls_when_its_support_goes():
    """Both ways of losing it: the collider is switched off, and it is moved away."""
    for remove in (
        lambda ground: set_value(ground, "physics:collisionEnabled", False),
        lambda ground: set_value(ground, "xformOp:translate", Gf.Vec3d(0, 0, -9)),
    ):
        stage = new_stage()
        ground = add(stage, "/World/ground", at=(0, 0, -0.1), scale=(5, 5, 0.1), body=False)
        prim = add(stage, "/World/box", at=(0, 0, 0.1))
        engine = playing(stage)
        engine.advance(1.0)
        assert position(prim)[2] == pytest.approx(0.1, abs=1e-3)
        remove(ground)
        engine.advance(0.5)
        assert position(prim)[2] == pytest.approx(0.1 - 9.81 / 8, abs=0.05)


def test_teleport_by_own_op_and_by_an_ancestor():
    stage = new_stage()
    group = UsdGeom.Xform.Define(stage, "/World/group")
    shift = group.AddTranslateOp()
    prim = add(stage, "/World/group/box", gravity=False)
    engine = playing(stage)
    engine.advance(STEP)
    set_value(prim, "xformOp:translate", Gf.Vec3d(1, 0, 0))
    engine.advance(STEP)
    assert position(prim) == pytest.approx([1, 0, 0], abs=1e-5)
    shift.Set(Gf.Vec3d(0, 5, 0))
    engine.advance(STEP)
    assert position(prim) == pytest.approx([1, 5, 0], abs=1e-5)
    set_value(prim, "physics:velocity", Gf.Vec3f(0, 0, 6))
    engine.advance(STEP)
    assert position(prim) == pytest.approx([1, 5, 0.1], abs=1e-4)


def test_gravity_switch_of_one_body():
    stage = new_stage()
    switched, other = add(stage, "/World/a", at=(0, 0, 9)), add(stage, "/World/b", at=(5, 0, 9), gravity=False)
    engine = playing(stage)
    engine.advance(STEP)
    set_value(switched, "physics:velocity", Gf.Vec3f(0))
    set_value(switched, "physxRigidBody:disableGravity", True)
    set_value(other, "physxRigidBody:disableGravity", False)
    at = position(switched)
    engine.advance(0.5)
    assert position(switched) == pytest.approx(at, abs=1e-6)
    assert position(other)[2] == pytest.approx(9 - fallen(30), abs=1e-3)


def test_damping_change():
    """Half a second at 2/s leaves e^-1 of the speed."""
    stage = new_stage()
    prim = add(stage, "/World/box", gravity=False)
    prim.CreateAttribute("physxRigidBody:linearDamping", Sdf.ValueTypeNames.Float).Set(0.0)
    set_value(prim, "physics:velocity", Gf.Vec3f(1, 0, 0))
    engine = playing(stage)
    engine.advance(0.5)
    assert velocity(prim)[0] == pytest.approx(1.0, abs=1e-4)
    set_value(prim, "physxRigidBody:linearDamping", 2.0)
    engine.advance(0.5)
    assert velocity(prim)[0] == pytest.approx(np.exp(-1), rel=0.01)


def test_scene_gravity_change():
    stage = new_stage()
    prim = add(stage, "/World/box", at=(0, 0, 0))
    engine = playing(stage)
    engine.advance(STEP)
    set_value(prim, "physics:velocity", Gf.Vec3f(0))
    scene = UsdPhysics.Scene(stage.GetPrimAtPath("/PhysicsScene"))
    scene.CreateGravityDirectionAttr(Gf.Vec3f(1, 0, 0))
    scene.CreateGravityMagnitudeAttr(2.0)
    engine.advance(1.0)
    assert velocity(prim) == pytest.approx([2, 0, 0], abs=1e-3)


def test_camera_collider_pushes_bodies_out():
    """The object-based script: a sphere under a camera, switched off, moved with it, switched on for four frames."""
    stage = new_stage()
    camera = UsdGeom.Camera.Define(stage, "/World/camera")
    at = camera.AddTranslateOp()
    at.Set(Gf.Vec3d(20, 0, 0))
    sphere = stage.DefinePrim("/World/camera/sphere", "Sphere")
    sphere.GetAttribute("radius").Set(1.0)
    collide(sphere)
    sphere.GetAttribute("physics:collisionEnabled").Set(False)
    prim = add(stage, "/World/box", at=(0.5, 0, 0), gravity=False)
    engine = playing(stage)
    engine.advance(STEP)
    at.Set(Gf.Vec3d(0, 0, 0))
    engine.advance(4 * STEP)
    assert position(prim) == pytest.approx([0.5, 0, 0], abs=1e-5)
    set_value(sphere, "physics:collisionEnabled", True)
    engine.advance(20 * STEP)
    assert np.linalg.norm(position(prim)) > 0.9
    set_value(sphere, "physics:collisionEnabled", False)
    set_value(prim, "physics:velocity", Gf.Vec3f(0))
    set_value(prim, "xformOp:translate", Gf.Vec3d(0.2, 0, 0))
    engine.advance(4 * STEP)
    assert position(prim) == pytest.approx([0.2, 0, 0], abs=1e-4)


def test_step_rate_change_while_playing():
    """Eight steps of 1/320 s make up 0.025 s, as in the motion-blur capture."""
    stage = new_stage()
    prim = add(stage, "/World/box", gravity=False)
    set_value(prim, "physics:velocity", Gf.Vec3f(1, 0, 0))
    engine = playing(stage)
    assert engine.advance(STEP) == 1
    rate = stage.GetPrimAtPath("/PhysicsScene").GetAttribute("physxScene:timeStepsPerSecond")
    rate.Set(320)
    dts = []
    engine.subscribe_step(dts.append)
    assert [engine.advance(0.025 / 8) for _ in range(8)] == [1] * 8
    assert dts == pytest.approx([1 / 320] * 8)
    rate.Set(60)
    assert engine.advance(STEP) == 1
    assert position(prim)[0] == pytest.approx(2 / 60 + 0.025, abs=1e-5)


def test_left_over_time_is_kept():
    stage = new_stage()
    add(stage, "/World/box", gravity=False)
    engine = playing(stage)
    assert [engine.advance(0.5 / 60) for _ in range(4)] == [0, 1, 0, 1]
    assert engine.advance(1.0) == 60


def test_zero_step_rate_is_an_error():
    stage = new_stage()
    add(stage, "/World/box")
    engine = playing(stage)
    set_value(stage.GetPrimAtPath("/PhysicsScene"), "physxScene:timeStepsPerSecond", 0)
    with pytest.raises(PhysicsError, match=r"/PhysicsScene.*timeStepsPerSecond"):
        engine.advance(STEP)


def test_new_body_and_removed_body_while_playing():
    stage = new_stage()
    first = add(stage, "/World/first", at=(0, 0, 0), gravity=False)
    set_value(first, "physics:velocity", Gf.Vec3f(1, 0, 0))
    engine = playing(stage)
    engine.advance(0.5)
    late = add(stage, "/World/late", at=(0, 9, 0))
    engine.advance(0.5)
    assert position(first)[0] == pytest.approx(1.0, abs=1e-4)
    assert position(late)[2] == pytest.approx(-fallen(30), abs=1e-3)
    stage.RemovePrim("/World/late")
    engine.advance(0.5)
    assert position(first)[0] == pytest.approx(1.5, abs=1e-4)
    assert engine.rigid_bodies == ("/World/first",)


def test_rescaled_body_collides_with_its_new_size():
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(5, 5, 0.1), body=False)
    prim = add(stage, "/World/box", at=(0, 0, 0.1))
    engine = playing(stage)
    engine.advance(0.2)
    set_value(prim, "xformOp:scale", Gf.Vec3f(0.3, 0.3, 0.3))
    set_value(prim, "xformOp:translate", Gf.Vec3d(0, 0, 1))
    engine.advance(1.0)
    assert position(prim)[2] == pytest.approx(0.3, abs=2e-3)
    assert tuple(prim.GetAttribute("xformOp:scale").Get()) == pytest.approx((0.3, 0.3, 0.3))


def test_changes_that_do_not_concern_physics_do_not_rebuild():
    stage = new_stage()
    prim = add(stage, "/World/box", gravity=False)
    engine = playing(stage)
    engine.advance(STEP)
    world = engine._session.world
    UsdGeom.Gprim(prim).CreateDisplayColorAttr([(1, 0, 0)])
    UsdGeom.Imageable(prim).MakeInvisible()
    stage.DefinePrim("/World/light", "SphereLight")
    UsdGeom.ModelAPI.Apply(prim)
    engine.advance(STEP)
    assert engine._session.world is world


def test_kinematic_body_carries_what_stands_on_it():
    """It reaches the authored pose within one step and drags by friction; it never moves by itself."""
    stage = new_stage()
    plate = add(stage, "/World/plate", at=(0, 0, -0.1), scale=(2, 2, 0.1))
    UsdPhysics.RigidBodyAPI(plate).CreateKinematicEnabledAttr(True)
    prim = add(stage, "/World/box", at=(0, 0, 0.1))
    engine = playing(stage)
    engine.advance(0.5)
    assert position(plate) == pytest.approx([0, 0, -0.1])
    for frame in range(1, 61):
        set_value(plate, "xformOp:translate", Gf.Vec3d(0.5 * frame / 60, 0, -0.1))
        engine.advance(STEP)
    assert position(plate) == pytest.approx([0.5, 0, -0.1], abs=1e-6)
    assert position(prim)[0] == pytest.approx(0.5, abs=0.05)
    assert position(prim)[2] == pytest.approx(0.1, abs=2e-3)


@pytest.mark.parametrize(
    ("written", "attribute"), crossed([True, False], ["physics:kinematicEnabled", "physics:rigidBodyEnabled"])
)
def test_a_body_that_is_stopped_carries_nothing_and_begins_at_rest_when_it_is_let_go(attribute, written):
    """A kinematic body without a new pose has the velocity 0, as in PhysX."""
    stage = new_stage()
    plate = add(stage, "/World/plate", at=(0, 0, 2), scale=(1, 1, 0.1))
    set_value(plate, "physics:velocity", Gf.Vec3f(1, 0, 0))
    authored = stage.GetRootLayer().ExportToString()
    engine = NewtonEngine(stage, device=DEVICE, writes_velocities=lambda: written)
    engine.play()
    engine.advance(12 * STEP)
    at = position(plate)
    above = tuple(at + np.array([0, 0, 0.2]))
    flag = plate.CreateAttribute(attribute, Sdf.ValueTypeNames.Bool, custom=False)
    flag.Set(attribute == "physics:kinematicEnabled")
    box = add(stage, "/World/box", at=above)
    engine.advance(30 * STEP)
    assert position(plate) == pytest.approx(at, abs=1e-6)
    assert velocity(plate) == pytest.approx([0, 0, 0] if written else [1, 0, 0])
    assert position(box) == pytest.approx(above, abs=1e-3)
    stage.RemovePrim("/World/box")
    flag.Set(not flag.Get())
    engine.advance(30 * STEP)
    assert position(plate) == pytest.approx(at - (0, 0, fallen(30)), abs=2e-3)
    engine.stop()
    plate.RemoveProperty(attribute)
    assert stage.GetRootLayer().ExportToString() == authored


def test_a_velocity_that_is_set_on_a_stopped_body_moves_its_surface():
    """As in PhysX (ovphysx 0.7.0), where one that has it from the start carries a box to 0.9 m within a second."""
    stage = new_stage()
    plate = add(stage, "/World/plate", at=(0, 0, -0.1), scale=(9, 9, 0.1), gravity=False)
    box = add(stage, "/World/box", at=(0, 0, 0.1))
    engine = playing(stage)
    engine.advance(STEP)
    UsdPhysics.RigidBodyAPI(plate).CreateKinematicEnabledAttr(True)
    engine.advance(STEP)
    set_value(plate, "physics:velocity", Gf.Vec3f(1, 0, 0))
    engine.advance(30 * STEP)
    UsdPhysics.MassAPI.Apply(box).CreateMassAttr(2.0)
    engine.advance(30 * STEP)
    assert position(box)[0] == pytest.approx(1.0 - 1.0 / (2 * 0.5 * 9.81), rel=0.02)
    assert position(plate)[0] == pytest.approx(0.0, abs=1e-9)


def _turn_filter_around(stage):
    scene = stage.GetPrimAtPath("/PhysicsScene")
    scene.CreateAttribute("physxScene:invertCollisionGroupFilter", Sdf.ValueTypeNames.Bool).Set(True)


def _filter_above(stage):
    pairs = UsdPhysics.FilteredPairsAPI(stage.GetPrimAtPath("/World/tray")).GetFilteredPairsRel()
    pairs.SetTargets([Sdf.Path("/World/ground")])


@pytest.mark.parametrize("edit", [_turn_filter_around, _filter_above])
def test_filters_of_groups_and_of_prims_above_bodies_are_edited_while_playing(edit):
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False)
    UsdPhysics.FilteredPairsAPI.Apply(UsdGeom.Xform.Define(stage, "/World/tray").GetPrim()).CreateFilteredPairsRel()
    box = add(stage, "/World/tray/box", at=(0, 0, 0.1))
    for name, path in (("bodies", "/World/tray"), ("grounds", "/World/ground")):
        group = UsdPhysics.CollisionGroup.Define(stage, f"/World/{name}")
        group.GetCollidersCollectionAPI().CreateIncludesRel().AddTarget(path)
    engine = playing(stage)
    engine.advance(15 * STEP)
    assert position(box)[2] == pytest.approx(0.1, abs=1e-3)
    edit(stage)
    engine.advance(30 * STEP)
    assert position(box)[2] == pytest.approx(0.1 - fallen(30), abs=2e-3)


def _remove_group(stage):
    stage.RemovePrim("/World/grounds")


def _deactivate_group(stage):
    stage.GetPrimAtPath("/World/bodies").SetActive(False)


def _remove_filter(stage):
    stage.GetPrimAtPath("/World/tray").RemoveAPI(UsdPhysics.FilteredPairsAPI)


@pytest.mark.parametrize("edit", [_remove_group, _deactivate_group, _remove_filter])
def test_what_a_filter_kept_apart_collides_when_the_filter_goes_while_playing(edit):
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False)
    box = add(stage, "/World/tray/box", at=(0, 0, 0.5))
    if edit is _remove_filter:
        api = UsdPhysics.FilteredPairsAPI.Apply(stage.GetPrimAtPath("/World/tray"))
        api.CreateFilteredPairsRel().AddTarget("/World/ground")
    else:
        bodies = UsdPhysics.CollisionGroup.Define(stage, "/World/bodies")
        bodies.GetCollidersCollectionAPI().CreateIncludesRel().AddTarget("/World/tray")
        grounds = UsdPhysics.CollisionGroup.Define(stage, "/World/grounds")
        grounds.GetCollidersCollectionAPI().CreateIncludesRel().AddTarget("/World/ground")
        bodies.CreateFilteredGroupsRel().AddTarget("/World/grounds")
    engine = playing(stage)
    engine.advance(10 * STEP)
    errors.forget_warnings()
    edit(stage)
    engine.advance(1.5)
    errors.forget_warnings()
    assert position(box)[2] == pytest.approx(0.1, abs=1e-3)


def test_self_collisions_of_an_articulation_are_turned_on_while_playing():
    stage = new_stage()
    robot = UsdGeom.Xform.Define(stage, "/World/robot").GetPrim()
    UsdPhysics.ArticulationRootAPI.Apply(robot)
    collisions = robot.CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool)
    collisions.Set(False)
    for name, at in (("base", (0, 3, 0)), ("slider", (-1, 0, 0)), ("wall", (0.5, 0, 0))):
        add(stage, f"/World/robot/{name}", at=at, gravity=False)
    joint(stage, "/World/robot/fix", UsdPhysics.FixedJoint, "", "/World/robot/base", (0, 3, 0))
    joint(stage, "/World/robot/hold", UsdPhysics.FixedJoint, "/World/robot/base", "/World/robot/wall", (0, 3, 0))
    slide = joint(
        stage, "/World/robot/slide", UsdPhysics.PrismaticJoint, "/World/robot/base", "/World/robot/slider", (-1, 0, 0)
    )
    drive(slide, "linear", damping=1e4, target_velocity=1.0, max_force=10.0)
    engine, slider = playing(stage), stage.GetPrimAtPath("/World/robot/slider")
    engine.advance(0.5)
    collisions.Set(True)
    engine.advance(2.0)
    assert position(slider)[0] == pytest.approx(0.3, abs=2e-3)
    collisions.Set(False)
    engine.advance(1.0)
    assert position(slider)[0] > 0.7


def test_collider_of_a_body_moves_on_it():
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(5, 5, 0.1), body=False)
    body = UsdGeom.Xform.Define(stage, "/World/body")
    body.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0.1))
    part = add(stage, "/World/body/part", body=False)
    make_body(body.GetPrim())
    engine = playing(stage)
    engine.advance(0.5)
    assert position(body.GetPrim())[2] == pytest.approx(0.1, abs=1e-3)
    set_value(part, "xformOp:translate", Gf.Vec3d(0, 0, 0.05))
    engine.advance(0.5)
    assert position(body.GetPrim())[2] == pytest.approx(0.05, abs=3e-3)


def test_the_mass_of_a_collider_moves_with_it():
    """A dumbbell turns about the middle of its two ends, wherever these are; the velocity of that is zero."""
    stage = new_stage()
    body = UsdGeom.Xform.Define(stage, "/World/body")
    body.AddTranslateOp().Set(Gf.Vec3d(0, 0, 5))
    add(stage, "/World/body/left", at=(-0.5, 0, 0), body=False)
    right = add(stage, "/World/body/right", at=(0.5, 0, 0), body=False)
    make_body(body.GetPrim(), gravity=False)
    set_value(body.GetPrim(), "physics:angularVelocity", Gf.Vec3f(0, 0, 90))
    engine = playing(stage)
    engine.advance(STEP)
    set_value(right, "xformOp:translate", Gf.Vec3d(1.5, 0, 0))
    engine.advance(STEP)
    assert engine.mass_properties(["/World/body"]).center[0] == pytest.approx([0.5, 0, 0])
    center = Gf.Vec3d(0.5, 0, 0)
    start = UsdGeom.XformCache().GetLocalToWorldTransform(body.GetPrim()).Transform(center)
    engine.advance(1.0)
    end = UsdGeom.XformCache().GetLocalToWorldTransform(body.GetPrim()).Transform(center)
    assert tuple(end) == pytest.approx(tuple(start), abs=1e-4)


def test_set_in_a_step_listener_takes_effect_at_the_next_step():
    stage = new_stage()
    prim = add(stage, "/World/box", gravity=False)
    engine = playing(stage)
    unsubscribe = engine.subscribe_step(lambda dt: set_value(prim, "physics:velocity", Gf.Vec3f(6, 0, 0)))
    engine.advance(STEP)
    assert position(prim)[0] == 0
    engine.advance(STEP)
    assert position(prim)[0] == pytest.approx(0.1, abs=1e-5)
    unsubscribe()
    set_value(prim, "physics:velocity", Gf.Vec3f(0))
    engine.advance(2 * STEP)
    assert position(prim)[0] == pytest.approx(0.1, abs=1e-5)


def test_play_stop_play():
    stage = new_stage()
    prim = add(stage, "/World/box", at=(0, 0, 5))
    engine = playing(stage)
    engine.advance(0.5)
    first = position(prim)
    engine.play()
    assert position(prim) == pytest.approx(first)
    engine.stop()
    assert position(prim) == pytest.approx([0, 0, 5])
    engine.stop()
    engine.play()
    engine.advance(0.5)
    assert (position(prim) == first).all()


@pytest.mark.parametrize("new_path", ["/World/other", "/World/group/box"])
def test_what_is_renamed_while_playing_is_restored_where_it_is_then(new_path):
    stage = new_stage()
    add(stage, "/World/box", at=(0, 0, 5))
    UsdGeom.Xform.Define(stage, "/World/group")
    authored = stage.GetRootLayer().ExportToString()
    engine = playing(stage)
    engine.advance(STEP)
    renamed, back = Sdf.BatchNamespaceEdit(), Sdf.BatchNamespaceEdit()
    renamed.Add("/World/box", new_path)
    back.Add(new_path, "/World/box")
    assert stage.GetRootLayer().Apply(renamed)
    engine.advance(5 * STEP)
    assert position(stage.GetPrimAtPath(new_path))[2] == pytest.approx(5.0 - fallen(6), abs=1e-3)
    engine.stop()
    assert stage.GetRootLayer().Apply(back)
    assert _sorted_lines(stage.GetRootLayer().ExportToString()) == _sorted_lines(authored)


def _sorted_lines(text: str) -> list[str]:
    """The lines of a layer: moving a prim there and back may change its place among its siblings."""
    return sorted(text.splitlines())


def test_listener_may_stop_the_simulation():
    stage = new_stage()
    prim = add(stage, "/World/box", at=(0, 0, 5))
    engine = playing(stage)
    engine.subscribe_step(lambda dt: engine.stop())
    assert engine.advance(1.0) == 1
    assert not engine.is_playing
    assert position(prim) == pytest.approx([0, 0, 5])


def test_mass_change_while_playing():
    """A light body hit by one whose mass was raised a hundredfold leaves faster than the center of mass ever was."""
    speeds = []
    for mass in (1.0, 100.0):
        stage = new_stage()
        hammer, ball = (
            add(stage, "/World/hammer", gravity=False),
            add(stage, "/World/ball", at=(1, 0, 0), gravity=False),
        )
        for prim in (hammer, ball):
            UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(1.0)
        engine = playing(stage)
        engine.advance(STEP)
        set_value(hammer, "physics:mass", mass)
        set_value(hammer, "physics:velocity", Gf.Vec3f(2, 0, 0))
        engine.advance(1.0)
        speeds.append(velocity(ball)[0])
    assert speeds == pytest.approx([1.0, 200 / 101], rel=0.02)


@pytest.mark.parametrize("seconds", [-1.0, math.nan, math.inf])
def test_time_does_not_go_back(seconds):
    engine = playing(new_stage())
    with pytest.raises(errors.PhysicsError, match="positive number of seconds"):
        engine.step(seconds)
    with pytest.raises(errors.PhysicsError, match="does not go back in time"):
        engine.advance(seconds)


def test_a_step_of_no_time_is_refused():
    engine = playing(new_stage())
    with pytest.raises(errors.PhysicsError, match="positive number of seconds"):
        engine.step(0.0)
    assert engine.advance(0.0) == 0


def test_advance_needs_play():
    with pytest.raises(PhysicsError, match=r"play\(\)"):
        NewtonEngine(new_stage(), device="cpu").advance(STEP)


def test_empty_stage_still_has_steps():
    engine = playing(new_stage())
    steps = []
    engine.subscribe_step(steps.append)
    assert engine.advance(0.1) == 6 == len(steps)


@pytest.mark.filterwarnings("ignore:.*not a number")
def test_a_pose_that_is_not_a_number_stops_that_body_only(recwarn):
    stage = new_stage()
    bad, good = add(stage, "/World/bad", gravity=False), add(stage, "/World/good", at=(9, 0, 0), gravity=False)
    set_value(good, "physics:velocity", Gf.Vec3f(1, 0, 0))
    engine = playing(stage)
    engine.advance(STEP)
    set_value(bad, "physics:velocity", Gf.Vec3f(float("nan"), 0, 0))
    with pytest.warns(UserWarning, match="/World/bad.*not a number"):
        engine.advance(0.5)
    assert np.isfinite(position(bad)).all()
    assert position(good)[0] == pytest.approx(9 + 0.5 + 1 / 60, abs=1e-4)


@pytest.mark.parametrize("while_playing", [False, True])
@pytest.mark.parametrize("body", [False, True])
def test_a_transform_that_is_not_a_number_leaves_that_prim_out(while_playing, body):
    errors.forget_warnings()
    stage = new_stage()
    bad, good = add(stage, "/World/bad", body=body), add(stage, "/World/good", at=(9, 0, 0))
    if not while_playing:
        set_value(bad, "xformOp:translate", Gf.Vec3d(float("nan"), 0, 0))

    def fall():
        engine = playing(stage)
        engine.advance(STEP)
        set_value(bad, "xformOp:translate", Gf.Vec3d(0, float("inf"), 0))
        engine.advance(1.0)
        return engine

    with pytest.warns(UserWarning, match="not a number.*/World/bad"):
        engine = fall()
    assert engine.rigid_bodies == ("/World/good",)
    assert position(good)[2] == pytest.approx(-9.81 / 2 * (1 + STEP) ** 2, abs=0.1)
    errors.forget_warnings()


def test_contact_buffers_grow(monkeypatch):
    """Boxes that need more contacts than the buffers hold are still held by their floor."""
    from usdsdg_physics.model import build

    monkeypatch.setattr(build, "MIN_CONTACTS", 6)
    monkeypatch.setattr(build, "CONTACTS_PER_BODY", 1)
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(5, 5, 0.1), body=False)
    prims = [add(stage, f"/World/box_{i}", at=(0.5 * i, 0, 0.12)) for i in range(8)]
    playing(stage).advance(1.0)
    assert [position(prim)[2] for prim in prims] == pytest.approx([0.1] * 8, abs=2e-3)


def test_simulate_leaves_bodies_where_they_end():
    stage = new_stage()
    prim = add(stage, "/World/box", at=(0, 0, 5))
    frames = []
    assert simulate(stage, 0.5, device="cpu", frames_per_second=30, on_frame=frames.append) == 30
    assert frames == list(range(1, 16))
    assert position(prim)[2] == pytest.approx(5 - fallen(30), abs=1e-3)
