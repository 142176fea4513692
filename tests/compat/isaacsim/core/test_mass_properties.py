"""Masses, centers of mass and inertias of `isaacsim.core.prims`, against closed forms and motion."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from usdsdg.compat.isaacsim.core.experimental.prims import RigidPrim as ExperimentalRigidPrim
from usdsdg.compat.isaacsim.core.prims import RigidPrim, SingleRigidPrim
from usdsdg.compat.isaacsim.core.simulation_manager import SimulationManager
from usdsdg.errors import BadValue, UsdsdgWarning
from usdsdg.session import engines
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.physics.ground_plane import add_ground_plane

STEP = 1 / 60
SIZE = np.array([2.0, 4.0, 6.0])
DENSITY = 0.5
# A rotation of 90° about z.
QUARTER = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))


def box_inertia(mass, size):
    """The inertia of a box about its center."""
    x, y, z = np.square(size)
    return mass / 12 * np.diag([y + z, x + z, x + y])


def add_box(stage, path, size, *, at=(0, 0, 0)):
    """A collider of a unit cube that is scaled."""
    cube = UsdGeom.Cube.Define(stage, path)
    cube.CreateSizeAttr(1.0)
    cube.AddTranslateOp().Set(at)
    cube.AddScaleOp().Set(Gf.Vec3f(*map(float, size)))
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
    return cube.GetPrim()


def turned_box(stage, *, at=(0, 0, 0)):
    """The box of `SIZE`, turned by 50° about an axis, as a view that plays without gravity."""
    add_box(stage, "/World/box", SIZE)
    view = RigidPrim("/World/box", positions=[at], orientations=[(0.9, 0.1, 0.3, 0.3)], densities=[DENSITY])
    view.disable_gravities()
    get_timeline().play()
    return view


@pytest.mark.parametrize("meters", [1.0, 0.01])
def test_a_box_has_the_inertia_of_a_box_in_units_of_the_stage(stage, meters):
    UsdGeom.SetStageMetersPerUnit(stage, meters)
    view = turned_box(stage)
    mass = DENSITY * SIZE.prod()
    assert view.get_masses() == pytest.approx([mass])
    positions, orientations = view.get_coms()
    assert (positions.shape, orientations.shape, positions.dtype) == ((1, 1, 3), (1, 1, 4), np.float32)
    np.testing.assert_allclose(np.concatenate([positions, orientations], 2), [[(0, 0, 0, 1, 0, 0, 0)]], atol=1e-6)
    expected = box_inertia(mass, SIZE)
    np.testing.assert_allclose(view.get_inertias(), [expected.ravel()], rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(view.get_inv_inertias(), [np.linalg.inv(expected).ravel()], rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("meters", [1.0, 0.01])
def test_colliders_off_the_center_add_by_the_parallel_axis_theorem(stage, meters):
    UsdGeom.SetStageMetersPerUnit(stage, meters)
    UsdGeom.Xform.Define(stage, "/World/body")
    parts = [(SIZE, np.array([3.0, 0.0, 1.0])), (np.array([1.0, 1.0, 2.0]), np.array([-2.0, 5.0, 0.0]))]
    for index, (size, place) in enumerate(parts):
        add_box(stage, f"/World/body/part_{index}", size, at=tuple(place))
    UsdPhysics.RigidBodyAPI.Apply(add_box(stage, "/World/body/loose", SIZE, at=(50, 0, 0)))  # a body of its own
    view = RigidPrim("/World/body", densities=[DENSITY])
    assert view.num_shapes == 2
    get_timeline().play()
    masses = [DENSITY * size.prod() for size, _ in parts]
    center = sum(mass * place for mass, (_, place) in zip(masses, parts)) / sum(masses)
    inertia = np.zeros((3, 3))
    for mass, (size, place) in zip(masses, parts):
        arm = place - center
        inertia += box_inertia(mass, size) + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    np.testing.assert_allclose(view.get_coms()[0], [[center]], rtol=1e-5)
    np.testing.assert_allclose(view.get_inertias(), [inertia.ravel()], rtol=1e-4, atol=1e-3)
    # The principal axes make it diagonal, and are the nearest to the body's own.
    w, x, y, z = view.get_coms()[1][0, 0].astype(float)
    axes = np.array(Gf.Matrix3d(Gf.Quatd(w, x, y, z))).T
    turned = axes.T @ inertia @ axes
    assert np.abs(turned - np.diag(np.diagonal(turned))).max() < 1e-4 * np.abs(turned).max()
    assert (np.diagonal(axes) > 0.5).all()


def test_a_center_of_mass_is_set_in_the_frame_of_the_body_and_authored_in_that_of_the_prim(stage):
    view = turned_box(stage)
    before = view.get_inertias()
    view.set_coms([[(0.5, 1.0, -1.5)]])
    np.testing.assert_allclose(view.get_coms()[0], [[(0.5, 1.0, -1.5)]], atol=1e-5)
    authored = UsdPhysics.MassAPI(view.prims[0]).GetCenterOfMassAttr().Get()
    np.testing.assert_allclose(authored, np.array([0.5, 1.0, -1.5]) / SIZE, atol=1e-6)
    np.testing.assert_allclose(view.get_inertias(), before, rtol=1e-5, atol=1e-4)


def test_principal_axes_that_are_set_turn_the_inertia(stage):
    view = turned_box(stage)
    xx, yy, zz = np.diagonal(view.get_inertias().reshape(3, 3))
    view.set_coms(orientations=[[QUARTER]])
    np.testing.assert_allclose(view.get_inertias()[0].reshape(3, 3), np.diag([yy, xx, zz]), rtol=1e-5, atol=1e-3)
    np.testing.assert_allclose(view.get_coms()[1], [[QUARTER]], atol=1e-6)


def test_an_inertia_that_is_set_says_how_a_torque_turns_the_body(stage):
    view = turned_box(stage)
    inertia = np.array([[40.0, 6.0, -3.0], [6.0, 50.0, 5.0], [-3.0, 5.0, 30.0]])
    view.set_inertias(inertia.reshape(1, 1, 9))
    np.testing.assert_allclose(view.get_inertias(), [inertia.ravel()], rtol=1e-4, atol=1e-4)
    torque = np.array([30.0, -60.0, 20.0])
    w, x, y, z = view.get_world_poses()[1][0].astype(float)
    axes = np.array(Gf.Matrix3d(Gf.Quatd(w, x, y, z))).T
    view.apply_forces_and_torques_at_pos(torques=[torque], is_global=False)
    engines.physics().step(STEP)
    expected = axes @ np.linalg.solve(inertia, torque) * STEP
    np.testing.assert_allclose(view.get_angular_velocities(), [expected], rtol=5e-3)
    with pytest.raises(BadValue, match="not positive"):
        view.set_inertias(np.diag([1.0, -1.0, 1.0]).reshape(1, 9))


def test_a_box_tips_when_its_center_of_mass_leaves_the_base_while_physics_plays(stage):
    add_ground_plane(stage, "/World/ground")
    add_box(stage, "/World/box", (1, 1, 2))
    body = SingleRigidPrim("/World/box", position=(0, 0, 1), mass=2.0)
    get_timeline().play()
    for _ in range(60):
        engines.physics().step(STEP)
    assert abs(body.get_world_pose()[1][0]) == pytest.approx(1.0, abs=1e-4)  # upright
    body.set_com((0.8, 0, 0), (1, 0, 0, 0))
    for _ in range(90):
        engines.physics().step(STEP)
    w, x, y, z = body.get_world_pose()[1]
    assert 2 * (x * z + w * y) > 0.9  # the box's z axis points along the world's x
    np.testing.assert_allclose(body.get_com()[0], [(0.8, 0, 0)], atol=1e-5)
    assert body.get_mass() == 2.0


def test_without_a_simulation_there_are_no_mass_properties(stage):
    add_box(stage, "/World/box", SIZE)
    view = RigidPrim("/World/box")
    with pytest.warns(UsdsdgWarning, match="get_coms"):
        assert view.get_coms() is None
    with pytest.warns(UsdsdgWarning, match="set_coms"):
        view.set_coms([(1, 1, 1)])
    for getter in (view.get_inertias, view.get_inv_inertias):
        with pytest.warns(UsdsdgWarning, match=getter.__name__):
            assert getter() is None
    with pytest.warns(UsdsdgWarning, match="set_inertias"):
        view.set_inertias(np.eye(3))
    assert not view.prims[0].HasAPI(UsdPhysics.MassAPI)
    with pytest.raises(AssertionError, match="play"):
        ExperimentalRigidPrim("/World/box").get_coms()


def test_arrays_of_warp_have_a_row_for_each_body(stage):
    for name in "ab":
        add_box(stage, f"/World/{name}", SIZE, at=(10 * (name == "b"), 0, 0))
    view = ExperimentalRigidPrim("/World/[ab]", densities=DENSITY)
    view.set_enabled_gravities(False)
    SimulationManager.set_backend("warp")
    SimulationManager.initialize_physics()
    view.set_coms((0.1, 0.2, 0.3), indices=1)
    positions, orientations = view.get_coms()
    np.testing.assert_allclose(positions.numpy(), [(0, 0, 0), (0.1, 0.2, 0.3)], atol=1e-6)
    assert orientations.shape == (2, 4)
    expected = box_inertia(DENSITY * SIZE.prod(), SIZE)
    np.testing.assert_allclose(view.get_inertias().numpy(), [expected.ravel()] * 2, rtol=1e-4, atol=1e-3)
    inverse = view.get_inertias(inverse=True, indices=[0]).numpy()
    np.testing.assert_allclose(inverse, [np.linalg.inv(expected).ravel()], rtol=1e-4, atol=1e-6)
    view.set_inertias(2 * expected.ravel(), indices=[0])
    np.testing.assert_allclose(view.get_inertias(indices=0).numpy(), [2 * expected.ravel()], rtol=1e-4, atol=1e-3)
    older = RigidPrim("/World/[ab]", reset_xform_properties=False)
    assert older.get_coms()[0].shape == (2, 3)
    assert view.num_shapes == 1


def pushed(view, force=2.0):
    """Return the speed that a force gives a body within a step."""
    view.set_velocities(np.zeros((1, 6), np.float32))
    view.apply_forces(np.array([[force, 0.0, 0.0]], np.float32))
    SimulationManager.step()
    return float(view.get_linear_velocities()[0, 0])


@pytest.mark.parametrize("experimental", [False, True])
def test_masses_that_are_set_while_physics_plays_are_those_of_the_stage_after_it(stage, experimental):
    prim = add_box(stage, "/World/box", (1, 1, 1))
    view = ExperimentalRigidPrim("/World/box") if experimental else RigidPrim("/World/box")
    view.set_masses([3.0])  # on the stage
    center, inertia = UsdPhysics.MassAPI(prim).GetCenterOfMassAttr(), UsdPhysics.MassAPI(prim).GetDiagonalInertiaAttr()
    for _ in range(2):  # or what a script draws for each episode would add up
        get_timeline().play()
        SimulationManager.step()
        coms = np.array(view.get_coms()[0])
        np.testing.assert_allclose(coms, 0.0, atol=1e-6)
        view.set_masses(np.array(view.get_masses()) * 2)
        view.set_coms(positions=coms + 0.1)
        view.set_inertias(np.array(view.get_inertias()) * 3)
        SimulationManager.step()
        assert np.array(view.get_masses()).ravel() == pytest.approx([6.0])
        np.testing.assert_allclose(np.array(view.get_coms()[0]).ravel(), 0.1, atol=1e-6)
        get_timeline().stop()
        assert np.array(view.get_masses()).ravel() == pytest.approx([3.0])
        assert not center.HasAuthoredValue()
        assert not inertia.HasAuthoredValue()


def test_masses_on_the_stage_stay_where_physics_has_not_begun_with_them(stage):
    add_box(stage, "/World/box", (1, 1, 1))
    view = RigidPrim("/World/box", masses=[2.0])
    view.disable_gravities()
    get_timeline().play()
    assert pushed(view) == pytest.approx(2.0 / 2.0 * STEP, rel=1e-4)
    view.set_masses([4.0])
    assert pushed(view) == pytest.approx(2.0 / 4.0 * STEP, rel=1e-4)
    add_box(stage, "/World/new", (1, 1, 1), at=(9, 0, 0))
    new = RigidPrim("/World/new", masses=[5.0])  # while physics plays, on the stage
    new.set_masses([6.0])  # before physics knows of it
    SimulationManager.step()
    get_timeline().stop()
    assert [each.get_masses()[0] for each in (view, new)] == [2.0, 6.0]
    get_timeline().play()
    assert pushed(view) == pytest.approx(2.0 / 2.0 * STEP, rel=1e-4)
