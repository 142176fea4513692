"""Scene queries of `omni.physics.core` and `omni.physx`, and paths as integers."""

from itertools import pairwise

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg.compat import physics_schema_tools
from usdsdg.compat.isaacsim.core.utils.collisions import ray_cast
from usdsdg.compat.omni.physics.core import get_physics_scene_query_interface, get_physics_simulation_interface
from usdsdg.compat.omni.physx import (
    get_physx_interface,
    get_physx_scene_query_interface,
    get_physx_simulation_interface,
)
from usdsdg.errors import BadValue, Unsupported

NONE = 0xFFFFFFFF
DOWN, TOP = (0.0, 0.0, -1.0), (0.0, 0.0, 10.0)


@pytest.fixture
def scene(stage):
    """A static mesh of two quads at z = 0, and above it two bodies: a ball at z = 2, a cube at z = 4."""
    UsdPhysics.Scene.Define(stage, "/PhysicsScene")
    mesh = UsdGeom.Mesh.Define(stage, "/World/floor")
    mesh.CreatePointsAttr([(x, y, 0) for x in (-5, 0.5, 5) for y in (-5, 5)])
    mesh.CreateFaceVertexCountsAttr([4, 4])
    mesh.CreateFaceVertexIndicesAttr([0, 2, 3, 1, 2, 4, 5, 3])
    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
    UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim()).CreateApproximationAttr("none")
    material = UsdShade.Material.Define(stage, "/World/wood")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")
    for name, kind, height in (("ball", "Sphere", 2), ("box", "Cube", 4)):
        body = UsdGeom.Xform.Define(stage, f"/World/{name}").GetPrim()
        UsdGeom.Xformable(body).AddTranslateOp().Set(Gf.Vec3d(0, 0, height))
        UsdPhysics.RigidBodyAPI.Apply(body)
        shape = stage.DefinePrim(f"/World/{name}/shape", kind)
        shape.GetAttribute("radius" if kind == "Sphere" else "size").Set(0.5 if kind == "Sphere" else 1.0)
        UsdPhysics.CollisionAPI.Apply(shape)
    return stage


def path_of(number):
    return str(physics_schema_tools.intToSdfPath(number))


def test_paths_come_back_from_integers(stage):
    for path in ("/World", "/World/a.b", ""):
        number = physics_schema_tools.sdfPathToInt(path)
        assert physics_schema_tools.intToSdfPath(number) == Sdf.Path(path)
        assert physics_schema_tools.decodeSdfPath(*physics_schema_tools.encodeSdfPath(path)) == Sdf.Path(path)
        assert all(0 <= part < 2**32 for part in physics_schema_tools.encodeSdfPath(path))
    with pytest.raises(BadValue, match="12345 is not the integer of a path"):
        physics_schema_tools.intToSdfPath(12345)


def test_core_reports_hits_nearest_first_with_encoded_paths(scene):
    queries, hits = get_physics_scene_query_interface(), []
    assert queries.raycast_all(TOP, DOWN, 20.0, lambda hit: hits.append(hit) is None, False) is None
    assert [path_of(hit.rigid_body) for hit in hits] == ["/World/box", "/World/ball", "/World/floor"]
    assert [path_of(hit.collision) for hit in hits] == ["/World/box/shape", "/World/ball/shape", "/World/floor"]
    assert [hit.distance for hit in hits] == pytest.approx([5.5, 7.5, 10.0])
    assert [hit.face_index for hit in hits] == [NONE, NONE, 0]
    assert path_of(hits[2].material) == "/World/wood"
    assert hits[0].material == 0
    assert (hits[0].position.z, hits[0].normal.z, hits[0].proto_index) == (4.5, 1.0, NONE)
    found, hit = queries.raycast_closest((1.0, 0.0, 10.0), DOWN, 20.0, False)
    assert (found, path_of(hit.collision), hit.face_index) == (True, "/World/floor", 1)
    assert queries.raycast_closest(TOP, (0.0, 0.0, 1.0), 20.0, False)[0] is False


