"""`SingleArticulation`, its controller and actions, as scripts of Isaac Sim use them."""

import importlib

import numpy as np
import pytest
from pxr import UsdGeom, UsdPhysics

from tests.articulations.robots import at, joint, link, planar_arm
from usdsdg.compat import finder
from usdsdg.compat.isaacsim.core.api import World
from usdsdg.compat.isaacsim.core.api.articulations import ArticulationGripper, ArticulationSubset
from usdsdg.compat.isaacsim.core.api.controllers import ArticulationController, BaseController, BaseGripperController
from usdsdg.compat.isaacsim.core.api.robots import Robot, RobotView
from usdsdg.compat.isaacsim.core.prims import Articulation, SingleArticulation
from usdsdg.compat.isaacsim.core.utils import articulations
from usdsdg.compat.isaacsim.core.utils.types import ArticulationAction, ArticulationActions
from usdsdg.errors import Unsupported

ARM, CART = "/World/Arm", "/World/Cart"


@pytest.fixture
def world(stage):
    World.clear_instance()
    yield World()
    World.clear_instance()


@pytest.fixture
def arm(stage, world):
    planar_arm(stage, ARM)
    for name, kind, stiffness, damping in (
        ("shoulder", "angular", 200.0, 40.0), ("elbow", "angular", 100.0, 20.0), ("slider", "linear", 5000.0, 500.0),
    ):  # fmt: skip
        drive = UsdPhysics.DriveAPI.Apply(stage.GetPrimAtPath(f"{ARM}/{name}"), kind)
        drive.CreateStiffnessAttr(stiffness)
        drive.CreateDampingAttr(damping)
    robot = world.scene.add(Robot(ARM, "arm"))
    world.reset()
    return robot


@pytest.fixture
def cart(stage, world):
    """A chassis on four wheels; the articulation's root is the prim above them."""
    prim = stage.DefinePrim(CART, "Xform")
    UsdPhysics.ArticulationRootAPI.Apply(prim)
    link(stage, f"{CART}/chassis", (0, 0, 0.2), size=0.3)
    for x, side in (("front", 0.2), ("rear", -0.2)):
        for y, offset in (("left", 0.25), ("right", -0.25)):
            name = f"{x}_{y}"
            wheel = stage.DefinePrim(f"{CART}/{name}", "Xform")
            UsdGeom.Xformable(wheel).AddTranslateOp().Set((side, offset, 0.1))
            UsdPhysics.RigidBodyAPI.Apply(wheel)
            shape = UsdGeom.Cylinder.Define(stage, f"{CART}/{name}/shape")
            shape.CreateRadiusAttr(0.1)
            shape.CreateHeightAttr(0.05)
            shape.CreateAxisAttr("Y")
            UsdPhysics.CollisionAPI.Apply(shape.GetPrim())
            joint(
                stage, f"{CART}/{name}_joint", UsdPhysics.RevoluteJoint, f"{CART}/chassis", f"{CART}/{name}",
                pos0=(side, offset, -0.1), axis="Y",
            )  # fmt: skip
    world.scene.add_ground_plane()
    return world.scene.add(Robot(CART, "cart"))


def run(world, steps):
    for _ in range(steps):
        world.step(render=False)


def test_a_robot_tells_its_joints(arm):
    assert arm.handles_initialized
    assert (arm.num_dof, arm.num_bodies, arm.get_articulation_body_count()) == (3, 4, 4)
    assert arm.dof_names == ["shoulder", "elbow", "slider"]
    assert arm.get_dof_index("slider") == 2
    with pytest.raises(KeyError, match=r"no joint with a position 'wrist'; there are shoulder"):
        arm.get_dof_index("wrist")
    found = arm.dof_properties
    assert found["type"].tolist() == [1, 1, 2]
    assert found["hasLimits"].all()
    assert found["lower"] == pytest.approx([*np.radians([-170, -90]), 0])
    assert found["driveMode"].tolist() == [1, 1, 1]
    assert found["stiffness"] == pytest.approx([np.degrees(200), np.degrees(100), 5000])
    assert found["damping"][1] == pytest.approx(np.degrees(20))


