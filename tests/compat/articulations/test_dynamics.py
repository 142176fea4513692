"""Jacobians, mass matrices and forces of joints: against differences of poses, energies and simulated velocities."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from tests.articulations.robots import joint, link
from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.core import prims as core
from usdsdg.compat.isaacsim.core.experimental import prims as experimental
from usdsdg.errors import Unsupported
from usdsdg.session import engines
from usdsdg.session.timeline import get_timeline

ROOT = "/World/Arm"
POSE = np.array([0.4, -0.7, 0.2])


@pytest.fixture
def make_arm(stage):
    """A turning column, a shoulder whose body 1 is nearer to the base, and a slider; masses off the links' origins."""

    def make(*, fixed: bool):
        prim = stage.DefinePrim(ROOT, "Xform")
        UsdPhysics.ArticulationRootAPI.Apply(prim)
        UsdPhysics.Scene.Define(stage, "/scene")
        for name, at in (("base", (0, 0, 1)), ("column", (0, 0, 1.5)), ("upper", (0, 0, 2)), ("rod", (1, 0, 2))):
            body = link(stage, f"{ROOT}/{name}", at)
            mass = UsdPhysics.MassAPI.Apply(body)
            mass.CreateMassAttr(1.0 + at[2])
            mass.CreateCenterOfMassAttr(Gf.Vec3f(0.1, -0.05, 0.2))
            mass.CreateDiagonalInertiaAttr(Gf.Vec3f(0.2, 0.3, 0.4))
        if fixed:
            joint(stage, f"{ROOT}/fixed", UsdPhysics.FixedJoint, "", f"{ROOT}/base", pos0=(0, 0, 1))
        joint(
            stage, f"{ROOT}/turn", UsdPhysics.RevoluteJoint, f"{ROOT}/base", f"{ROOT}/column", pos0=(0, 0, 0.5)
        )  # fmt: skip
        joint(
            stage, f"{ROOT}/lift", UsdPhysics.RevoluteJoint, f"{ROOT}/upper", f"{ROOT}/column",
            pos1=(0, 0, 0.5), axis="Y",
        )  # fmt: skip
        joint(
            stage, f"{ROOT}/slide", UsdPhysics.PrismaticJoint, f"{ROOT}/upper", f"{ROOT}/rod",
            pos0=(1, 0, 0), axis="X", lower=-0.5, upper=0.5,
        )  # fmt: skip
        view = core.Articulation(ROOT, reset_xform_properties=False)
        get_timeline().play()
        get_app().update()
        view.set_joint_velocities(np.zeros(3))
        view.set_joint_positions(POSE)
        return view

    return make


def centers(view) -> tuple[np.ndarray, np.ndarray]:
    """Centers of mass (L, 3) and orientations (L, 3, 3) of the links, from the stage alone."""
    cache = UsdGeom.XformCache()
    found = [np.array(cache.GetLocalToWorldTransform(prim)) for prim in view._links.prims([0], range(view.num_bodies))]
    return np.array([(np.array([0.1, -0.05, 0.2, 1]) @ each)[:3] for each in found]), np.array(found)[:, :3, :3]


def energy(masses, velocities, turns) -> float:
    """Kinetic energy of links with the velocities (L, 6)."""
    inertia = np.einsum("lji,jk,lkm->lim", turns, np.diag([0.2, 0.3, 0.4]), turns)
    spin = np.einsum("li,lij,lj->", velocities[:, 3:], inertia, velocities[:, 3:])
    return 0.5 * float((masses * (velocities[:, :3] ** 2).sum(axis=1)).sum() + spin)


def test_a_jacobian_is_the_derivative_of_poses_by_joint_positions(make_arm):
    view = make_arm(fixed=True)
    found = view.get_jacobians()[0]
    assert view.get_jacobian_shape() == found.shape == (3, 6, 3)  # without the base
    assert view.body_names == ["base", "column", "upper", "rod"]
    step = 1e-3
    for column in range(3):
        sides = []
        for sign in (1, -1):
            view.set_joint_positions(POSE + sign * step * np.eye(3)[column])
            sides.append(centers(view))
        (after, turned), (before, turned_before) = sides
        linear = (after - before) / (2 * step)
        spin = np.einsum("lji,ljk->lik", turned_before, turned)  # row vectors: before⁻¹ · after
        angular = np.stack(
            [spin[:, 1, 2] - spin[:, 2, 1], spin[:, 2, 0] - spin[:, 0, 2], spin[:, 0, 1] - spin[:, 1, 0]]
        )
        # Central differences of step 1e-3 leave an error of its square, and float32 poses one of 1e-7 / 1e-3.
        assert found[:, :3, column] == pytest.approx(linear[1:], abs=5e-4)
        assert found[:, 3:, column] == pytest.approx(angular.T[1:] / (4 * step), abs=5e-4)


def test_six_columns_come_first_where_nothing_fixes_the_base(make_arm):
    view = make_arm(fixed=False)
    view.set_velocities([[0.1, 0.2, -0.3, 0.5, -0.4, 0.3]])
    view.set_joint_velocities([0.7, -0.2, 0.4])
    get_app().update()
    links = [str(prim.GetPath()) for prim in view._links.prims([0], range(4))]
    speeds = np.concatenate([view.get_velocities()[0], view.get_joint_velocities()[0]])
    found = view.get_jacobians()[0]
    assert found.shape == (4, 6, 9)
    assert found[0] == pytest.approx(np.eye(6, 9), abs=1e-6)
    assert found @ speeds == pytest.approx(engines.physics().velocities(links), abs=1e-3)


