"""The attributes that functional.physics authors, and bodies that move when it simulates."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdShade

import usdsdg as rep
from tests.functional.poses import value, world
from tests.physics.scenes import fallen
from usdsdg.app.app import get_app
from usdsdg.errors import BadPrim, BadValue, GraphError, PhysicsError, Unsupported, UsdsdgWarning
from usdsdg.functional import create, create_batch, modify, physics
from usdsdg.session import engines
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.schemas import physx
from usdsdg_physics.writeback.stage_writer import StageWriter


@pytest.fixture
def cube(stage):
    return create.cube(parent="/World", position=(0, 0, 10))


def owners(prim):
    return [str(path) for path in prim.GetRelationship("physics:simulationOwner").GetTargets()]


# --- scenes ---


def test_a_scene_is_made_once_and_takes_attributes_of_both_schemas(stage):
    scene = physics.create_physics_scene(enableCCD=True, broadphaseType="MBP", gravityMagnitude=3.5)
    assert str(scene.GetPath()) == "/PhysicsScene"
    assert scene.HasAPI(physx.PhysxSceneAPI)
    again = physics.create_physics_scene(
        "/PhysicsScene", timestepsPerSecond=120, **{"physics:gravityDirection": (0, -1, 0)}
    )
    assert again == scene
    names = ("physxScene:enableCCD", "physxScene:broadphaseType", "physics:gravityMagnitude")
    assert [scene.GetAttribute(name).Get() for name in names] == [True, "MBP", 3.5]
    assert scene.GetAttribute("physxScene:timeStepsPerSecond").Get() == 120
    assert scene.GetAttribute("physics:gravityDirection").Get() == Gf.Vec3f(0, -1, 0)


def test_wrong_scenes_raise_errors(stage, cube):
    with pytest.raises(BadPrim, match="no attribute 'enableCDC'; did you mean enableCCD"):
        physics.create_physics_scene(enableCDC=True)
    with pytest.raises(BadPrim, match="/World/Cube is a Mesh, not a PhysicsScene"):
        physics.create_physics_scene("/World/Cube")
    with pytest.raises(BadValue, match="gravityMagnitude is a float"):
        physics.create_physics_scene(gravityMagnitude="much")


# --- bodies and colliders ---


def test_a_rigid_body_gets_schemas_limits_and_a_collider(cube):
    physics.apply_rigid_body(cube, disableGravity=True, velocity=(1, 2, 3))
    assert cube.HasAPI(UsdPhysics.RigidBodyAPI)
    assert cube.HasAPI(physx.PhysxRigidBodyAPI)
    assert cube.HasAPI(UsdPhysics.CollisionAPI)
    assert UsdPhysics.MeshCollisionAPI(cube).GetApproximationAttr().Get() == "convexHull"
    names = ("physxRigidBody:disableGravity", "physics:velocity")
    assert [cube.GetAttribute(name).Get() for name in names] == [True, Gf.Vec3f(1, 2, 3)]
    limits = ("physxRigidBody:maxLinearVelocity", "physxRigidBody:maxDepenetrationVelocity")
    assert [cube.GetAttribute(name).Get() for name in limits] == [1000, 100000]


def test_defaults_that_scripts_change_are_taken(stage, cube, monkeypatch):
    monkeypatch.setitem(physics.DEFAULTS_RIGID_BODY, "approximation", "boundingCube")
    monkeypatch.setitem(physics.DEFAULTS_RIGID_BODY, "maxLinearVelocity", 5)
    physics.apply_rigid_body(cube)
    assert cube.GetAttribute("physics:approximation").Get() == "boundingCube"
    assert cube.GetAttribute("physxRigidBody:maxLinearVelocity").Get() == 5
    monkeypatch.setitem(physics.DEFAULTS_PHYSICS_SCENE, "timeStepsPerSecond", 120)
    rep.physics.rigid_body(input_prims=rep.create.cube())
    scene = stage.GetPrimAtPath(physics.DEFAULTS_PHYSICS_SCENE["path"])
    assert scene.GetAttribute("physxScene:timeStepsPerSecond").Get() == 120
    for approximation in physics.VALID_COLLIDER_APPROXIMATIONS:
        physics.apply_collider(cube, approximation=approximation)


def test_limits_are_meters_and_give_way_to_given_ones(y_up_stage):
    cube = create.cube()
    physics.apply_rigid_body(cube, maxDepenetrationVelocity=5)
    assert cube.GetAttribute("physxRigidBody:maxLinearVelocity").Get() == 100000
    assert cube.GetAttribute("physxRigidBody:maxDepenetrationVelocity").Get() == 5


def test_a_body_without_a_collider(cube):
    physics.apply_rigid_body(cube, with_collider=False)
    assert not cube.HasAPI(UsdPhysics.CollisionAPI)


def test_bodies_do_not_nest(stage):
    group = create.xform()
    inner = create.cube(parent=group)
    physics.apply_rigid_body(inner)
    with pytest.warns(UsdsdgWarning, match="/Xform is not made a rigid body: /Xform/Cube"):
        physics.apply_rigid_body(group, overwrite_rigid_body=False)
    assert not group.HasAPI(UsdPhysics.RigidBodyAPI)
    physics.apply_rigid_body(group)
    assert group.HasAPI(UsdPhysics.RigidBodyAPI)
    assert not inner.HasAPI(UsdPhysics.RigidBodyAPI)
    assert inner.HasAPI(UsdPhysics.CollisionAPI)


def test_all_shapes_below_collide_with_the_attributes_given(stage):
    group = create.xform()
    mesh, ball = create.cube(parent=group), create.sphere(parent=group, as_mesh=False)
    physics.apply_collider(group, approximation="sdf", contactOffset=0.01, collisionEnabled=False)
    for shape in (mesh, ball):
        assert shape.HasAPI(UsdPhysics.CollisionAPI)
        assert shape.GetAttribute("physxCollision:contactOffset").Get() == pytest.approx(0.01)
        assert shape.GetAttribute("physics:collisionEnabled").Get() is False
    assert mesh.GetAttribute("physics:approximation").Get() == "sdf"
    assert mesh.HasAPI(physx.PhysxSDFMeshCollisionAPI)
    assert not ball.HasAPI(UsdPhysics.MeshCollisionAPI)
    assert not group.HasAPI(UsdPhysics.CollisionAPI)


def test_a_collider_of_triangles_is_the_default(cube):
    physics.apply_collider(cube)
    assert cube.GetAttribute("physics:approximation").Get() == "none"


def test_instances_are_opened_to_give_them_colliders(stage, tmp_path):
    made = Usd.Stage.CreateNew(str(tmp_path / "thing.usda"))
    UsdGeom.Cube.Define(made, "/Thing/Cube")
    made.SetDefaultPrim(made.GetPrimAtPath("/Thing"))
    made.Save()
    prim = create.reference(str(tmp_path / "thing.usda"))
    prim.SetInstanceable(True)
    with pytest.warns(UsdsdgWarning, match="/Ref is an instance"):
        physics.apply_collider(prim)
    assert prim.GetChild("Cube").HasAPI(UsdPhysics.CollisionAPI)


def test_the_scene_that_simulates_a_body(cube):
    physics.create_physics_scene("/Scene")
    physics.apply_rigid_body(cube, "/Scene")
    assert owners(cube) == ["/Scene"]
    physics.create_physics_scene("/Other")
    physics.apply_collider(cube, "/Scene", simulationOwner="/Other")
    assert owners(cube) == ["/Other"]
    with pytest.raises(BadPrim, match="/World is a Xform, not a PhysicsScene"):
        physics.apply_rigid_body(cube, physics_scene="/World")


def test_removing(stage):
    group = create.xform()
    cube = create.cube(parent=group)
    physics.apply_rigid_body(group, approximation="sdf")
    physics.remove_rigid_body(group)
    assert not group.HasAPI(UsdPhysics.RigidBodyAPI)
    assert not group.HasAPI(physx.PhysxRigidBodyAPI)
    assert cube.HasAPI(UsdPhysics.CollisionAPI)
    physics.remove_collider(group)
    assert not [schema for schema in cube.GetAppliedSchemas() if "Collision" in schema]


def test_wrong_bodies_raise_errors(stage, cube):
    with pytest.raises(BadPrim, match="no attribute 'disableGravitiy'; did you mean disableGravity"):
        physics.apply_rigid_body(cube, disableGravitiy=True)
    with pytest.raises(GraphError, match="approximation is 'hull'"):
        physics.apply_collider(cube, approximation="hull")


def test_a_prim_without_shapes_gets_the_schemas_itself_and_does_not_disturb_others(stage, cube):
    empty = create.xform(position=(5, 0, 0))
    with pytest.warns(UsdsdgWarning, match="/Xform has no shape or mesh at or below it: it is a collider without"):
        physics.apply_rigid_body(empty)
    assert empty.HasAPI(UsdPhysics.RigidBodyAPI)
    assert empty.HasAPI(UsdPhysics.CollisionAPI)
    assert empty.HasAPI(physx.PhysxCollisionAPI)
    physics.apply_rigid_body(cube)
    before = cube.GetAttribute("xformOp:translate").Get()
    physics.simulate(0.5)
    # Free fall: half of 9.81 m/s^2 x (0.5 s)^2.
    assert cube.GetAttribute("xformOp:translate").Get()[2] - before[2] == pytest.approx(-1.23, abs=0.05)


def test_the_scene_that_simulates_a_body_may_be_made_later(stage, cube):
    with pytest.warns(UsdsdgWarning, match="physics_scene='/Later': there is no prim yet"):
        physics.apply_rigid_body(cube, physics_scene="/Later")
    assert owners(cube) == ["/Later"]
    assert physics.create_physics_scene("/Later").IsA(UsdPhysics.Scene)
    with pytest.raises(BadPrim, match="not a path"):
        physics.apply_rigid_body(cube, physics_scene="not a path")


# --- attributes ---


def test_physics_attributes_are_set_by_their_full_names(stage):
    cubes = create_batch.cube(count=2)
    physics.apply_rigid_body(cubes)
    physics.modify_attribute(cubes, "physics:velocity", [(1, 0, 0), (0, 1, 0)])
    assert [cube.GetAttribute("physics:velocity").Get() for cube in cubes] == [Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)]
    physics.modify_attribute(cubes[0], attribute_name="physics:approximation", value="boundingCube")
    assert cubes[0].GetAttribute("physics:approximation").Get() == "boundingCube"
    with pytest.raises(BadPrim, match="no attribute 'physics:velocty'; did you mean physics:velocity"):
        physics.modify_attribute(cubes, "physics:velocty", (1, 0, 0))


def test_friction_is_that_of_the_bound_material(stage, cube):
    with pytest.raises(BadPrim, match="/World/Cube has no material"):
        physics.modify_attribute(cube, "physics:staticFriction", 0.5)
    material = UsdShade.Material.Define(stage, "/World/rubber")
    UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    UsdShade.MaterialBindingAPI.Apply(cube).Bind(material)
    physics.modify_attribute(cube, "physics:staticFriction", 0.5)
    physics.modify_attribute(material.GetPrim(), "physics:restitution", 0.25)
    api = UsdPhysics.MaterialAPI(material)
    assert (api.GetStaticFrictionAttr().Get(), api.GetRestitutionAttr().Get()) == (0.5, 0.25)


def test_drives_are_those_of_the_kind_of_joint(stage, cube):
    for name, kind, joint in (
        ("slide", "linear", "PhysicsPrismaticJoint"),
        ("hinge", "angular", "PhysicsRevoluteJoint"),
    ):
        prim = stage.DefinePrim(f"/World/{name}", joint)
        UsdPhysics.DriveAPI.Apply(prim, kind)
        physics.modify_attribute(prim, "rep:physics:resolveStiffness", 7)
        physics.modify_attribute(prim, "rep:physics:resolveDamping", 8)
        assert prim.GetAttribute(f"drive:{kind}:physics:stiffness").Get() == 7
        assert prim.GetAttribute(f"drive:{kind}:physics:damping").Get() == 8
    with pytest.raises(BadPrim, match="prismatic or revolute"):
        physics.modify_attribute(cube, "rep:physics:resolveDamping", 8)


def test_velocities_of_instances(stage):
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/many")
    physics.modify_attribute(instancer.GetPrim(), "physics:velocity", [(1, 0, 0), (0, 1, 0)])
    assert list(instancer.GetVelocitiesAttr().Get()) == [Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)]


# --- simulation ---


def test_simulate_lets_bodies_fall_and_leaves_them_there(stage, cube):
    physics.create_physics_scene(timeStepsPerSecond=60)
    physics.apply_rigid_body(cube)
    physics.simulate(0.5, 1 / 120)
    # Free fall of half a second; an explicit step of 1/120 s adds at most g * dt * t / 2.
    assert world(cube)[3, 2] == pytest.approx(10 - fallen(60, rate=120), abs=1e-3)
    assert value(cube, "physics:velocity")[2] == pytest.approx(-9.81 * 0.5, abs=0.1)
    assert stage.GetPrimAtPath("/PhysicsScene").GetAttribute("physxScene:timeStepsPerSecond").Get() == 60
    assert stage.GetSessionLayer().GetPrimAtPath("/PhysicsScene") is None
    assert get_timeline().get_current_time() == 0


def test_simulate_takes_the_steps_asked_for(stage, cube):
    physics.apply_rigid_body(cube)
    steps = []
    unsubscribe = engines.subscribe_step(steps.append)
    physics.simulate(0.1, 1 / 50)
    unsubscribe()
    assert steps == pytest.approx([0.02] * 5)


def test_only_the_last_step_of_a_frame_is_written_unless_somebody_listens(stage, cube, monkeypatch):
    physics.create_physics_scene(timeStepsPerSecond=240)
    physics.apply_rigid_body(cube)
    writes, write = [], StageWriter.write
    monkeypatch.setattr(StageWriter, "write", lambda self, *state: (writes.append(1), write(self, *state)))
    timeline = get_timeline()
    timeline.set_time_codes_per_second(60)
    timeline.play()
    get_app().update()
    assert len(writes) == 1
    unsubscribe = engines.subscribe_step(lambda dt: None)
    get_app().update()
    assert len(writes) == 5
    unsubscribe()
    get_app().update()
    assert len(writes) == 6
    timeline.stop()


def test_simulate_until_rest_separates_bodies_and_lets_them_lie(stage, cube):
    """Two cubes of a meter, one inside the other, on a floor: they end on top of each other, at rest for good."""
    other = create.cube(parent="/World", position=(0.1, 0, 10.2))
    floor = create.cube(parent="/World", position=(0, 0, 9), scale=(20, 20, 1))
    physics.apply_collider(floor)
    physics.apply_rigid_body([cube, other])
    assert physics.simulate_until_rest() == []
    assert [world(cube)[3, 2], world(other)[3, 2]] == pytest.approx([10, 11], abs=1e-3)
    assert other.GetAttribute("physics:velocity").Get().GetLength() < 1e-3
    assert get_timeline().get_current_time() == 0
    physics.simulate(0.5)
    assert [world(cube)[3, 2], world(other)[3, 2]] == pytest.approx([10, 11], abs=1e-3)


def test_simulate_until_rest_waits_for_the_prims_given_and_names_what_still_moves(stage, cube):
    """Without a floor both fall, and neither rests."""
    other = create.sphere(parent="/World", position=(3, 0, 10))
    physics.apply_rigid_body([cube, other])
    with pytest.warns(UsdsdgWarning, match=r"simulate_until_rest: 2 bodies still move after 0\.1 s: /World/Cube"):
        assert physics.simulate_until_rest(max_time=0.1) == ["/World/Cube", "/World/Sphere"]
    with pytest.warns(UsdsdgWarning, match="1 body still moves after"):
        assert physics.simulate_until_rest(other, max_time=0.2) == ["/World/Sphere"]
    with pytest.raises(PhysicsError, match="max_time is 0"):
        physics.simulate_until_rest(max_time=0)
    with pytest.raises(BadPrim, match="is no rigid body"):
        physics.simulate_until_rest(stage.GetPrimAtPath("/World"))


def test_simulate_until_rest_leaves_a_timeline_that_plays_playing(stage, cube):
    physics.apply_rigid_body(cube)
    played(5)
    with pytest.warns(UsdsdgWarning, match="still move"):
        physics.simulate_until_rest(max_time=0.1)
    assert engines.physics().is_playing
    lower = world(cube)[3, 2]
    played(5)
    assert world(cube)[3, 2] < lower
    get_timeline().stop()
    assert world(cube)[3, 2] == 10


def test_reset_puts_bodies_back_while_the_timeline_plays(stage, cube):
    from usdsdg.app.app import get_app

    physics.apply_rigid_body(cube)
    physics.reset()
    get_timeline().play()
    for _ in range(5):
        get_app().update()
    assert world(cube)[3, 2] < 10
    physics.reset()
    assert world(cube)[3, 2] == 10
    get_app().update()
    assert world(cube)[3, 2] < 10
    get_timeline().stop()
    assert world(cube)[3, 2] == 10


def played(frames):
    from usdsdg.app.app import get_app

    get_timeline().play()
    for _ in range(frames):
        get_app().update()


def test_reset_of_one_body_leaves_the_others(stage, cube):
    other = create.sphere(parent="/World", position=(3, 0, 10), as_mesh=False)
    physics.apply_rigid_body([cube, other], velocity=(1, 0, 0))
    played(10)
    fallen, sped = world(other)[3, :3], other.GetAttribute("physics:velocity").Get()
    first = world(cube)[3, :3]
    physics.reset(cube)
    assert world(cube)[3, :3] == pytest.approx((0, 0, 10))
    assert cube.GetAttribute("physics:velocity").Get() == Gf.Vec3f(1, 0, 0)
    assert (world(other)[3, :3] == fallen).all()
    assert other.GetAttribute("physics:velocity").Get() == sped
    played(10)
    # It falls again as it fell first, and the other one twice as long.
    assert world(cube)[3, :3] == pytest.approx(first, abs=1e-5)
    assert world(other)[3, 0] == pytest.approx(3 + 20 / 60, abs=1e-4)
    get_timeline().stop()
    assert world(cube)[3, :3] == pytest.approx((0, 0, 10))
    assert world(other)[3, :3] == pytest.approx((3, 0, 10))


def test_a_sleeping_body_stays_in_the_air_until_it_is_woken(stage, cube):
    physics.apply_rigid_body(cube)
    played(10)
    height = world(cube)[3, 2]
    physics.put_to_sleep(cube)
    assert cube.GetAttribute("physics:velocity").Get() == Gf.Vec3f(0)
    played(20)
    assert world(cube)[3, 2] == height
    physics.wake_up(cube)
    played(6)
    assert height - world(cube)[3, 2] == pytest.approx(fallen(6), abs=1e-3)
    get_timeline().stop()
    assert not cube.GetAttribute("physics:startsAsleep").Get()


def test_put_to_sleep_before_a_simulation_lasts_into_it(stage, cube):
    physics.apply_rigid_body(cube)
    physics.put_to_sleep([cube])
    assert cube.GetAttribute("physics:startsAsleep").Get() is True
    physics.simulate(0.5)
    assert world(cube)[3, 2] == 10
    physics.wake_up(cube)
    assert cube.GetAttribute("physics:startsAsleep").Get() is False
    physics.simulate(0.5)
    assert world(cube)[3, 2] < 9.5


def test_unsupported_simulations_raise_errors(stage, cube):
    physics.apply_rigid_body(cube)
    with pytest.raises(PhysicsError, match="time is 0"):
        physics.simulate(0, 1 / 60)
    with pytest.raises(PhysicsError, match="step_dt is"):
        physics.simulate(1, 0.3)
    physics.create_physics_scene("/First")
    physics.create_physics_scene("/Second")
    with pytest.raises(Unsupported, match="only the first scene, /First"):
        physics.simulate(1, 1 / 60, "/Second")
    for function in (physics.put_to_sleep, physics.wake_up, physics.reset):
        with pytest.raises(BadPrim, match="/World is no rigid body"):
            function("/World")


# --- cameras ---


def test_the_shapes_in_front_of_a_camera(y_up_stage):
    rig = create.xform(position=(100, 0, 0))
    camera = create.camera(parent=rig, position=(0, 50, 0), rotation=(0, 90, 0))
    for _ in range(2):
        ball, cone = physics.create_camera_collision_prims(camera, 0.1, 0.4)
    assert [str(prim.GetPath()) for prim in (ball, cone)] == ["/Xform/cameraSphere", "/Xform/cameraCone"]
    assert UsdGeom.Imageable(cone).ComputeVisibility() == UsdGeom.Tokens.invisible
    points = np.array(UsdGeom.Mesh(ball).GetPointsAttr().Get()) @ world(ball)[:3, :3] + world(ball)[3, :3]
    np.testing.assert_allclose(np.linalg.norm(points - world(camera)[3, :3], axis=1), 10, atol=1e-3)
    points = np.c_[np.array(UsdGeom.Mesh(cone).GetPointsAttr().Get()), np.ones(len(cone.GetAttribute("points").Get()))]
    seen = (points @ world(cone) @ np.linalg.inv(world(camera)))[:, :3]
    assert seen[:, 2].min() == pytest.approx(-40, abs=1e-3)
    assert seen[:, 2].max() == pytest.approx(0, abs=1e-3)
    base = seen[seen[:, 2] < -39.9]
    assert np.abs(base[:, 0]).max() == pytest.approx(40 * 20.955 / 2 / 24, abs=1e-2)
    np.testing.assert_allclose(seen[seen[:, 2] > -0.1][:, :2], 0, atol=1e-3)
    with pytest.raises(BadPrim, match="/World is a Xform, not a camera"):
        physics.create_camera_collision_prims("/World")


def test_the_cone_in_front_of_a_fisheye_is_as_wide_as_it_sees(y_up_stage):
    camera = create.camera(projection_type="fisheyePolynomial", fisheye_max_fov=100)
    _, cone = physics.create_camera_collision_prims(camera, 0.1, 0.4)
    points = np.c_[np.array(UsdGeom.Mesh(cone).GetPointsAttr().Get()), np.ones(len(cone.GetAttribute("points").Get()))]
    seen = (points @ world(cone) @ np.linalg.inv(world(camera)))[:, :3]
    assert np.abs(seen[:, 0]).max() == pytest.approx(40 * np.tan(np.radians(50)), rel=0.05)
    wide = create.camera(projection_type="fisheyePolynomial", name="wide")
    with pytest.raises(Unsupported, match="/wide sees more than 80 degrees to a side"):
        physics.create_camera_collision_prims(wide)


def test_poses_of_bodies_set_between_simulations_count(stage, cube):
    physics.apply_rigid_body(cube)
    physics.simulate(0.1)
    modify.position(cube, (0, 0, 50))
    physics.modify_attribute(cube, "physics:velocity", (0, 0, 0))
    physics.simulate(0.1)
    assert 49 < world(cube)[3, 2] < 50