def test_faces_are_numbered_as_on_the_mesh_where_some_do_not_collide(scene):
    floor = UsdGeom.Mesh(scene.GetPrimAtPath("/World/floor"))
    assert get_physics_scene_query_interface().raycast_closest((1.0, 0.0, 10.0), DOWN, 20.0, False)[1].face_index == 1
    floor.CreateHoleIndicesAttr([0])
    queries = get_physics_scene_query_interface()
    assert queries.raycast_closest((1.0, 0.0, 10.0), DOWN, 20.0, False)[1].face_index == 1
    assert queries.raycast_closest((-1.0, 3.0, 10.0), DOWN, 20.0, False)[0] is False


def test_the_back_of_a_mesh_is_hit_with_both_sides(scene):
    queries = get_physics_scene_query_interface()
    below, up = (3.0, 3.0, -2.0), (0.0, 0.0, 1.0)
    assert not queries.raycast_any(below, up, 20.0, False)
    assert queries.raycast_any(below, up, 20.0, True)
    assert not get_physx_scene_query_interface().raycast_any(below, up, 20.0)


def test_core_overlaps_stop_where_the_report_returns_false(scene):
    queries, seen = get_physics_scene_query_interface(), []
    count = queries.overlap_box(
        (1, 1, 5), (0, 0, 2), (0, 0, 0, 1), lambda hit: seen.append(path_of(hit.rigid_body)) or True
    )
    assert (count, seen) == (3, ["/World/ball", "/World/box", "/World/floor"])
    assert queries.overlap_box((1, 1, 5), (0, 0, 2), (0, 0, 0, 1), lambda hit: False) == 1
    assert queries.overlap_sphere_any(0.1, (0, 0, 2))
    assert not queries.overlap_box_any((0.1, 0.1, 0.1), (9, 9, 9), (0, 0, 0, 1))


def test_physx_hits_have_paths_as_text_and_encoded(scene):
    queries, hits = get_physx_scene_query_interface(), []
    assert queries.overlap_sphere(0.2, (0, 0, 2), lambda hit: hits.append(hit) is None) == 1
    (hit,) = hits
    assert (hit.rigid_body, hit.collision, hit.protoIndex) == ("/World/ball", "/World/ball/shape", NONE)
    assert physics_schema_tools.decodeSdfPath(*hit.rigid_body_encoded) == "/World/ball"
    closest = queries.raycast_closest(TOP, DOWN, 20.0)
    assert closest["hit"] is True
    assert (closest["rigidBody"], closest["distance"], closest["material"]) == ("/World/box", 5.5, "")
    assert queries.raycast_closest(TOP, DOWN, 1.0) == {"hit": False}


def test_moving_shapes_stop_at_the_first_collider(scene):
    physx, core = get_physx_scene_query_interface(), get_physics_scene_query_interface()
    swept = physx.sweep_sphere_closest(0.25, TOP, DOWN, 20.0)
    assert (swept["rigidBody"], swept["distance"]) == ("/World/box", pytest.approx(5.25))
    hits = []
    core.sweep_box_all((1, 1, 0.5), TOP, (0, 0, 0, 1), DOWN, 20.0, lambda hit: hits.append(hit) is None, False)
    assert [path_of(hit.rigid_body) for hit in hits] == ["/World/box", "/World/ball", "/World/floor"]
    assert [hit.distance for hit in hits] == pytest.approx([5.0, 7.0, 9.5])
    assert not core.sweep_sphere_any(0.1, (9, 9, 9), DOWN, 2.0, True)
    with pytest.raises(Unsupported, match="sweep_mesh_closest"):
        physx.sweep_mesh_closest(0, 0, DOWN, 1.0)


@pytest.mark.parametrize("simulate", ["core", "physx"])
def test_physics_steps_without_the_timeline(scene, simulate):
    interface = get_physics_simulation_interface()
    step = interface.simulate if simulate == "core" else get_physx_interface().update_simulation
    heights, dts = [], []
    held = interface.subscribe_physics_on_step_events(on_update=lambda dt, _: dts.append(dt))
    box = scene.GetPrimAtPath("/World/box")
    for _ in range(12):
        step(1 / 120, 0)
        heights.append(box.GetAttribute("xformOp:translate").Get()[2])
    held.unsubscribe()
    assert dts == pytest.approx([1 / 120] * 12)
    assert all(after < before for before, after in pairwise(heights))
    assert 4 - heights[-1] == pytest.approx(9.81 * 0.1**2 / 2, rel=0.15)