def test_actions_move_joints_to_targets_and_skip_none(arm, world):
    controller = arm.get_articulation_controller()
    assert isinstance(controller, ArticulationController)
    controller.apply_action(ArticulationAction(joint_positions=np.array([0.5, 0.2]), joint_indices=np.array([0, 2])))
    arm.apply_action(ArticulationAction(joint_positions=[None, -0.3, np.nan], joint_velocities=[0.0, None, None]))
    assert arm.get_applied_action().joint_positions == pytest.approx([0.5, -0.3, 0.2])
    run(world, 120)
    assert arm.get_joint_positions() == pytest.approx([0.5, -0.3, 0.2], abs=0.01)
    assert arm.get_joint_velocities(np.array([0, 1])) == pytest.approx([0, 0], abs=0.01)
    assert arm.get_joints_state().positions == pytest.approx(arm.get_joint_positions())


def test_control_modes_change_gains_and_return_to_those_that_were_set(arm, world):
    controller = arm.get_articulation_controller()
    controller.set_gains(kps=np.array([1e4, 1e4, 1e4]), kds=np.array([1e3, 1e3, 1e3]))
    controller.switch_control_mode("velocity")
    assert [each.tolist() for each in controller.get_gains()] == [[0, 0, 0], [1e3, 1e3, 1e3]]
    controller.apply_action(ArticulationAction(joint_velocities=np.array([0.5, 0.0, 0.0])))
    run(world, 60)
    assert arm.get_joint_velocities()[0] == pytest.approx(0.5, abs=0.02)
    assert arm.get_joint_positions()[0] == pytest.approx(0.5, abs=0.05)
    controller.switch_dof_control_mode(dof_index=0, mode="effort")
    assert [each.tolist() for each in controller.get_gains()] == [[0, 0, 0], [0, 1e3, 1e3]]
    controller.switch_control_mode("position")
    assert [each.tolist() for each in controller.get_gains()] == [[1e4] * 3, [1e3] * 3]
    with pytest.raises(ValueError, match="position, velocity, effort"):
        controller.switch_control_mode("torque")


def test_limits_of_efforts_and_their_meaning(arm):
    controller = arm.get_articulation_controller()
    controller.set_max_efforts(np.array([7.0]), joint_indices=[1])
    assert controller.get_max_efforts()[1] == 7.0
    assert controller.get_effort_modes() == ["force"] * 3
    controller.set_effort_modes("acceleration", joint_indices=[0])
    assert controller.get_effort_modes() == ["acceleration", "force", "force"]
    assert arm.dof_properties["driveMode"].tolist() == [2, 1, 1]
    assert controller.get_joint_limits()[2] == pytest.approx([0, 0.5])


def test_efforts_of_one_step_replace_each_other(arm, world):
    """A torque about a hinge through the center of the turning mass: the velocity is torque · time / inertia."""
    controller = arm.get_articulation_controller()
    controller.switch_control_mode("effort")
    arm.set_joint_efforts(np.array([100.0, 0.0, 0.0]))
    arm.set_joint_efforts(np.array([1.0]), joint_indices=np.array([0]))
    assert arm.get_applied_joint_efforts().tolist() == [1.0, 0.0, 0.0]
    before = Articulation(ARM, "view", reset_xform_properties=False).get_mass_matrices()[0]
    run(world, 1)
    assert before @ arm.get_joint_velocities() == pytest.approx([1 / 60, 0, 0], abs=1e-4)
    run(world, 30)
    assert arm.get_applied_action().joint_efforts.tolist() == [1.0, 0.0, 0.0]


