"""`Articulation` in both of Isaac Sim's forms: arrays of joints, by robot and column."""

import numpy as np
import pytest
from pxr import UsdGeom, UsdPhysics

from tests.articulations.robots import at, planar_arm
from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.core import prims as core
from usdsdg.compat.isaacsim.core.experimental import prims as experimental
from usdsdg.errors import PhysicsError, Unsupported, UsdsdgWarning
from usdsdg.session.timeline import get_timeline


@pytest.fixture
def arms(stage):
    for index in range(2):
        planar_arm(stage, f"/World/env_{index}/arm")
    drive = UsdPhysics.DriveAPI.Apply(stage.GetPrimAtPath("/World/env_1/arm/shoulder"), "angular")
    drive.CreateStiffnessAttr(1.0)
    return stage


def test_warp_arrays_have_a_row_per_robot_and_a_column_per_joint(arms):
    view = experimental.Articulation("/World/env_.*/arm")
    assert (view.num_dofs, view.dof_names) == (3, ["shoulder", "elbow", "slider"])
    assert view.get_dof_indices("elbow").numpy().tolist() == [1]
    view.set_dof_positions([[0.5]], indices=[1], dof_indices=[0])
    view.set_dof_velocities([0.1, 0.2, 0.3])
    assert view.get_dof_positions().numpy() == pytest.approx(np.array([[0, 0, 0], [0.5, 0, 0]]))
    assert view.get_dof_velocities(dof_indices=[2]).numpy() == pytest.approx(np.array([[0.3], [0.3]]))
    hand = arms.GetPrimAtPath("/World/env_1/arm/hand")
    assert at(hand) == pytest.approx([2 * np.cos(0.5), 2 * np.sin(0.5), 0], abs=1e-6)
    lower, upper = view.get_dof_limits(indices=[0])
    assert np.degrees(lower.numpy()[0, :2]) == pytest.approx([-170, -90])
    assert upper.numpy()[0, 2] == pytest.approx(0.5)


def test_targets_belong_to_drives(arms):
    view = experimental.Articulation("/World/env_.*/arm")
    view.set_dof_position_targets([0.25], indices=[1], dof_indices=[0])
    assert view.get_dof_position_targets(indices=[1]).numpy() == pytest.approx(np.array([[0.25, 0, 0]]))
    assert view.get_dof_gains()[0].numpy()[1, 0] == pytest.approx(180 / np.pi)
    with pytest.warns(UsdsdgWarning, match="/World/env_0/arm/shoulder has no drive"):
        view.set_dof_position_targets([0.5], indices=[0], dof_indices=[0])
    assert view.get_dof_position_targets(dof_indices=[0]).numpy()[:, 0] == pytest.approx([0.5, 0.25])
    view.set_dof_gains([[2.0]], [[1.0]], indices=[0], dof_indices=[0])
    drive = UsdPhysics.DriveAPI(arms.GetPrimAtPath("/World/env_0/arm/shoulder"), "angular")
    assert drive.GetTargetPositionAttr().Get() == pytest.approx(np.degrees(0.5))


def test_numpy_arrays_of_the_older_wrapper(arms):
    view = core.Articulation("/World/env_*/arm", name="arms", reset_xform_properties=False)
    assert (view.num_dof, view.num_bodies, view.name) == (3, 4, "arms")
    view.set_joint_positions(np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.05]]))
    assert view.get_joint_positions(joint_indices=[1]) == pytest.approx(np.array([[0.2], [0.5]]))
    assert view.get_dof_limits().shape == (2, 3, 2)
    view.post_reset()
    assert view.get_joint_positions() == pytest.approx(np.zeros((2, 3)))


@pytest.mark.parametrize("make", [experimental.Articulation, core.Articulation])
def test_what_only_tendons_have_is_refused(arms, make):
    with pytest.raises(Unsupported, match="there are no tendons"):
        make("/World/env_0/arm").get_fixed_tendon_properties()