def test_the_ground_plane_collides_and_is_seen(stage):
    path = physics_schema_tools.addGroundPlane(stage, "/World/ground", "Y", 25.0, Gf.Vec3f(0, -1, 0), Gf.Vec3f(0.5))
    hit = get_physx_scene_query_interface().raycast_closest((400, 5, 3), (0, -1, 0), 20.0)
    assert (path, hit["collision"], hit["distance"]) == ("/World/ground", "/World/ground/collisionPlane", 6.0)
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/ground/geom"))
    a, b, c = (Gf.Vec3d(mesh.GetPointsAttr().Get()[i]) for i in range(3))
    assert Gf.Cross(b - a, c - b).GetNormalized() == Gf.Vec3d(0, 1, 0)
    extent = (
        UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"]).ComputeWorldBound(mesh.GetPrim()).ComputeAlignedRange()
    )
    assert extent.GetSize() == Gf.Vec3d(50, 0, 50)


@pytest.mark.parametrize("interface", [get_physics_simulation_interface, get_physx_simulation_interface])
def test_queries_find_edits_that_were_flushed(scene, interface):
    """The ball moves aside, the cube grows, and another ball is made, all between two steps."""
    ray = get_physics_scene_query_interface().raycast_closest
    UsdPhysics.Scene.Get(scene, "/PhysicsScene").CreateGravityMagnitudeAttr(0.0)
    interface().flush_changes()  # nothing is simulated
    get_physx_interface().start_simulation()
    get_physx_interface().update_simulation(1 / 60, 0.0)
    assert ray(TOP, DOWN, 20.0, True)[1].distance == pytest.approx(5.5)
    scene.GetAttributeAtPath("/World/box.xformOp:translate").Set(Gf.Vec3d(3, 0, 4))
    interface().flush_changes()
    assert ray(TOP, DOWN, 20.0, True)[1].distance == pytest.approx(7.5)
    scene.GetAttributeAtPath("/World/ball/shape.radius").Set(1.0)
    interface().flush_changes()
    assert ray(TOP, DOWN, 20.0, True)[1].distance == pytest.approx(7.0)
    added = UsdGeom.Sphere.Define(scene, "/World/added")
    added.CreateRadiusAttr(0.5)
    added.AddTranslateOp().Set(Gf.Vec3d(0, 0, 6))
    UsdPhysics.CollisionAPI.Apply(added.GetPrim())
    UsdPhysics.RigidBodyAPI.Apply(added.GetPrim())
    interface().flush_changes()
    assert ray(TOP, DOWN, 20.0, True)[1].distance == pytest.approx(3.5)
    get_physx_interface().reset_simulation()


def test_a_ray_of_a_frame_hits_bodies_and_static_colliders(stage):
    box = UsdGeom.Cube.Define(stage, "/World/box/shape")
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/box")).AddTranslateOp().Set(Gf.Vec3d(0, 5, 0))
    UsdPhysics.RigidBodyAPI.Apply(stage.DefinePrim("/World/box", "Xform"))
    UsdPhysics.CollisionAPI.Apply(box.GetPrim())
    wall = UsdGeom.Cube.Define(stage, "/World/wall")
    wall.AddTranslateOp().Set(Gf.Vec3d(-4, 0, 0))
    UsdPhysics.CollisionAPI.Apply(wall.GetPrim())
    half = np.sqrt(0.5)
    # A quarter turn about Z points +x of the frame along +y; the ray begins 0.5 ahead.
    path, distance = ray_cast(np.zeros(3), np.array([half, 0, 0, half]), np.array([0.5, 0, 0]))
    assert path == "/World/box"
    assert distance == pytest.approx(3.5, abs=1e-5)
    path, distance = ray_cast(np.zeros(3), np.array([0.0, 0, 0, 1]), np.zeros(3))
    assert path == "/World/wall"
    assert distance == pytest.approx(3.0, abs=1e-5)
    assert ray_cast(np.zeros(3), np.array([1.0, 0, 0, 0]), np.zeros(3)) == (None, 10000.0)
    assert ray_cast(np.zeros(3), np.array([0.0, 0, 0, 1]), np.zeros(3), max_dist=2.9) == (None, 10000.0)