def test_a_reset_restores_the_default_state(arm, world):
    # As in Isaac Sim, by default joints go to the first targets of their drives.
    assert arm.get_joints_default_state().positions.tolist() == [0, 0, 0]
    arm.set_joints_default_state(positions=np.array([0.3, 0.2, 0.1]))
    controller = arm.get_articulation_controller()
    controller.switch_control_mode("velocity")
    world.reset()
    assert arm.get_joint_positions() == pytest.approx([0.3, 0.2, 0.1], abs=1e-6)
    assert controller.get_gains()[0][2] == 5000
    arm.set_joint_positions(np.array([0.0]), joint_indices=[1])
    arm.post_reset()
    assert arm.get_joint_positions() == pytest.approx([0.3, 0.2, 0.1], abs=1e-6)


def test_a_cart_drives_with_wheel_velocities(cart, world):
    """It rolls without slipping: radius · rate · time; the pose of a robot is that of its base."""
    world.reset()
    controller = cart.get_articulation_controller()
    controller.set_gains(kps=np.zeros(4), kds=np.full(4, 10.0))
    controller.apply_action(ArticulationAction(joint_velocities=np.full(4, 5.0)))
    run(world, 30)
    start = cart.get_world_pose()[0]
    run(world, 60)
    position, turn = cart.get_world_pose()
    assert position == pytest.approx(at(world.stage.GetPrimAtPath(f"{CART}/chassis")), abs=1e-6)
    assert position - start == pytest.approx([0.5, 0, 0], abs=0.02)
    assert turn == pytest.approx([1, 0, 0, 0], abs=0.02)
    assert cart.get_linear_velocity() == pytest.approx([0.5, 0, 0], abs=0.02)
    world.reset()
    assert cart.get_world_pose()[0] == pytest.approx([0, 0, 0.2], abs=1e-4)


def test_placing_a_robot_takes_its_links_along(cart, world, stage):
    world.reset()
    cart.set_world_pose(np.array([1.0, 2.0, 0.7]), np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)]))
    cart.set_world_velocity(np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]))
    assert cart.get_world_velocity() == pytest.approx([0, 0, 1, 0, 0, 0])
    # A quarter turn about Z takes what is in front to the left, at once.
    wheel = at(stage.GetPrimAtPath(f"{CART}/front_left"))
    assert wheel == pytest.approx([1 - 0.25, 2 + 0.2, 0.6], abs=0.01)
    world.step(render=False)
    wheel = at(stage.GetPrimAtPath(f"{CART}/front_left"))
    assert wheel == pytest.approx([1 - 0.25, 2 + 0.2, 0.6 + 1 / 60], abs=0.01)
    assert cart.get_local_pose()[0] == pytest.approx(cart.get_world_pose()[0], abs=1e-5)
    cart.set_local_pose(np.array([3.0, 0.0, 2.0]), np.array([1.0, 0.0, 0.0, 0.0]))
    assert at(stage.GetPrimAtPath(f"{CART}/front_left")) == pytest.approx([3 + 0.2, 0.25, 1.9], abs=0.01)


def test_several_robots_take_actions_by_name(stage, world):
    for index in range(2):
        planar_arm(stage, f"/World/env_{index}/arm")
        UsdGeom.Xformable(stage.GetPrimAtPath(f"/World/env_{index}/arm")).GetOrderedXformOps()[0].Set((0, 5 * index, 0))
    view = world.scene.add(RobotView("/World/env_.*/arm"))
    world.reset()
    view.set_gains(np.full((2, 3), 1e4), np.full((2, 3), 1e3))
    view.apply_action(ArticulationActions(joint_positions=np.array([[0.1], [0.2]]), joint_names=["elbow"]))
    run(world, 90)
    assert view.get_joint_positions(joint_names=["elbow"])[:, 0] == pytest.approx([0.1, 0.2], abs=0.01)
    with pytest.raises(ValueError, match="not both"):
        view.get_joint_positions(joint_indices=[0], joint_names=["elbow"])
    view.pause_motion()
    assert view.get_joint_velocities() == pytest.approx(np.zeros((2, 3)))
    view.resume_motion()
    assert view.get_applied_actions().joint_positions[:, 1] == pytest.approx([0.1, 0.2])


