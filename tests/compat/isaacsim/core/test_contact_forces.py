"""Contact forces of `isaacsim.core.prims` and its experimental form, against weights and friction."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import UsdGeom, UsdPhysics

from usdsdg.compat.isaacsim.core.api.materials import PhysicsMaterial
from usdsdg.compat.isaacsim.core.api.sensors import RigidContactView
from usdsdg.compat.isaacsim.core.experimental.prims import RigidPrim as ExperimentalRigidPrim
from usdsdg.compat.isaacsim.core.prims import GeometryPrim, RigidPrim, SingleGeometryPrim
from usdsdg.compat.isaacsim.core.simulation_manager import SimulationManager
from usdsdg.errors import BadPrim, BadValue, UsdsdgWarning
from usdsdg.session import engines
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.physics.ground_plane import add_ground_plane

STEP = 1 / 60
G = 9.81
MASS = 2.0
GROUND = "/World/ground"


def add_box(stage, path, *, at=(0, 0, 0.5), size=1.0, scale=(1, 1, 1)):
    """A collider, on the ground by default."""
    cube = UsdGeom.Cube.Define(stage, path)
    cube.CreateSizeAttr(size)
    cube.AddTranslateOp().Set(at)
    cube.AddScaleOp().Set(scale)
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())


def bodies(paths, **arguments):
    """A view of boxes of 2 kg where they are."""
    return RigidPrim(paths, masses=[MASS], reset_xform_properties=False, **arguments)


def play(steps=60):
    get_timeline().play()
    for _ in range(steps):
        engines.physics().step(STEP)


@pytest.mark.parametrize("meters", [1.0, 0.01])
def test_the_contacts_of_a_box_at_rest_carry_its_weight(stage, meters):
    UsdGeom.SetStageMetersPerUnit(stage, meters)
    size, weight = 0.2 / meters, MASS * G / meters
    add_ground_plane(stage, GROUND)
    add_box(stage, "/World/box", size=size, at=(0, 0, size / 2))
    view = bodies("/World/box", contact_filter_prim_paths_expr=[GROUND], max_contact_count=10)
    ground = GeometryPrim(GROUND, track_contact_forces=True, reset_xform_properties=False)
    play()
    net = view.get_net_contact_forces(dt=STEP)
    np.testing.assert_allclose(net, [(0, 0, weight)], rtol=1e-2, atol=1e-3 * weight)
    np.testing.assert_allclose(view.get_net_contact_forces(), net * STEP, rtol=1e-5)  # impulses
    np.testing.assert_allclose(view.get_contact_force_matrix(dt=STEP), net[:, None])
    np.testing.assert_allclose(ground.get_net_contact_forces(dt=STEP), -net)
    forces, points, normals, separations, count, start = view.get_contact_force_data(dt=STEP)
    shapes = [each.shape for each in (forces, points, normals, separations, count, start)]
    assert shapes == [(10, 1), (10, 3), (10, 3), (10, 1), (1, 1), (1, 1)]
    assert (count.tolist(), start.tolist()) == ([[4]], [[0]])
    np.testing.assert_allclose((forces * normals)[:4].sum(0), net[0], rtol=1e-5, atol=1e-4 * weight)
    np.testing.assert_allclose(np.abs(points[:4]), [(size / 2, size / 2, 0)] * 4, atol=0.02 * size)
    np.testing.assert_allclose(normals[:4], [(0, 0, 1)] * 4, atol=1e-4)
    assert not forces[4:].any()
    get_timeline().stop()
    with pytest.warns(UsdsdgWarning, match="get_net_contact_forces returns None"):
        assert view.get_net_contact_forces() is None


def test_the_lower_of_two_boxes_bears_both(stage):
    add_ground_plane(stage, GROUND)
    add_box(stage, "/World/low")
    add_box(stage, "/World/high", at=(0, 0, 1.5))
    view = bodies(["/World/low", "/World/high"], contact_filter_prim_paths_expr=[GROUND, "/World/low", "/World/high"])
    play()
    up = np.array([0, 0, MASS * G])
    close = dict(rtol=1e-2, atol=0.05)
    np.testing.assert_allclose(view.get_net_contact_forces(dt=STEP), [up, up], **close)
    np.testing.assert_allclose(
        view.get_contact_force_matrix(dt=STEP), [[2 * up, 0 * up, -up], [0 * up, up, 0 * up]], **close
    )
    np.testing.assert_allclose(view.get_net_contact_forces([1], dt=STEP), [up], **close)


def test_a_sliding_box_feels_the_friction_of_its_material(stage):
    add_ground_plane(stage, GROUND)
    add_box(stage, "/World/box", scale=(1, 1, 0.5), at=(0, 0, 0.25))
    friction = 0.4
    rough = PhysicsMaterial("/World/rough", static_friction=friction, dynamic_friction=friction)
    for path in ("/World/box", f"{GROUND}/collisionPlane"):
        SingleGeometryPrim(path, reset_xform_properties=False, collision=True).apply_physics_material(rough)
    view = bodies(
        "/World/box", linear_velocities=[(6.0, 0, 0)], contact_filter_prim_paths_expr=[GROUND], max_contact_count=8
    )
    play(30)
    assert view.get_linear_velocities()[0, 0] > 3.0
    forces, points, count, start = view.get_friction_data(dt=STEP)
    assert (forces.shape, points.shape, start.tolist()) == ((8, 3), (8, 3), [[0]])
    np.testing.assert_allclose(forces[: count[0, 0]].sum(0), (-friction * MASS * G, 0, 0), rtol=0.02, atol=0.05)
    # Contact forces are along the normals.
    np.testing.assert_allclose(view.get_net_contact_forces(dt=STEP), [(0, 0, MASS * G)], rtol=0.02, atol=0.05)


def table(stage):
    """A table of 2 kg whose legs and top are three colliders, and a mug of 2 kg on it, a body below the table."""
    add_ground_plane(stage, GROUND)
    UsdGeom.Xform.Define(stage, "/World/table")
    for index, x in enumerate((-1, 1)):
        add_box(stage, f"/World/table/leg_{index}", at=(x, 0, 0.5), scale=(0.2, 1, 1))
    add_box(stage, "/World/table/top", at=(0, 0, 1.1), scale=(2.4, 1, 0.2))
    add_box(stage, "/World/table/mug", at=(0, 0, 1.3), scale=(0.2, 0.2, 0.2))


def test_the_colliders_of_a_body_are_summed_without_the_bodies_below_it(stage):
    table(stage)
    view = bodies(["/World/table", "/World/table/mug"], contact_filter_prim_paths_expr=[GROUND], max_contact_count=40)
    legs = GeometryPrim("/World/table/leg_*", track_contact_forces=True, reset_xform_properties=False)
    play()
    up = np.array([0, 0, MASS * G])
    close = dict(rtol=1e-2, atol=0.05)
    np.testing.assert_allclose(view.get_net_contact_forces(dt=STEP), [up, up], **close)
    np.testing.assert_allclose(view.get_contact_force_matrix(dt=STEP)[:, 0], [2 * up, 0 * up], **close)
    np.testing.assert_allclose(legs.get_net_contact_forces(dt=STEP), [up, up], rtol=0.1, atol=0.5)
    count, start = view.get_contact_force_data()[4:]
    assert (count.tolist(), start.tolist()) == ([[8], [0]], [[0], [8]])


def test_a_filter_is_one_prim_for_all_or_one_for_each(stage):
    add_ground_plane(stage, GROUND)
    for index in range(2):
        add_box(stage, f"/World/low_{index}", at=(3 * index, 0, 0.5))
        add_box(stage, f"/World/high_{index}", at=(3 * index, 0, 1.5))
    view = RigidContactView("/World/low_*", ["/World/high_*", GROUND], max_contact_count=5)
    for each in ("/World/low_.*", "/World/high_.*"):
        bodies(each)
    assert (view.num_shapes, view.num_filters, view.is_physics_handle_valid()) == (2, 2, False)
    play()
    up = np.array([0, 0, MASS * G])
    np.testing.assert_allclose(
        view.get_contact_force_matrix(dt=STEP), [[-up, 2 * up], [-up, 2 * up]], rtol=1e-2, atol=0.05
    )
    with pytest.warns(UsdsdgWarning, match="16 contact points, of which max_contact_count=5"):
        forces, *_, count, start = view.get_contact_force_data()
    assert (len(forces), count.tolist(), start.tolist()) == (5, [[4, 1], [0, 0]], [[0, 4], [5, 5]])
    with pytest.raises(BadValue, match="one for each of the 2"):
        RigidContactView("/World/low_*", ["/World/*"]).get_net_contact_forces()
    with pytest.raises(BadPrim, match="contact filter /World/none"):
        RigidContactView("/World/low_*", ["/World/none"]).get_net_contact_forces()
    with pytest.raises(BadPrim, match="no prim matches /World/none"):
        RigidContactView("/World/none", [])


def test_what_is_not_tracked_is_told(stage):
    add_ground_plane(stage, GROUND)
    add_box(stage, "/World/box")
    view = bodies("/World/box")
    with pytest.warns(UsdsdgWarning, match="track_contact_forces=True"):
        assert view.get_net_contact_forces() is None
    for getter in (view.get_contact_force_matrix, view.get_contact_force_data, view.get_friction_data):
        with pytest.warns(UsdsdgWarning, match="contact_filter_prim_paths_expr"):
            assert getter() is None
    unprepared = SingleGeometryPrim("/World/box", reset_xform_properties=False, track_contact_forces=True)
    play(1)
    with pytest.warns(UsdsdgWarning, match="no PhysxContactReportAPI"):
        assert unprepared.get_net_contact_forces().tolist() == [0, 0, 0]


def test_a_single_collider_has_no_rows(stage):
    add_ground_plane(stage, GROUND)
    add_box(stage, "/World/box")
    bodies("/World/box")
    prim = SingleGeometryPrim(
        "/World/box", reset_xform_properties=False, prepare_contact_sensor=True, contact_filter_prim_paths_expr=[GROUND]
    )
    play()
    np.testing.assert_allclose(prim.get_net_contact_forces(STEP), (0, 0, MASS * G), rtol=1e-2, atol=0.05)
    assert prim.get_contact_force_matrix(STEP).shape == (1, 3)
    assert [each.tolist() for each in prim.get_contact_force_data()[-2:]] == [[4], [0]]
    assert [each.tolist() for each in prim.get_friction_data()[-2:]] == [[4], [0]]


def test_experimental_bodies_track_contacts_by_filter_and_with_anything(stage):
    add_ground_plane(stage, GROUND)
    for index in range(2):
        add_box(stage, f"/World/box_{index}", at=(3 * index, 0, 0.5))
    plain = ExperimentalRigidPrim("/World/box_.*", masses=MASS)
    assert plain.get_enabled_contact_tracking().numpy().tolist() == [[False], [False]]
    view = ExperimentalRigidPrim("/World/box_.*", contact_filter_paths=[GROUND, "/World/box_0"], max_contact_count=10)
    everything = ExperimentalRigidPrim("/World/box_.*", max_contact_count=10)
    assert view.get_enabled_contact_tracking().numpy().all()
    with pytest.raises(AssertionError, match="play"):
        view.get_net_contact_forces()
    SimulationManager.initialize_physics()
    SimulationManager.step(steps=60)
    up = np.array([0, 0, MASS * G])
    np.testing.assert_allclose(view.get_net_contact_forces(dt=STEP).numpy(), [up, up], rtol=1e-2, atol=0.05)
    # As many filters as bodies: one for each.
    assert view.num_contact_filters == 1
    matrix = view.get_contact_force_matrix(dt=STEP).numpy()
    np.testing.assert_allclose(matrix, [[up], [0 * up]], rtol=1e-2, atol=0.05)
    assert [each.shape for each in view.get_friction_data()] == [(10, 3), (10, 3), (2, 1), (2, 1)]
    *_, count, start = view.get_contact_force_data(indices=[1])
    assert (count.numpy().tolist(), start.numpy().tolist()) == ([[0]], [[4]])
    forces, *_, count, start, touched = everything.get_raw_contact_data(dt=STEP)
    assert (count.numpy().tolist(), start.numpy().tolist()) == ([4, 4], [0, 4])
    np.testing.assert_allclose(forces.numpy().sum(), 2 * MASS * G, rtol=1e-2)
    assert set(everything.get_actor_paths_from_ids(touched.numpy()[:8])) == {f"{GROUND}/collisionPlane"}
    with pytest.raises(AssertionError, match="no contact filters"):
        everything.get_contact_force_matrix()
    with pytest.raises(AssertionError, match="not tracked"):
        plain.get_net_contact_forces()


def test_contacts_below_the_threshold_of_a_body_are_not_reported(stage):
    add_ground_plane(stage, GROUND)
    for index in range(3):
        add_box(stage, f"/World/box_{index}", at=(3 * index, 0, 0.5))
    view = ExperimentalRigidPrim("/World/box_.*", masses=MASS, max_contact_count=20)
    SimulationManager.initialize_physics()
    SimulationManager.step(steps=30)
    # While physics plays: one above its weight, one below, one not at all.
    view.set_enabled_contact_tracking(True, indices=[0, 1], threshold=1.2 * MASS * G)
    view.set_enabled_contact_tracking(True, indices=1, threshold=0.8 * MASS * G)
    view.set_enabled_contact_tracking(False, indices=2)
    SimulationManager.step(steps=30)
    with pytest.warns(UsdsdgWarning, match="/World/box_2 has no PhysxContactReportAPI"):
        found = view.get_net_contact_forces(dt=STEP).numpy()
    np.testing.assert_allclose(found, [(0, 0, 0), (0, 0, MASS * G), (0, 0, 0)], rtol=1e-2, atol=0.05)
    assert view.get_enabled_contact_tracking().numpy().tolist() == [[True], [True], [False]]


def test_arrays_of_contacts_are_those_of_the_backend(stage):
    add_ground_plane(stage, GROUND)
    add_box(stage, "/World/box")
    view = bodies("/World/box", contact_filter_prim_paths_expr=[GROUND], max_contact_count=4)
    play(10)
    SimulationManager.set_backend("warp")
    assert view.get_net_contact_forces().shape == (1, 3)
    assert [each.shape for each in view.get_friction_data()] == [(4, 3), (4, 3), (1, 1), (1, 1)]
