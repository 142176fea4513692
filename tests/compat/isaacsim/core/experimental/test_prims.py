"""`isaacsim.core.experimental.prims`."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from usdsdg.compat.isaacsim.core.experimental.objects import Cube
from usdsdg.compat.isaacsim.core.experimental.prims import Articulation, GeomPrim, Prim, RigidPrim, XformPrim
from usdsdg.compat.isaacsim.core.experimental.utils.backend import use_backend
from usdsdg.compat.isaacsim.core.simulation_manager import SimulationManager
from usdsdg.stage.physics.ground_plane import add_ground_plane

TURN = (0.5, 0.5, 0.5, 0.5)  # w, x, y, z: x to y, y to z, z to x


def xforms(stage, count):
    """Define /World/x_0, ... under a parent that is moved, turned and scaled."""
    parent = UsdGeom.Xform.Define(stage, "/World/parent")
    parent.AddTranslateOp().Set((1, 2, 3))
    parent.AddRotateXYZOp().Set((0, 0, 90))
    parent.AddScaleOp().Set((2, 2, 2))
    for index in range(count):
        UsdGeom.Xform.Define(stage, f"/World/parent/x_{index}")
    return "/World/parent/x_.*"


def test_paths_are_matched_part_by_part(stage):
    xforms(stage, 3)
    assert Prim("/World/.*/x_[01]").paths == ["/World/parent/x_0", "/World/parent/x_1"]
    assert len(Prim(["/World/parent", "/World/parent/x_2"])) == 2
    assert Prim.resolve_paths("/World/new") == ([], ["/World/new"])
    with pytest.raises(AssertionError, match="/World/none"):
        Prim("/World/none")
    with pytest.raises(ValueError, match="x_9"):
        Prim(["/World/parent", "/World/x_9"])
    with pytest.raises(ValueError, match="no prim matches"):
        Prim("/World/nothing_.*")


def test_poses_are_float32_warp_arrays_with_a_row_per_prim(stage):
    prims = XformPrim(xforms(stage, 3), reset_xform_op_properties=True)
    positions, orientations = prims.get_world_poses()
    assert (positions.shape, orientations.shape) == ((3, 3), (3, 4))
    assert positions.numpy().dtype == orientations.numpy().dtype == np.float32
    np.testing.assert_allclose(positions.numpy()[1], (1, 2, 3), atol=1e-6)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(np.abs(orientations.numpy()[1]), (half, 0, 0, half), atol=1e-6)
    assert prims.get_world_poses(indices=[2])[0].shape == (1, 3)


def test_a_world_pose_is_where_pxr_finds_the_prim(stage):
    prims = XformPrim(xforms(stage, 2), reset_xform_op_properties=True)
    prims.set_world_poses(positions=[[5, 6, 7], [0, 0, 1]], orientations=TURN)
    matrix = UsdGeom.XformCache().GetLocalToWorldTransform(prims.prims[0])
    assert Gf.IsClose(matrix.ExtractTranslation(), Gf.Vec3d(5, 6, 7), 1e-6)
    assert Gf.IsClose(matrix.TransformDir((1, 0, 0)), Gf.Vec3d(0, 2, 0), 1e-5)
    local = UsdGeom.XformCache().GetParentToWorldTransform(prims.prims[0]).GetInverse().Transform(Gf.Vec3d(5, 6, 7))
    np.testing.assert_allclose(prims.get_local_poses(indices=0)[0].numpy()[0], local, atol=1e-5)


def test_what_is_not_given_stays(stage):
    prim = XformPrim("/World/a" if stage.DefinePrim("/World/a", "Xform") else "", reset_xform_op_properties=True)
    prim.set_world_poses(positions=(1, 2, 3), orientations=TURN)
    prim.set_world_poses(positions=(4, 5, 6))
    np.testing.assert_allclose(prim.get_world_poses()[1].numpy()[0], TURN, atol=1e-6)
    prim.set_local_poses(orientations=(1, 0, 0, 0))
    np.testing.assert_allclose(prim.get_world_poses()[0].numpy()[0], (4, 5, 6), atol=1e-6)
    with pytest.raises(AssertionError, match="positions"):
        prim.set_world_poses()


def test_a_prim_without_the_ops_is_refused_and_keeps_its_pose_when_they_are_reset(stage):
    xform = UsdGeom.Xform.Define(stage, "/World/a")
    xform.AddTranslateOp().Set((1, 0, 0))
    xform.AddRotateZYXOp().Set((10, 20, 30))
    xform.AddScaleOp(UsdGeom.XformOp.PrecisionFloat).Set((2, 3, 4))
    before = xform.ComputeLocalToWorldTransform(0)
    prim = XformPrim("/World/a")
    with pytest.raises(AssertionError, match="orient"):
        prim.set_local_poses(orientations=(1, 0, 0, 0))
    prim.reset_xform_op_properties()
    assert [op.GetOpName() for op in xform.GetOrderedXformOps()] == [
        "xformOp:translate", "xformOp:orient", "xformOp:scale",
    ]  # fmt: skip
    np.testing.assert_allclose(np.array(xform.ComputeLocalToWorldTransform(0)), np.array(before), atol=1e-6)
    np.testing.assert_allclose(prim.get_local_scales().numpy(), [[2, 3, 4]])


def test_positions_and_translations_exclude_each_other(stage):
    with pytest.raises(AssertionError, match="not both"):
        XformPrim(xforms(stage, 1), positions=(0, 0, 0), translations=(0, 0, 0))
    moved = XformPrim("/World/parent/x_0", translations=(1, 0, 0), reset_xform_op_properties=True)
    np.testing.assert_allclose(moved.get_world_poses()[0].numpy()[0], (1, 4, 3), atol=1e-5)


def test_defaults_are_restored(stage):
    prims = XformPrim(xforms(stage, 2), reset_xform_op_properties=True)
    assert prims.get_default_state() == (None, None)
    prims.set_default_state(positions=(1, 1, 1), indices=[1])
    prims.set_world_poses(positions=(9, 9, 9))
    prims.reset_to_default_state()
    np.testing.assert_allclose(prims.get_world_poses()[0].numpy(), [(0, 0, 0), (1, 1, 1)], atol=1e-5)


def test_visibility_and_removed_prims(stage):
    prims = XformPrim(xforms(stage, 2))
    prims.set_visibilities([True, False])
    assert prims.get_visibilities().numpy().tolist() == [[True], [False]]
    stage.RemovePrim("/World/parent/x_1")
    assert not prims.valid
    with pytest.raises(AssertionError, match="removed"):
        prims.get_world_poses()


def test_colliders_and_their_approximations(stage):
    Cube(["/World/a", "/World/b"])
    geoms = GeomPrim("/World/[ab]", apply_collision_apis=True)
    assert all(prim.HasAPI(UsdPhysics.CollisionAPI) for prim in geoms.prims)
    geoms.set_collision_approximations(["convexHull", "boundingCube"])
    assert geoms.get_collision_approximations() == ["convexHull", "boundingCube"]
    geoms.set_enabled_collisions([False], indices=1)
    assert geoms.get_enabled_collisions().numpy().tolist() == [[True], [False]]
    geoms.set_offsets(contact_offsets=0.25)
    assert geoms.get_offsets()[0].numpy().tolist() == [[0.25], [0.25]]
    assert isinstance(geoms.geoms[0], UsdGeom.Cube)


def test_velocities_are_radians_and_masses_are_authored(stage):
    Cube(["/World/a", "/World/b"])
    bodies = RigidPrim("/World/[ab]", masses=[2, 3])
    bodies.set_velocities([1, 2, 3], [[0, 0, np.pi], [0, 0, 0]])
    linear, angular = bodies.get_velocities()
    assert linear.numpy().tolist() == [[1, 2, 3]] * 2
    np.testing.assert_allclose(angular.numpy(), [(0, 0, np.pi), (0, 0, 0)], atol=1e-6)
    attribute = UsdPhysics.RigidBodyAPI(bodies.prims[0]).GetAngularVelocityAttr()
    np.testing.assert_allclose(attribute.Get(), (0, 0, 180), atol=1e-4)
    assert bodies.get_masses().numpy().tolist() == [[2], [3]]
    bodies.set_enabled_gravities([True, False])
    assert bodies.get_enabled_gravities().numpy().tolist() == [[True], [False]]


def test_a_body_falls_lands_and_is_read_and_placed_while_physics_plays(stage):
    add_ground_plane(stage, "/World/ground")
    Cube("/World/a", sizes=1.0, positions=(0, 0, 1.5))
    body = RigidPrim("/World/a", masses=1.0)
    GeomPrim("/World/a", apply_collision_apis=True)
    SimulationManager.initialize_physics()
    SimulationManager.step(steps=120)
    position, _ = body.get_world_poses()
    np.testing.assert_allclose(position.numpy(), [(0, 0, 0.5)], atol=5e-3)
    assert np.linalg.norm(body.get_velocities()[0].numpy()) < 0.05
    body.set_world_poses(positions=(0, 0, 3))
    body.set_velocities((0, 0, 0), (0, 0, 0))
    SimulationManager.step()
    assert body.get_world_poses()[0].numpy()[0, 2] == pytest.approx(3.0, abs=5e-3)


def test_a_force_accelerates_a_body_along_its_own_axes_or_the_worlds(stage):
    for path in ("/World/a", "/World/b"):
        Cube(path, sizes=1.0, positions=(0, 5 * (path == "/World/b"), 5), orientations=TURN)
    bodies = RigidPrim("/World/[ab]", masses=2.0)
    GeomPrim("/World/[ab]", apply_collision_apis=True)
    bodies.set_enabled_gravities(False)
    SimulationManager.initialize_physics()
    bodies.apply_forces((60, 0, 0), indices=0)
    bodies.apply_forces((60, 0, 0), indices=1, local_frame=True)
    SimulationManager.step()
    # dv = F dt / m = 60 / 60 / 2
    np.testing.assert_allclose(bodies.get_velocities()[0].numpy(), [(0.5, 0, 0), (0, 0.5, 0)], atol=1e-3)


def test_an_articulation_names_its_links_and_joints(stage):
    for name in ("base", "arm"):
        UsdPhysics.RigidBodyAPI.Apply(stage.DefinePrim(f"/World/robot/{name}", "Cube"))
    joint = UsdPhysics.RevoluteJoint.Define(stage, "/World/robot/elbow")
    joint.CreateBody0Rel().SetTargets(["/World/robot/base"])
    joint.CreateBody1Rel().SetTargets(["/World/robot/arm"])
    robot = Articulation("/World/robot")
    assert (robot.joint_names, robot.link_names, robot.num_links) == (["elbow"], ["base", "arm"], 2)
    assert not hasattr(robot, "unknown")


def test_fabric_places_prims_that_lack_the_ops_of_usd(stage):
    """It has matrices: scripts that write poses to it for speed do not prepare the ops."""
    stage.DefinePrim("/World/a", "Xform")
    stage.DefinePrim("/World/b", "Cube")
    prims = XformPrim(["/World/a", "/World/b"])
    with pytest.raises(AssertionError, match="no xformOp:translate"):
        prims.set_world_poses([1.0, 2.0, 3.0])
    for backend in ("fabric", "usdrt"):
        with use_backend(backend):
            prims.set_world_poses([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], [0.0, 0.0, 0.0, 1.0])
            prims.set_local_scales([2.0, 2.0, 2.0])
            np.testing.assert_allclose(prims.get_local_scales().numpy(), [(2, 2, 2)] * 2)
    for prim, position in zip(prims.prims, ((1, 2, 3), (4, 5, 6)), strict=True):
        expected = Gf.Matrix4d().SetScale(2.0) * Gf.Matrix4d().SetRotate(Gf.Quatd(0, 0, 0, 1))
        expected.SetTranslateOnly(Gf.Vec3d(*position))
        assert Gf.IsClose(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()), expected, 1e-6)
    with pytest.raises(AssertionError, match="no xformOp:scale"):
        XformPrim(str(stage.DefinePrim("/World/c", "Xform").GetPath())).set_local_scales([1.0, 1.0, 1.0])