def test_forces_in_joints_are_measured_while_physics_plays(arms):
    UsdPhysics.Scene.Define(arms, "/scene")
    UsdGeom.XformCommonAPI(arms.GetPrimAtPath("/World/env_1/arm")).SetTranslate((0.0, 5.0, 0.0))
    view = experimental.Articulation("/World/env_.*/arm")
    with pytest.raises(PhysicsError, match="/World/env_0/arm: no force acts in its joints"):
        view.get_link_incoming_joint_force()
    get_timeline().play()
    for _ in range(3):
        get_app().update()
    forces, torques = (each.numpy() for each in view.get_link_incoming_joint_force())
    assert forces.shape == torques.shape == (2, view.num_links, 3)
    mass = view.get_link_masses().numpy()
    held = 9.81 * np.array([[mass[row, number:].sum() for number in range(1, 4)] for row in range(2)])
    assert np.linalg.norm(forces[:, 1:], axis=2) == pytest.approx(held, rel=0.01)
    along = view.get_dof_projected_joint_forces(dof_indices=[0]).numpy()
    assert along[:, 0] == pytest.approx(torques[:, 1, 2], abs=1e-6)
    older = core.Articulation("/World/env_*/arm", reset_xform_properties=False)
    name = older.joint_names[1]
    assert older.get_measured_joint_forces(joint_names=[name])[:, 0, :3] == pytest.approx(forces[:, 2])


def test_drives_and_efforts_act_while_physics_plays(arms):
    UsdGeom.Xformable(arms.GetPrimAtPath("/World/env_1/arm")).GetOrderedXformOps()[0].Set((0, 10, 0))
    view = core.Articulation("/World/env_*/arm", name="arms", reset_xform_properties=False)
    with pytest.raises(PhysicsError, match="play first"):
        view.set_joint_efforts(np.ones((2, 3)))
    view.set_gains(kps=[[1e3]], kds=[[2e2]], indices=[1], joint_indices=[0])
    view.set_max_efforts([[500.0]], indices=[1], joint_indices=[0])
    assert view.get_gains()[0][1, 0] == pytest.approx(1e3)
    assert view.get_max_efforts()[1, 0] == 500.0
    view.set_joint_position_targets([[0.4]], indices=[1], joint_indices=[0])
    get_timeline().play()
    for _ in range(30):
        view.set_joint_efforts([[2.0, 0.0, 0.0]], indices=[0])
        get_app().update()
    # The first arm turns by a torque of 2 N m: with the elbow and slider free, most of it turns the base alone.
    assert view.get_joint_velocities()[0, 0] > 0.1
    for _ in range(90):
        get_app().update()
    assert view.get_joint_positions()[1, 0] == pytest.approx(0.4, abs=0.01)
    fresh = experimental.Articulation("/World/env_1/arm")
    assert fresh.get_dof_positions(dof_indices=[0]).numpy() == pytest.approx(np.array([[0.4]]), abs=0.01)
    fresh.set_dof_velocity_targets([0.1], dof_indices=[0])
    assert fresh.get_dof_velocity_targets(dof_indices=[0]).numpy() == pytest.approx(np.array([[0.1]]))


def test_settings_of_joints_are_authored_as_in_usd_physics(arms):
    view = experimental.Articulation("/World/env_.*/arm")
    view.set_dof_limits(lower=-0.1, upper=[[0.2, 0.3, 0.04]])
    lower, upper = view.get_dof_limits()
    assert lower.numpy() == pytest.approx(np.full((2, 3), -0.1))
    assert upper.numpy()[1] == pytest.approx([0.2, 0.3, 0.04])
    limit = arms.GetPrimAtPath("/World/env_0/arm/elbow").GetAttribute("physics:upperLimit")
    assert limit.Get() == pytest.approx(np.degrees(0.3))
    view.set_dof_friction_properties(static_frictions=0.2, viscous_frictions=[1.0, 2.0, 3.0], indices=[0])
    static, dynamic, viscous = (each.numpy() for each in view.get_dof_friction_properties())
    assert static[:, 0] == pytest.approx([0.2, 0.0])
    assert not dynamic.any()
    assert viscous[0] == pytest.approx([1.0, 2.0, 3.0])
    # Per degree per second on the stage.
    name = "physxJointAxis:angular:viscousFrictionCoefficient"
    assert arms.GetPrimAtPath("/World/env_0/arm/shoulder").GetAttribute(name).Get() == pytest.approx(np.radians(1.0))
    view.set_dof_armatures(0.1, dof_indices=[1])
    view.set_dof_max_velocities([2.0])
    assert view.get_dof_armatures().numpy()[:, 1] == pytest.approx([0.1, 0.1])
    assert view.get_dof_max_velocities().numpy() == pytest.approx(np.full((2, 3), 2.0))
    view.set_dof_drive_types("acceleration", dof_indices=[0])
    assert view.get_dof_drive_types(indices=[1]) == [["acceleration", "acceleration", "acceleration"]]
    with pytest.raises(AssertionError, match="give lower or upper"):
        view.set_dof_limits()
    with pytest.raises(ValueError, match="does not fill 2 rows of 3"):
        view.set_dof_armatures([1.0, 2.0])


