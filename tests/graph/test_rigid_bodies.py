"""`rep.physics.rigid_body`: the velocities that a stop and a reset give back, and the PhysicsScene it needs."""

import pytest
from pxr import UsdGeom, UsdPhysics

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.errors import BadPrim, UsdsdgWarning
from usdsdg.functional import create
from usdsdg.graph import evaluate
from usdsdg.session.timeline import get_timeline
from usdsdg.settings import get_physx_timestep


def velocity_of(prim):
    return prim.GetAttribute("physics:velocity").Get()


def place_of(prim):
    return UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0).ExtractTranslation()


@pytest.fixture
def ball(stage):
    return create.sphere(position=(0, 0, 10), as_mesh=False)


def played(ball, updates=6):
    """Play from the start; return where the ball is after some updates, stopped again."""
    get_timeline().play()
    for _ in range(updates):
        get_app().update()
    place = tuple(place_of(ball))
    get_timeline().stop()
    return place


def test_a_velocity_is_written_at_once_and_kept_at_a_stop(ball):
    rep.physics.rigid_body(velocity=(1, 0, 0), angular_velocity=(0, 0, 90), input_prims=ball)
    assert velocity_of(ball) == (1, 0, 0)
    assert ball.GetAttribute("physics:angularVelocity").Get() == (0, 0, 90)
    first = played(ball)
    assert first[0] == pytest.approx(0.1, rel=1e-4)
    assert velocity_of(ball) == (1, 0, 0)
    assert played(ball) == first


def test_a_velocity_of_the_script_is_not_overwritten_by_a_later_evaluation(ball):
    rep.physics.rigid_body(velocity=(1, 0, 0), input_prims=ball)
    ball.GetAttribute("physics:velocity").Set((0, 2, 0))
    evaluate.graph().evaluate()
    assert velocity_of(ball) == (0, 2, 0)


def test_a_drawn_velocity_is_written_before_the_timeline_plays_and_kept_at_a_stop(ball):
    rep.physics.rigid_body(velocity=rep.distribution.uniform((1, 0, 0), (2, 0, 0)), input_prims=ball)
    assert not velocity_of(ball)[0]
    first = played(ball)
    assert 1 <= velocity_of(ball)[0] < 2
    assert first[0] == pytest.approx(velocity_of(ball)[0] / 10, rel=1e-4)
    assert played(ball) == first


def test_a_pose_that_a_graph_writes_once_is_kept_at_a_stop(ball):
    rep.physics.rigid_body(input_prims=ball)
    rep.modify.pose(position=(3, 0, 10), input_prims=ball)
    first = played(ball)
    assert first[0] == pytest.approx(3)
    assert tuple(place_of(ball)) == (3, 0, 10)
    assert played(ball) == first


def speeds_of_frames(ball):
    """Capture until the triggers are exhausted; return the horizontal speed at each frame."""
    speeds = []
    unsubscribe = rep.orchestrator.get_orchestrator().on_captured(lambda: speeds.append(velocity_of(ball)[0]))
    rep.orchestrator.run_until_complete(start_timeline=True)
    unsubscribe()
    return speeds


def test_a_reset_by_time_keeps_an_authored_velocity(ball):
    rep.physics.rigid_body(velocity=(1, 0, 0), input_prims=ball)
    with rep.trigger.on_time(interval=0.1, max_execs=2):
        rep.modify.attribute("radius", rep.distribution.uniform(0.4, 0.6), input_prims=ball)
    speeds = speeds_of_frames(ball)
    assert len(speeds) == 2 * 6  # of two intervals, at 60 frames a second
    assert speeds == pytest.approx([1.0] * len(speeds))
    assert place_of(ball)[0] < 0.05


def test_a_velocity_drawn_at_each_reset_is_that_of_the_frames_up_to_the_next(ball):
    with rep.trigger.on_time(interval=0.1, max_execs=3):
        rep.physics.rigid_body(velocity=rep.distribution.uniform((1, 0, 0), (2, 0, 0)), input_prims=ball)
    speeds = speeds_of_frames(ball)
    drawn = sorted({round(speed, 4) for speed in speeds})
    assert len(drawn) == 3  # of the preview and of two firings
    assert all(1 <= speed < 2 for speed in drawn)