def test_settings_of_joints_are_authored(arm, stage):
    view = Articulation(ARM, "view", reset_xform_properties=False)
    view.set_armatures([[0.1, 0.2, 0.3]])
    view.set_friction_coefficients([[0.5]], joint_indices=[0])
    view.set_max_joint_velocities([[2.0, 3.0]], joint_indices=[0, 2])
    assert view.get_armatures()[0] == pytest.approx([0.1, 0.2, 0.3])
    assert view.get_friction_coefficients()[0] == pytest.approx([0.5, 0, 0])
    assert view.get_joint_max_velocities()[0, [0, 2]] == pytest.approx([2, 3])
    shoulder, slider = (stage.GetPrimAtPath(f"{ARM}/{name}") for name in ("shoulder", "slider"))
    assert shoulder.GetAttribute("physxJoint:maxJointVelocity").Get() == pytest.approx(np.degrees(2.0))
    assert slider.GetAttribute("physxJoint:armature").Get() == pytest.approx(0.3)
    arm.set_enabled_self_collisions(False)
    arm.set_solver_position_iteration_count(64)
    assert (arm.get_enabled_self_collisions(), arm.get_solver_position_iteration_count()) == (0, 64)
    assert arm.get_solver_velocity_iteration_count() == 1
    arm.disable_gravity()
    assert view.get_body_disable_gravity().all()
    view.set_body_masses([[2.0]], body_indices=[3])
    assert view.get_body_masses()[0, 3] == 2.0
    assert view.get_body_coms()[0].shape == (1, 4, 3)
    assert view.get_body_inertias(body_indices=[1]).shape == (1, 1, 9)


def test_tendons_are_refused(arm):
    for name in ("get_fixed_tendon_stiffnesses", "get_fixed_tendon_limits"):
        with pytest.raises(Unsupported, match=f"{name}: there are no tendons"):
            getattr(arm, name)


def test_forces_in_joints_hold_the_arm_up(arm, world):
    """The arm lies in the plane, so its joints bear the weight of all that is farther out, and its torque."""
    masses, axes = Articulation(ARM, reset_xform_properties=False).get_body_masses()[0], [2, 2, 0]
    run(world, 120)
    forces, efforts = arm.get_measured_joint_forces(), arm.get_measured_joint_efforts()
    assert forces.shape == (4, 6)
    assert forces[0] == pytest.approx(np.zeros(6))
    weights = [9.81 * masses[number:].sum() for number in range(1, 4)]
    assert np.linalg.norm(forces[1:, :3], axis=1) == pytest.approx(weights, rel=1e-3)
    assert efforts.shape == (3,)
    along = [forces[1, 3 + axes[0]], forces[2, 3 + axes[1]], forces[3, axes[2]]]
    assert efforts == pytest.approx(along, abs=1e-6)
    assert arm.get_measured_joint_efforts([1]) == pytest.approx(efforts[1:2])
    assert arm.get_measured_joint_forces([0, 2]) == pytest.approx(forces[[0, 2]])


def test_a_controller_needs_its_robot():
    with pytest.raises(RuntimeError, match="initialize"):
        ArticulationController().apply_action(ArticulationAction())


def test_actions_tell_what_they_hold():
    action = ArticulationAction(joint_positions=np.array([1.0, 2.0]), joint_velocities=[None, 3.0])
    assert action.get_length() == 2
    assert action.get_dict() == {
        "joint_positions": [1.0, 2.0], "joint_velocities": [None, 3.0], "joint_efforts": None,
    }  # fmt: skip
    assert (action.get_dof_action(0), action.get_dof_action(1)) == (
        {"position": 1.0},
        {"velocity": 3.0, "position": 2.0},
    )
    assert ArticulationAction().get_length() is None