def test_viscous_friction_and_limits_act(arms):
    """A torque against viscous friction: the velocity settles at torque / coefficient, and ends at the limit."""
    UsdGeom.Xformable(arms.GetPrimAtPath("/World/env_1/arm")).GetOrderedXformOps()[0].Set((0, 10, 0))
    view = experimental.Articulation("/World/env_0/arm")
    view.set_dof_limits(lower=-0.5, upper=0.5, dof_indices=[0])
    view.set_dof_friction_properties(viscous_frictions=20.0, dof_indices=[0])
    get_timeline().play()
    for _ in range(30):
        view.set_dof_efforts(10.0, dof_indices=[0])
        get_app().update()
    assert view.get_dof_efforts().numpy().tolist() == [[10.0, 0.0, 0.0]]
    assert view.get_dof_velocities().numpy()[0, 0] == pytest.approx(0.5, abs=0.1)
    for _ in range(60):
        view.set_dof_efforts(10.0, dof_indices=[0])
        get_app().update()
    assert view.get_dof_positions().numpy()[0, 0] == pytest.approx(0.5, abs=0.02)


def test_links_settings_and_states_of_the_newer_wrapper(arms):
    view = experimental.Articulation("/World/env_.*/arm")
    assert view.link_names == ["base", "upper", "lower", "hand"]
    assert view.link_paths[1][3] == "/World/env_1/arm/hand"
    assert view.get_link_indices(["hand", "base"]).numpy().tolist() == [3, 0]
    assert view.get_joint_indices("elbow").numpy().tolist() == [1]
    assert [kind.name for kind in view.joint_types] == ["Revolute", "Revolute", "Prismatic"]
    assert [kind.name for kind in view.dof_types] == ["Rotation", "Rotation", "Translation"]
    assert view.num_shapes == 4
    view.set_link_masses(2.0, link_indices=[1])
    view.set_link_enabled_gravities(False, indices=[0])
    assert view.get_link_masses(link_indices=[1]).numpy() == pytest.approx(np.full((2, 1), 2.0))
    assert view.get_link_enabled_gravities().numpy().tolist() == [[False] * 4, [True] * 4]
    view.set_enabled_self_collisions(False)
    view.set_solver_iteration_counts(8, 2)
    assert not view.get_enabled_self_collisions().numpy().any()
    assert [each.numpy()[0, 0] for each in view.get_solver_iteration_counts()] == [8, 2]
    paths = ["/World/env_0/arm", "/World/env_0/arm/base"]
    assert experimental.Articulation.fetch_articulation_root_api_prim_paths(paths) == ["/World/env_0/arm", None]
    view.set_default_state(dof_positions=[0.1, 0.2, 0.3], dof_velocities=0.0)
    assert view.get_default_state()[4].numpy()[1] == pytest.approx([0.1, 0.2, 0.3])
    view.reset_to_default_state()
    assert view.get_dof_positions().numpy()[0] == pytest.approx([0.1, 0.2, 0.3])