@pytest.mark.parametrize("fixed", [True, False])
def test_a_mass_matrix_gives_the_kinetic_energy(make_arm, fixed):
    view = make_arm(fixed=fixed)
    if not fixed:
        view.set_velocities([[0.1, 0.2, -0.3, 0.5, -0.4, 0.3]])
    view.set_joint_velocities([0.7, -0.2, 0.4])
    links = [str(prim.GetPath()) for prim in view._links.prims([0], range(4))]
    speeds = view.get_joint_velocities()[0]
    speeds = speeds if fixed else np.concatenate([view.get_velocities()[0], speeds])
    matrix = view.get_mass_matrices()[0]
    assert matrix.shape == view.get_mass_matrix_shape() == (len(speeds), len(speeds))
    assert matrix == pytest.approx(matrix.T, abs=1e-6)
    simulated = energy(view.get_body_masses()[0], engines.physics().velocities(links), centers(view)[1])
    assert 0.5 * speeds @ matrix @ speeds == pytest.approx(simulated, rel=1e-4)


def test_gravity_forces_are_the_slope_of_the_potential_energy(make_arm):
    view = make_arm(fixed=True)
    found = view.get_generalized_gravity_forces()[0]
    masses, slope, step = view.get_body_masses()[0], [], 1e-3
    for column in range(3):
        heights = []
        for sign in (1, -1):
            view.set_joint_positions(POSE + sign * step * np.eye(3)[column])
            heights.append(9.81 * (masses * centers(view)[0][:, 2]).sum())
        slope.append((heights[0] - heights[1]) / (2 * step))
    assert found == pytest.approx(slope, abs=0.05)  # 20 kg 9.81 m/s² 1e-7 m / 1e-3
    view.set_body_disable_gravity(np.ones(4))
    assert view.get_generalized_gravity_forces()[0] == pytest.approx(np.zeros(3), abs=1e-6)


def test_coriolis_forces_follow_from_how_the_mass_matrix_changes(make_arm):
    view, speeds, step = make_arm(fixed=True), np.array([0.7, -0.9, 0.4]), 1e-2
    view.set_joint_velocities(speeds)
    found = view.get_coriolis_and_centrifugal_forces()[0]
    slopes = []
    for column in range(3):
        sides = []
        for sign in (1, -1):
            view.set_joint_positions(POSE + sign * step * np.eye(3)[column])
            sides.append(view.get_mass_matrices()[0].astype(np.float64))
        slopes.append((sides[0] - sides[1]) / (2 * step))
    change = np.einsum("k,kij,j->i", speeds, slopes, speeds)
    assert found == pytest.approx(change - 0.5 * np.einsum("i,kij,j->k", speeds, slopes, speeds), abs=1e-2)


def test_computed_torques_hold_an_arm(make_arm):
    view = make_arm(fixed=True)
    for _ in range(60):
        view.set_joint_efforts(view.get_generalized_gravity_forces())
        get_app().update()
    # Without them the rod, of 3 kg, would have fallen for a second.
    assert view.get_joint_positions()[0] == pytest.approx(POSE, abs=0.01)


def test_warp_arrays_are_the_same(make_arm):
    view = make_arm(fixed=True)
    other = experimental.Articulation(ROOT)
    assert (other.jacobian_matrix_shape, other.mass_matrix_shape) == ((3, 6, 3), (3, 3))
    assert other.get_jacobian_matrices().numpy() == pytest.approx(view.get_jacobians())
    assert other.get_mass_matrices().numpy() == pytest.approx(view.get_mass_matrices())
    gravity = other.get_dof_gravity_compensation_forces(dof_indices=[1]).numpy()
    assert gravity == pytest.approx(view.get_generalized_gravity_forces(joint_indices=[1]))
    coriolis = other.get_dof_coriolis_and_centrifugal_compensation_forces().numpy()
    assert coriolis == pytest.approx(view.get_coriolis_and_centrifugal_forces())


def test_before_physics_plays_there_are_none(stage, make_arm):
    make_arm(fixed=True)
    get_timeline().stop()
    with pytest.warns(UserWarning, match="get_jacobians does nothing"):
        assert core.Articulation(ROOT, "other", reset_xform_properties=False).get_jacobians() is None
    with pytest.raises(AssertionError, match="play first"):
        experimental.Articulation(ROOT).get_jacobian_matrices()


def test_joints_with_several_axes_are_refused(stage, make_arm):
    link(stage, f"{ROOT}/ball", (2, 0, 2))
    made = UsdPhysics.SphericalJoint.Define(stage, f"{ROOT}/socket")
    made.CreateBody0Rel().SetTargets([f"{ROOT}/rod"])
    made.CreateBody1Rel().SetTargets([f"{ROOT}/ball"])
    made.CreateLocalPos0Attr(Gf.Vec3f(1, 0, 0))
    with pytest.raises(Unsupported, match="/World/Arm/socket"):
        make_arm(fixed=True).get_jacobians()
