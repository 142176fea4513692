"""What PointInstancers draw: prototypes are nothing by themselves, instances collide and move."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from tests.physics.scenes import add, fallen, make_body, new_stage, playing, position
from usdsdg import errors
from usdsdg.stage.schemas import physx
from usdsdg_physics.parse.scene import parse
from usdsdg_physics.parse.shapes.convex_hulls import HullCache

STEP = 1 / 60


def _instancer(stage, positions, *, body=False, path="/World/many", below=True, indices=None, half=0.1, **options):
    """An instancer of cubes with an edge of 2 `half`, whose prototype is below it or elsewhere."""
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    prototype = f"{path}/cube" if below else "/World/cube"
    cube = UsdGeom.Cube.Define(stage, prototype)
    cube.CreateSizeAttr(2 * half)
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
    if body:
        make_body(cube.GetPrim(), **options)
    instancer.CreatePrototypesRel().AddTarget(prototype)
    instancer.CreateProtoIndicesAttr(indices or [0] * len(positions))
    instancer.CreatePositionsAttr([Gf.Vec3f(*map(float, each)) for each in positions])
    return instancer


def _positions(instancer):
    return np.array(instancer.GetPositionsAttr().Get())


@pytest.mark.parametrize("below", [True, False])
@pytest.mark.parametrize("body", [True, False])
def test_a_prototype_neither_collides_nor_moves_by_itself(below, body):
    stage = new_stage()
    _instancer(stage, [(5, 0, 0)], body=body, below=below)
    scene = parse(stage, HullCache())
    assert list(scene.bodies) == (["/World/many[0]"] if body else [])
    assert list(scene.colliders) == ["/World/many[0]"]
    box = add(stage, "/World/box", at=(0, 0, 0.5))
    playing(stage).advance(30 * STEP)
    assert position(box)[2] == pytest.approx(0.5 - fallen(30), abs=1e-3)


def test_instances_of_a_static_collider_collide_where_they_are_drawn():
    stage = new_stage()
    instancer = _instancer(stage, [(0, 0, 0), (2, 0, 0.5)], half=0.5)
    UsdGeom.Xformable(instancer).AddTranslateOp().Set((0, 0, -1))
    instancer.CreateScalesAttr([Gf.Vec3f(1), Gf.Vec3f(1, 1, 2)])
    half = float(np.sqrt(0.5))
    instancer.CreateOrientationsAttr([Gf.Quath(1), Gf.Quath(half, half, 0, 0)])
    boxes = [add(stage, f"/World/box{x}", at=(x, 0, 1)) for x in (0, 2)]
    playing(stage).advance(1.0)
    # The second is two high along z, which its orientation turns to -y.
    assert [position(box)[2] for box in boxes] == pytest.approx([-0.5 + 0.1, 0.0 + 0.1], abs=2e-3)


def test_instances_of_a_body_fall_and_rest_and_their_poses_are_written_to_the_instancer(capfd):
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(9, 9, 0.1), body=False)
    starts = [(x, 0, 0.3 + 0.1 * x) for x in range(4)]
    instancer = _instancer(stage, starts, body=True)
    engine = playing(stage)
    engine.advance(5 * STEP)
    assert _positions(instancer)[3] == pytest.approx([3, 0, 0.6 - fallen(5)], abs=1e-4)
    engine.advance(1.0)
    assert _positions(instancer) == pytest.approx(np.array([(x, 0, 0.1) for x in range(4)]), abs=2e-3)
    engine.stop()
    assert _positions(instancer) == pytest.approx(np.array(starts), abs=1e-6)
    assert not instancer.GetOrientationsAttr().HasAuthoredValue()
    assert "Ill-formed" not in capfd.readouterr().err  # USD warns of paths of instances, which are no prims


def test_an_instance_moves_as_a_prim_at_its_place_does():
    """Scaled, turned, below a turned parent, of a prototype with a transform of its own: v t and ω t in its space."""
    stage = new_stage()
    parent = UsdGeom.Xform.Define(stage, "/World/parent")
    parent.AddTranslateOp().Set((1, 2, 3))
    parent.AddRotateXYZOp().Set((20, 30, 40))
    instancer = _instancer(stage, [(0.5, 0, 0)], path="/World/parent/many", body=True, gravity=False)
    cube = UsdGeom.Xformable(stage.GetPrimAtPath("/World/parent/many/cube"))
    cube.AddRotateZOp().Set(25.0)
    instancer.CreateScalesAttr([Gf.Vec3f(1, 2, 3)])
    turn = Gf.Rotation(Gf.Vec3d(1, 2, 3), 50).GetQuat()
    instancer.GetPrim().CreateAttribute("orientationsf", instancer.GetOrientationsfAttr().GetTypeName()).Set(
        [Gf.Quatf(turn)]
    )
    instancer.CreateVelocitiesAttr([Gf.Vec3f(1, 0, 0)])
    instancer.CreateAngularVelocitiesAttr([Gf.Vec3f(0, 0, 90)])
    engine = playing(stage)
    engine.advance(30 * STEP)
    # Half a second at the velocities that it has all the time, in the space of the instancer.
    assert _positions(instancer)[0] == pytest.approx([1.0, 0, 0], abs=5e-3)
    quat = instancer.GetOrientationsfAttr().Get()[0]
    relative = Gf.Rotation(Gf.Quatd(turn)).GetInverse() * Gf.Rotation(Gf.Quatd(quat))
    assert relative.angle == pytest.approx(45, rel=0.03)
    assert np.array(instancer.GetVelocitiesAttr().Get()[0]) == pytest.approx([1, 0, 0], abs=1e-3)


def test_an_instance_of_a_mirrored_instancer_turns_as_its_angular_velocity_says():
    stage = new_stage()
    instancer = _instancer(stage, [(1, 0, 0)], body=True, gravity=False)
    UsdGeom.Xformable(instancer).AddScaleOp().Set((-1, 1, 1))
    instancer.CreateVelocitiesAttr([Gf.Vec3f(1, 0, 0)])
    instancer.CreateAngularVelocitiesAttr([Gf.Vec3f(0, 0, 90)])
    playing(stage).advance(30 * STEP)
    assert _positions(instancer)[0] == pytest.approx([1.5, 0, 0], abs=5e-3)
    turn = Gf.Rotation(Gf.Quatd(instancer.GetOrientationsAttr().Get()[0]))
    assert turn.axis[2] * turn.angle == pytest.approx(45, rel=0.03)
    assert np.array(instancer.GetAngularVelocitiesAttr().Get()[0]) == pytest.approx([0, 0, 90], rel=0.03, abs=0.1)


def test_instances_are_moved_while_playing():
    stage = new_stage()
    instancer = _instancer(stage, [(0, 0, 0), (1, 0, 0), (2, 0, 0)], body=True, gravity=False)
    engine = playing(stage)
    engine.advance(STEP)
    instancer.GetPositionsAttr().Set([Gf.Vec3f(0, 0, 0), Gf.Vec3f(1, 5, 0), Gf.Vec3f(2, 0, 0)])
    instancer.CreateVelocitiesAttr([Gf.Vec3f(0), Gf.Vec3f(0), Gf.Vec3f(0, 0, 6)])
    engine.advance(10 * STEP)
    assert _positions(instancer) == pytest.approx(np.array([(0, 0, 0), (1, 5, 0), (2, 0, 1)]), abs=1e-3)


def test_static_instances_are_moved_while_playing_and_others_are_added():
    stage = new_stage()
    instancer = _instancer(stage, [(0, 0, -0.5)], half=0.5)
    box = add(stage, "/World/box", at=(0, 0, 0.1))
    engine = playing(stage)
    engine.advance(0.5)
    instancer.GetPositionsAttr().Set([Gf.Vec3f(0, 0, -1.5)])
    engine.advance(1.0)
    assert position(box)[2] == pytest.approx(-0.9, abs=2e-3)
    instancer.GetProtoIndicesAttr().Set([0, 0])
    instancer.GetPositionsAttr().Set([Gf.Vec3f(9, 0, 0), Gf.Vec3f(0, 0, -2.5)])
    engine.advance(1.0)
    assert position(box)[2] == pytest.approx(-1.9, abs=2e-3)


def test_inactive_instances_and_prototypes_with_other_bodies():
    stage = new_stage()
    instancer = _instancer(stage, [(0, 0, 0), (1, 0, 0)])
    instancer.DeactivateId(1)
    part = UsdGeom.Cube.Define(stage, "/World/many/cube/part").GetPrim()
    UsdPhysics.CollisionAPI.Apply(part)
    make_body(part)
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning, match="/World/many/cube/part.*Apply RigidBodyAPI to the prototype"):
        scene = parse(stage, HullCache())
    errors.forget_warnings()
    assert not scene.bodies
    assert list(scene.colliders) == ["/World/many[0]", "/World/many[0]/part"]


def test_events_and_queries_name_instances():
    stage = new_stage()
    gate = add(stage, "/World/gate", scale=(1, 1, 1), body=False)
    physx.PhysxTriggerAPI.Apply(gate)
    physx.PhysxTriggerStateAPI.Apply(gate)
    _instancer(stage, [(0, 0, 0), (5, 0, 0)], body=True, gravity=False)
    engine, entered = playing(stage), []
    engine.subscribe_triggers(lambda event: entered.append(event.other))
    engine.step(STEP)
    assert entered == ["/World/many[0]"]
    assert [str(path) for path in gate.GetRelationship("physxTrigger:triggeredCollisions").GetTargets()] == [
        "/World/many"
    ]
    assert [hit.collision for hit in engine.overlap_sphere(0.2, (5, 0, 0))] == ["/World/many[1]"]


def test_a_thousand_instances_share_one_shape():
    stage = new_stage()
    grid = [(x * 0.5, y * 0.5, 0) for x in range(40) for y in range(25)]
    _instancer(stage, grid, body=True)
    scene = parse(stage, HullCache())
    assert len(scene.bodies) == 1000
    assert len({collider.shape for collider in scene.colliders.values()}) == 1


def _fall_and_spin(stage, *, arrays):
    """An instancer of two bodies that fall and spin, which has arrays of velocities or not."""
    instancer = _instancer(stage, [(0, 0, 50), (3, 0, 50)], body=True)
    cube = stage.GetPrimAtPath("/World/many/cube")
    UsdPhysics.RigidBodyAPI(cube).CreateAngularVelocityAttr(Gf.Vec3f(0, 0, 90))
    if arrays:
        instancer.CreateVelocitiesAttr([Gf.Vec3f(0)] * 2)
        instancer.CreateAngularVelocitiesAttr([Gf.Vec3f(0, 0, 90)] * 2)
    return instancer


def _heights(instancer):
    return _positions(instancer)[:, 2]


@pytest.mark.parametrize("arrays", [True, False])
def test_instances_go_on_as_fast_where_an_edit_lets_physics_read_the_stage_again(arrays):
    stage = new_stage()
    instancer = _fall_and_spin(stage, arrays=arrays)
    engine = playing(stage)
    engine.advance(30 * STEP)
    add(stage, "/World/late", at=(9, 0, 0))
    engine.advance(30 * STEP)
    assert _heights(instancer) == pytest.approx([50 - fallen(60)] * 2, abs=2e-3)
    assert engine.velocities(["/World/many[0]"])[0, 3:] == pytest.approx([0, 0, np.pi / 2], rel=1e-3)


def test_instances_keep_their_speed_where_others_are_added_and_removed():
    stage = new_stage()
    instancer = _fall_and_spin(stage, arrays=False)
    engine = playing(stage)
    engine.advance(30 * STEP)
    instancer.GetProtoIndicesAttr().Set([0, 0, 0])
    instancer.GetPositionsAttr().Set([*instancer.GetPositionsAttr().Get(), Gf.Vec3f(6, 0, 50)])
    instancer.GetOrientationsAttr().Set([*instancer.GetOrientationsAttr().Get(), Gf.Quath(1)])
    engine.advance(30 * STEP)
    expected = [50 - fallen(60), 50 - fallen(60), 50 - fallen(30)]
    assert _heights(instancer) == pytest.approx(expected, abs=2e-3)
    # What is at another index is another one, which begins at rest.
    instancer.GetProtoIndicesAttr().Set([0])
    instancer.GetPositionsAttr().Set([instancer.GetPositionsAttr().Get()[2]])
    instancer.GetOrientationsAttr().Set([Gf.Quath(1)])
    engine.advance(30 * STEP)
    assert _heights(instancer) == pytest.approx([expected[2] - fallen(30)], abs=2e-3)


def test_the_velocity_of_a_prototype_that_is_set_while_playing_is_that_of_its_instances():
    stage = new_stage()
    instancer = _instancer(stage, [(0, 0, 0), (3, 0, 0)], body=True, gravity=False)
    engine = playing(stage)
    engine.advance(STEP)
    UsdPhysics.RigidBodyAPI(stage.GetPrimAtPath("/World/many/cube")).CreateVelocityAttr(Gf.Vec3f(0, 1, 0))
    engine.advance(60 * STEP)
    assert _positions(instancer) == pytest.approx(np.array([(0, 1, 0), (3, 1, 0)]), abs=1e-3)


def test_instances_are_activated_and_deactivated_while_playing():
    stage = new_stage()
    ground = _instancer(stage, [(0, 0, -0.5), (3, 0, -0.5)], half=0.5, path="/World/ground")
    bodies = _instancer(stage, [(0, 0, 0.1), (3, 0, 0.1), (6, 0, 0)], body=True)
    bodies.DeactivateId(2)
    engine = playing(stage)
    engine.advance(30 * STEP)
    assert _heights(bodies) == pytest.approx([0.1, 0.1, 0.0], abs=1e-3)
    ground.DeactivateId(1)
    engine.advance(30 * STEP)
    assert _heights(bodies) == pytest.approx([0.1, 0.1 - fallen(30), 0.0], abs=2e-3)
    bodies.ActivateId(2)
    bodies.DeactivateId(1)
    engine.advance(30 * STEP)
    assert _heights(bodies) == pytest.approx([0.1, 0.1 - fallen(30), -fallen(30)], abs=2e-3)
    assert engine.rigid_bodies == ("/World/many[0]", "/World/many[2]")


def test_an_instance_is_deactivated_while_others_move():
    stage = new_stage()
    ground = _instancer(stage, [(0, 0, -0.5), (3, 0, -0.5)], half=0.5, path="/World/ground")
    bodies = _instancer(stage, [(0, 0, 0.1), (3, 0, 0.1)], body=True)
    engine = playing(stage)
    engine.advance(30 * STEP)
    ground.GetPositionsAttr().Set([Gf.Vec3f(0.1, 0, -0.5), Gf.Vec3f(3, 0, -0.5)])
    ground.DeactivateId(1)
    engine.advance(30 * STEP)
    assert _heights(bodies) == pytest.approx([0.1, 0.1 - fallen(30)], abs=2e-3)
