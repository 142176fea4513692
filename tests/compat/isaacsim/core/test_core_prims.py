"""`isaacsim.core.prims`."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import UsdGeom, UsdPhysics

from usdsdg.compat.isaacsim.core.api.materials import PhysicsMaterial, PreviewSurface
from usdsdg.compat.isaacsim.core.prims import (
    GeometryPrim,
    RigidPrim,
    SingleGeometryPrim,
    SingleRigidPrim,
    SingleXFormPrim,
    XFormPrim,
)
from usdsdg.compat.isaacsim.core.simulation_manager import SimulationManager
from usdsdg.errors import BadPrim
from usdsdg.session import engines
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline


def cubes(stage, count):
    for index in range(count):
        cube = UsdGeom.Cube.Define(stage, f"/World/cube_{index}")
        cube.AddTranslateOp().Set((index, 0, 0))
        cube.AddRotateZOp().Set(90)
    return "/World/cube_.*"


def test_views_have_numpy_rows_and_standard_ops(stage):
    view = XFormPrim(cubes(stage, 3), "cubes")
    positions, orientations = view.get_world_poses()
    assert isinstance(positions, np.ndarray)
    assert (positions.shape, orientations.shape, positions.dtype) == ((3, 3), (3, 4), np.float32)
    np.testing.assert_allclose(positions[:, 0], (0, 1, 2))
    assert [op.GetOpName() for op in UsdGeom.Xformable(view.prims[0]).GetOrderedXformOps()] == [
        "xformOp:translate", "xformOp:orient", "xformOp:scale",
    ]  # fmt: skip
    view.set_world_poses(positions=[(5, 5, 5)], indices=[1])
    np.testing.assert_allclose(view.get_local_poses([1])[0], [(5, 5, 5)])
    view.set_local_scales(np.array([(1, 2, 3)] * 3))
    np.testing.assert_allclose(view.get_world_scales([0]), [(1, 2, 3)], rtol=1e-5)
    view.set_visibilities([True, False, True])
    assert view.get_visibilities().tolist() == [True, False, True]
    view.post_reset()
    np.testing.assert_allclose(view.get_world_poses()[0][:, 0], (0, 1, 2))
    with pytest.raises(BadPrim, match="no prim matches"):
        XFormPrim("/World/none_.*")


def test_the_backend_chooses_the_arrays(stage):
    view = XFormPrim(cubes(stage, 1))
    SimulationManager.set_backend("warp")
    assert type(view.get_world_poses()[0]).__module__.startswith("warp")
    SimulationManager.set_backend("jax")
    with pytest.raises(ValueError, match="no backend 'jax'"):
        view.get_world_poses()


def test_a_single_prim_has_no_rows(stage):
    prim = SingleXFormPrim("/World/made", position=(1, 2, 3), orientation=(0.5, 0.5, 0.5, 0.5), visible=False)
    assert prim.prim.GetTypeName() == "Xform"
    position, orientation = prim.get_world_pose()
    np.testing.assert_allclose(np.hstack([position, orientation]), (1, 2, 3, 0.5, 0.5, 0.5, 0.5), atol=1e-6)
    assert prim.get_visibility() is False
    prim.set_default_state(position=np.array([0, 0, 9]))
    prim.set_local_pose((7, 7, 7))
    prim.post_reset()
    np.testing.assert_allclose(prim.get_world_pose()[0], (0, 0, 9), atol=1e-6)
    np.testing.assert_allclose(prim.get_default_state().position, (0, 0, 9))


def test_bodies_have_velocities_masses_and_states(stage):
    view = RigidPrim(cubes(stage, 2), masses=[1.0, 2.0], linear_velocities=[(1, 0, 0), (0, 1, 0)])
    assert view.get_masses().tolist() == [1, 2]
    np.testing.assert_allclose(view.get_inv_masses(), (1, 0.5))
    view.set_velocities([(0, 0, 1, 0, 0, np.pi)], indices=[0])
    np.testing.assert_allclose(view.get_velocities()[0], (0, 0, 1, 0, 0, np.pi), atol=1e-6)
    view.post_reset()
    assert view.get_linear_velocities().tolist() == [[1, 0, 0], [0, 1, 0]]
    view.disable_gravities([1])
    view.disable_rigid_body_physics([0])
    assert UsdPhysics.RigidBodyAPI(view.prims[0]).GetRigidBodyEnabledAttr().Get() is False
    state = view.get_current_dynamic_state()
    assert state.positions.shape == state.linear_velocities.shape == (2, 3)


def test_velocities_that_are_not_written_are_read_from_the_simulation(stage):
    get_settings().set("/physics/updateVelocitiesToUsd", False)
    view = RigidPrim(cubes(stage, 1), linear_velocities=[(1, 0, 0)])
    timeline = get_timeline()
    timeline.play()
    for _ in range(3):
        engines.physics().step(1 / 60)
    get_settings().set("/physics/updateVelocitiesToUsd", True)  # from the next play on
    linear = view.get_linear_velocities()[0]
    np.testing.assert_allclose(linear[:2], (1, 0), atol=1e-3)
    assert linear[2] < -0.1
    assert tuple(UsdPhysics.RigidBodyAPI(view.prims[0]).GetVelocityAttr().Get()) == (1, 0, 0)
    timeline.stop()
    np.testing.assert_allclose(view.get_linear_velocities()[0], (1, 0, 0))


def test_masses_that_physics_finds_are_read_from_the_simulation(stage):
    view = RigidPrim(cubes(stage, 2))
    UsdPhysics.CollisionAPI.Apply(view.prims[0])
    UsdPhysics.MassAPI.Apply(view.prims[0]).CreateDensityAttr(500.0)
    UsdPhysics.MassAPI.Apply(view.prims[1]).CreateMassAttr(3.0)
    assert view.get_masses().tolist() == [0, 3]
    get_timeline().play()
    size = np.prod(UsdGeom.BBoxCache(0, ["default"]).ComputeWorldBound(view.prims[0]).ComputeAlignedRange().GetSize())
    np.testing.assert_allclose(view.get_masses(), (500 * size, 3), rtol=1e-5)
    get_timeline().stop()


def test_a_single_body_is_made_and_moved(stage):
    cubes(stage, 1)
    body = SingleRigidPrim("/World/cube_0", mass=3.0, linear_velocity=np.array([0, 0, 2.0]))
    assert body.prim.HasAPI(UsdPhysics.RigidBodyAPI)
    assert body.get_mass() == 3.0
    assert body.get_linear_velocity().tolist() == [0, 0, 2]
    body.set_angular_velocity(np.array([0, 0, 1.0]))
    np.testing.assert_allclose(body.get_current_dynamic_state().angular_velocity, (0, 0, 1), atol=1e-6)
    body.set_default_state(position=(0, 0, 4), linear_velocity=(0, 0, 0))
    body.post_reset()
    np.testing.assert_allclose(body.get_world_pose()[0], (0, 0, 4), atol=1e-6)
    assert body.get_linear_velocity().tolist() == [0, 0, 0]
    with pytest.raises(BadPrim):
        SingleRigidPrim("/World/none")


def test_colliders_have_approximations_offsets_and_materials(stage):
    view = GeometryPrim(cubes(stage, 2), collisions=[True, False])
    assert view.is_collision_enabled().tolist() == [True, False]
    view.enable_collision()
    view.set_collision_approximations(["convexHull", "boundingCube"])
    assert view.get_collision_approximations() == ["convexHull", "boundingCube"]
    view.set_contact_offsets([0.1, 0.2])
    np.testing.assert_allclose(view.get_contact_offsets(), (0.1, 0.2))
    rubber, red = PhysicsMaterial("/World/rubber", static_friction=0.9), PreviewSurface("/World/red", color=(1, 0, 0))
    view.apply_physics_materials(rubber)
    view.apply_visual_materials(red)
    assert view.get_applied_physics_materials()[1].get_static_friction() == pytest.approx(0.9)
    assert view.get_applied_physics_materials()[0] is rubber
    single = SingleGeometryPrim("/World/cube_0")
    assert single.get_collision_approximation() == "convexHull"
    assert single.get_applied_visual_material().get_color().tolist() == [1, 0, 0]
    single.set_collision_enabled(False)
    assert not single.get_collision_enabled()