def test_a_floating_robot_is_placed_by_its_base_while_physics_plays(arms):
    arms.RemovePrim("/World/env_0/arm/fixed")
    UsdPhysics.Scene.Define(arms, "/scene").CreateGravityMagnitudeAttr(0.0)
    view = experimental.Articulation("/World/env_0/arm")
    get_timeline().play()
    get_app().update()
    assert view.is_physics_tensor_entity_valid()
    view.set_world_poses([[0.0, 5.0, 1.0]])
    view.set_velocities([[0.0, 0.0, 3.0]], [[0.0, 0.0, 0.0]])
    assert view.get_velocities()[0].numpy() == pytest.approx(np.array([[0, 0, 3]]))
    assert at(arms.GetPrimAtPath("/World/env_0/arm/hand")) == pytest.approx([2, 5, 1], abs=1e-3)
    get_app().update()
    assert at(arms.GetPrimAtPath("/World/env_0/arm/hand")) == pytest.approx([2, 5, 1.05], abs=1e-3)
    view.set_local_poses([[1.0, 0.0, 0.0]])
    assert view.get_local_poses()[0].numpy() == pytest.approx(np.array([[1, 0, 0]]), abs=1e-5)
    assert view.jacobian_matrix_shape == (4, 6, 9)


def _authored(stage):
    """Return the values of all joints and drives that the stage holds."""
    joints = [prim for prim in stage.Traverse() if prim.IsA(UsdPhysics.Joint)]
    values = [attribute for joint in joints for attribute in joint.GetAuthoredAttributes() if attribute.HasValue()]
    return {str(each.GetPath()): each.Get() for each in values if each.HasAuthoredValue()}


@pytest.mark.parametrize("experimental_form", [True, False])
def test_what_joints_are_given_while_physics_plays_ends_with_it(arms, experimental_form):
    UsdPhysics.Scene.Define(arms, "/scene")
    path = "/World/env_1/arm"
    drive = UsdPhysics.DriveAPI(arms.GetPrimAtPath(f"{path}/shoulder"), "angular")
    drive.CreateMaxForceAttr()  # a spec without a value
    view = experimental.Articulation(path) if experimental_form else core.Articulation(path)
    before = _authored(arms)
    get_timeline().play()
    get_app().update()
    all_equal, three = np.ones((1, 3), np.float32), np.full((1, 3), 3.0, np.float32)
    if experimental_form:
        view.set_dof_gains(7 * all_equal, 2 * all_equal)
        view.set_dof_max_efforts(three)
        view.set_dof_armatures(three)
        view.set_dof_max_velocities(three)
        view.set_dof_limits(-0.1 * all_equal, 0.1 * all_equal)
        view.set_dof_position_targets(0.05 * all_equal)
        view.set_dof_velocity_targets(0.2 * all_equal)
    else:
        view.set_gains(7 * all_equal, 2 * all_equal)
        view.set_max_efforts(three)
        view.set_armatures(three)
        view.set_max_joint_velocities(three)
        view.set_friction_coefficients(0.1 * all_equal)
        view.set_joint_position_targets(0.05 * all_equal)
        view.set_joint_velocity_targets(0.2 * all_equal)
        view.switch_control_mode("velocity")
    get_app().update()
    assert drive.GetMaxForceAttr().Get() == 3.0
    assert _authored(arms) != before
    get_timeline().stop()
    assert _authored(arms) == before


def test_gains_that_are_saved_to_the_stage_stay(arms):
    UsdPhysics.Scene.Define(arms, "/scene")
    drive = UsdPhysics.DriveAPI(arms.GetPrimAtPath("/World/env_1/arm/shoulder"), "angular")
    view = core.Articulation("/World/env_1/arm")
    view.set_gains(kps=[[90.0]], joint_indices=[0])  # physics does not play yet
    get_timeline().play()
    get_app().update()
    view.set_gains(kds=[[45.0]], joint_indices=[0], save_to_usd=True)
    view.set_gains(kps=[[1.0]], joint_indices=[0])
    get_timeline().stop()
    gains = drive.GetStiffnessAttr().Get(), drive.GetDampingAttr().Get()
    assert gains == pytest.approx((np.radians(90.0), np.radians(45.0)))