def test_a_stage_without_a_physics_scene_gets_replicators(stage, ball, recwarn):
    rep.physics.rigid_body(input_prims=ball)
    scene = stage.GetPrimAtPath("/PhysicsScene")
    assert scene.IsA(UsdPhysics.Scene)
    names = ("timeStepsPerSecond", "enableCCD", "enableGPUDynamics", "broadphaseType")
    assert [scene.GetAttribute(f"physxScene:{name}").Get() for name in names] == [240, True, False, "MBP"]
    assert get_physx_timestep() == pytest.approx(1 / 240)
    get_timeline().play()
    get_app().update()
    assert not list(recwarn)


def test_a_physics_scene_that_is_there_is_used_as_it_is(stage, ball):
    UsdPhysics.Scene.Define(stage, "/World/Physics")
    rep.physics.rigid_body(input_prims=ball)
    assert not stage.GetPrimAtPath("/PhysicsScene")
    assert get_physx_timestep() == pytest.approx(1 / 60)


def test_another_prim_at_the_path_of_the_scene_is_an_error(stage, ball):
    stage.DefinePrim("/PhysicsScene", "Cube")
    with pytest.raises(BadPrim, match="/PhysicsScene is a Cube"):
        rep.physics.rigid_body(input_prims=ball)


def test_a_prim_above_a_rigid_body_becomes_one_only_instead_of_that(stage):
    group = create.xform(name="group")
    part, other = create.cube(parent=group), create.cube(name="other")
    UsdPhysics.RigidBodyAPI.Apply(part)
    with pytest.warns(UsdsdgWarning, match="/group is not made a rigid body .* /group/Cube .* overwrite=True"):
        rep.physics.rigid_body(velocity=[(1, 0, 0), (2, 0, 0)], input_prims=[group, other])
    assert not group.HasAPI(UsdPhysics.RigidBodyAPI)
    assert not group.HasAttribute("physics:velocity")
    assert part.HasAPI(UsdPhysics.RigidBodyAPI)
    assert not velocity_of(part)[0]
    assert velocity_of(other) == (2, 0, 0)

    rep.physics.rigid_body(velocity=(3, 0, 0), overwrite=True, input_prims=group)
    assert velocity_of(group) == (3, 0, 0)
    assert not part.HasAPI(UsdPhysics.RigidBodyAPI)
    assert part.HasAPI(UsdPhysics.CollisionAPI)


def test_a_velocity_of_none_leaves_it_as_it_is(ball):
    rep.physics.rigid_body(velocity=(1, 0, 0), input_prims=ball)
    rep.physics.rigid_body(velocity=None, angular_velocity=90, input_prims=ball)
    assert velocity_of(ball) == (1, 0, 0)
    assert ball.GetAttribute("physics:angularVelocity").Get() == (90, 90, 90)


def test_new_bodies_have_replicators_highest_velocities(stage, ball):
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    rep.physics.rigid_body(input_prims=ball)
    assert ball.GetAttribute("physxRigidBody:maxLinearVelocity").Get() == 100000
    assert ball.GetAttribute("physxRigidBody:maxDepenetrationVelocity").Get() == 10000000


@pytest.mark.parametrize("function", [rep.physics.rigid_body, rep.physics.collider])
def test_offsets_of_colliders_may_be_drawn_for_each_prim(stage, function):
    boxes = rep.create.cube(count=5)
    with rep.trigger.on_custom_event("go"), boxes:
        function(rest_offset=rep.distribution.uniform(0.01, 0.1), contact_offset=rep.distribution.uniform(0.2, 0.3))
    seen = set()
    for _ in range(2):
        rep.utils.send_og_event("go")
        evaluate.graph().evaluate()
        shapes = [stage.GetPrimAtPath(f"{path}/Cube") for path in boxes.prims]
        rest = [shape.GetAttribute("physxCollision:restOffset").Get() for shape in shapes]
        contact = [shape.GetAttribute("physxCollision:contactOffset").Get() for shape in shapes]
        assert all(0.01 <= each <= 0.1 for each in rest)
        assert all(0.2 <= each <= 0.3 for each in contact)
        seen |= {*rest, *contact}
    assert len(seen) == 20