def test_controllers_of_scripts_derive_from_the_bases(arm, world):
    class Sine(BaseController):
        def forward(self, time):
            return ArticulationAction(joint_positions=np.array([np.sin(time), 0.0, 0.0]))

    class Grip(BaseGripperController):
        def open(self, current_joint_positions):
            return ArticulationAction(joint_positions=current_joint_positions + 0.1)

        def close(self, current_joint_positions):
            return ArticulationAction(joint_positions=current_joint_positions * 0.0)

    sine = Sine("sine")
    sine.reset()
    arm.apply_action(sine.forward(np.pi / 2))
    assert arm.get_applied_action().joint_positions[0] == pytest.approx(1.0)
    assert Grip("grip").forward("open", np.zeros(3)).joint_positions.tolist() == [0.1] * 3
    with pytest.raises(ValueError, match="'open' or 'close'"):
        Grip("grip").forward("wave", np.zeros(3))


def test_a_subset_and_a_gripper_have_their_own_order(arm, world):
    subset = ArticulationSubset(arm, ["slider", "shoulder"])
    assert subset.joint_indices.tolist() == [2, 0]
    subset.apply_action(np.array([0.1, 0.4]))
    assert subset.map_to_articulation_order([1, 2]).tolist() == [2, None, 1]
    run(world, 120)
    assert subset.get_joint_positions() == pytest.approx([0.1, 0.4], abs=0.01)
    gripper = ArticulationGripper(["slider"], np.array([0.4]), np.array([0.0]))
    gripper.initialize(ARM, arm.get_articulation_controller())
    gripper.set_positions(gripper.open_position)
    assert gripper.get_positions() == pytest.approx([0.4], abs=1e-5)
    assert subset.get_applied_action().joint_positions[0] == pytest.approx(0.4)


def test_a_robot_can_be_named_by_its_base_or_fixed_to_a_prim_that_is_no_body(stage, world):
    """As in files that importers write: the root joint names the robot's prim, and links are beside the base."""
    planar_arm(stage, ARM)
    UsdPhysics.Joint(stage.GetPrimAtPath(f"{ARM}/fixed")).CreateBody0Rel().SetTargets([ARM])
    stage.GetPrimAtPath(ARM).RemoveAPI(UsdPhysics.ArticulationRootAPI)
    UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath(f"{ARM}/base"))
    robot = SingleArticulation(f"{ARM}/base", "named by its base", reset_xform_properties=False)
    assert robot.dof_names == ["shoulder", "elbow", "slider"]
    world.reset()
    view = Articulation(ARM, "view", reset_xform_properties=False)
    assert view.get_jacobians().shape == (1, 3, 6, 3)


def test_older_names_are_the_same_classes():
    finder.install()
    old = importlib.import_module("omni.isaac.core.articulations")
    assert (old.Articulation, old.ArticulationView) == (SingleArticulation, Articulation)
    assert importlib.import_module("omni.isaac.core.articulations.articulation_view") is old
    assert importlib.import_module("omni.isaac.core.robots").Robot is Robot
    assert importlib.import_module("omni.isaac.core.utils.types").ArticulationAction is ArticulationAction


def test_roots_of_articulations_are_found_and_moved(stage):
    planar_arm(stage, "/World/one")
    planar_arm(stage, "/World/two")
    arm, base = stage.GetPrimAtPath("/World/two"), stage.GetPrimAtPath("/World/two/base")
    articulations.move_articulation_root(arm, base)
    assert not arm.HasAPI(UsdPhysics.ArticulationRootAPI)
    assert base.HasAPI(UsdPhysics.ArticulationRootAPI)
    assert articulations.find_all_articulation_base_paths() == ["/World/one", "/World/two"]
    articulations.remove_articulation_root(base)
    assert articulations.find_all_articulation_base_paths() == ["/World/one"]
