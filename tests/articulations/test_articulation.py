"""Joint positions place links, and move with velocities and drives; against closed forms."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics

from tests.articulations.robots import at, joint, link, planar_arm
from usdsdg.app.app import get_app
from usdsdg.articulations.articulation import Articulation
from usdsdg.articulations.articulations import get_articulations
from usdsdg.errors import BadPrim, PhysicsError
from usdsdg.session import engines
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.schemas import physx

STEP = 1 / 60
_INSTANCES = {"shoulder": "angular", "elbow": "angular", "slider": "linear"}


def _hand(q1: float, q2: float, slide: float) -> list[float]:
    return [
        np.cos(q1) + (1 + slide) * np.cos(q1 + q2),
        np.sin(q1) + (1 + slide) * np.sin(q1 + q2),
        0.0,
    ]


def test_joints_are_listed_from_the_base_on(stage):
    planar_arm(stage)
    arm = Articulation(stage, "/World/Arm")
    assert [joint.path.rsplit("/", 1)[1] for joint in arm.dofs] == ["shoulder", "elbow", "slider"]
    assert arm.tree.base == "/World/Arm/base"
    assert arm.positions == pytest.approx([0, 0, 0])


def test_positions_place_the_links_and_are_measured_again(stage):
    planar_arm(stage)
    arm = Articulation(stage, "/World/Arm")
    q = [0.7, -1.1, 0.3]
    arm.set_positions(q)
    assert at(stage.GetPrimAtPath("/World/Arm/hand")) == pytest.approx(_hand(*q), abs=1e-6)
    assert arm.tree.positions() == pytest.approx(q, abs=1e-6)
    assert Articulation(stage, "/World/Arm").positions == pytest.approx(q, abs=1e-6)


def test_positions_are_relative_to_where_the_robot_stands(stage):
    root = planar_arm(stage)
    arm = Articulation(stage, "/World/Arm")
    UsdGeom.Xformable(root).GetOrderedXformOps()[0].Set((3, 4, 5))
    arm.set_positions([0.7, -1.1, 0.3])
    assert at(stage.GetPrimAtPath("/World/Arm/hand")) == pytest.approx(
        np.add(_hand(0.7, -1.1, 0.3), [3, 4, 5]), abs=1e-6
    )


def test_a_joint_may_name_its_bodies_from_the_hand_to_the_base(stage):
    prim = stage.DefinePrim("/World/R", "Xform")
    UsdPhysics.ArticulationRootAPI.Apply(prim)
    link(stage, "/World/R/base")
    link(stage, "/World/R/arm", (1, 0, 0))
    joint(stage, "/World/R/root", UsdPhysics.FixedJoint, "", "/World/R/base")
    joint(stage, "/World/R/j", UsdPhysics.RevoluteJoint, "/World/R/arm", "/World/R/base", pos0=(-1, 0, 0))
    robot = Articulation(stage, "/World/R")
    stage.GetPrimAtPath("/World/R/j").GetAttribute("physics:lowerLimit").Set(-180.0)
    stage.GetPrimAtPath("/World/R/j").GetAttribute("physics:upperLimit").Set(180.0)
    robot.set_positions([np.pi / 2])  # body 1 turns by +90 degrees as seen from body 0
    assert at(stage.GetPrimAtPath("/World/R/arm")) == pytest.approx([0, -1, 0], abs=1e-6)
    assert robot.tree.positions() == pytest.approx([np.pi / 2], abs=1e-6)


def test_the_link_with_the_root_is_the_base(stage):
    for name, x in (("a", 0), ("b", 1), ("c", 2)):
        link(stage, f"/World/R/{name}", (x, 0, 0))
    UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath("/World/R/b"))
    joint(stage, "/World/R/j0", UsdPhysics.RevoluteJoint, "/World/R/a", "/World/R/b", pos0=(1, 0, 0))
    joint(stage, "/World/R/j1", UsdPhysics.RevoluteJoint, "/World/R/b", "/World/R/c", pos0=(1, 0, 0))
    assert Articulation(stage, "/World/R").tree.links == ["/World/R/b", "/World/R/a", "/World/R/c"]


def test_positions_stay_within_limits(stage):
    planar_arm(stage)
    arm = Articulation(stage, "/World/Arm")
    arm.set_positions([9.0, -9.0, 9.0])
    assert arm.positions == pytest.approx([np.radians(170), np.radians(-90), 0.5])


def test_a_velocity_lasts_until_the_limit(stage):
    planar_arm(stage)
    arm = Articulation(stage, "/World/Arm")
    arm.set_velocities([0.5, 0.0, 2.0])
    for _ in range(30):
        arm.step(STEP)
    assert arm.positions == pytest.approx([0.25, 0, 0.5])
    assert arm.velocities == pytest.approx([0.5, 0, 0])


def test_a_drive_approaches_its_target_as_a_critically_damped_spring(stage):
    planar_arm(stage)
    drive = UsdPhysics.DriveAPI.Apply(stage.GetPrimAtPath("/World/Arm/shoulder"), "angular")
    drive.CreateStiffnessAttr(100.0)
    drive.CreateDampingAttr(20.0)
    drive.CreateTargetPositionAttr(40.0)
    arm = Articulation(stage, "/World/Arm")
    for _ in range(12):
        arm.step(STEP)
    omega, t, target = 2 * 100.0 / 20.0, 12 * STEP, np.radians(40.0)
    assert arm.positions[0] == pytest.approx(target * (1 - (1 + omega * t) * np.exp(-omega * t)))
    assert arm.velocities[0] == pytest.approx(target * omega**2 * t * np.exp(-omega * t))


def test_a_mimic_joint_follows_its_leader_and_states_are_shown(stage):
    planar_arm(stage)
    elbow = stage.GetPrimAtPath("/World/Arm/elbow")
    mimic = physx.PhysxMimicJointAPI.Apply(elbow, "rotZ")
    mimic.CreateGearingAttr(-0.5)
    mimic.CreateReferenceJointRel().SetTargets(["/World/Arm/shoulder"])
    physx.JointStateAPI.Apply(elbow, "angular")
    arm = Articulation(stage, "/World/Arm")
    arm.set_velocities([0.6, 0.0, 0.0])
    arm.step(0.5)
    assert arm.positions == pytest.approx([0.3, 0.15, 0.0])
    assert elbow.GetAttribute("state:angular:physics:position").Get() == pytest.approx(np.degrees(0.15))


def test_followers_of_followers_have_units_of_their_own(stage):
    """The shoulder follows the elbow, and that the slider: degrees per unit, then degrees per degree."""
    planar_arm(stage)
    for name, leader, gearing in (("shoulder", "elbow", -2.0), ("elbow", "slider", -100.0)):
        mimic = physx.PhysxMimicJointAPI.Apply(stage.GetPrimAtPath(f"/World/Arm/{name}"), "rotZ")
        mimic.CreateGearingAttr(gearing)
        mimic.CreateReferenceJointRel().SetTargets([f"/World/Arm/{leader}"])
    arm = Articulation(stage, "/World/Arm")
    arm.set_positions([0.0, 0.0, 0.2])
    assert arm.positions == pytest.approx([np.radians(40.0), np.radians(20.0), 0.2])


@pytest.mark.parametrize("plays", [False, True])
def test_a_slider_follows_a_hinge_by_length_per_degree(stage, plays):
    planar_arm(stage)
    mimic = physx.PhysxMimicJointAPI.Apply(stage.GetPrimAtPath("/World/Arm/slider"), "rotX")
    mimic.CreateGearingAttr(-0.01)
    mimic.CreateReferenceJointRel().SetTargets(["/World/Arm/shoulder"])
    arm = get_articulations().at("/World/Arm")
    if plays:
        get_timeline().play()
        get_app().update()
    arm.set_positions([np.radians(20.0), 0.0, 0.0])
    if plays:
        get_app().update()
        assert "/World/Arm/hand" in engines.physics().rigid_bodies
    assert arm.positions[2] == pytest.approx(0.01 * np.degrees(arm.positions[0]), abs=2e-3)
    assert arm.positions[2] == pytest.approx(0.2, abs=0.01)


def test_a_prim_without_joints_is_no_articulation(stage):
    stage.DefinePrim("/World/Cube", "Cube")
    with pytest.raises(BadPrim, match="/World/Cube is no articulation"):
        Articulation(stage, "/World/Cube")


def test_links_stand_while_physics_plays_and_move_with_the_joints(stage):
    planar_arm(stage)
    ball = link(stage, "/World/Ball", (0, 0, 5))
    _stiffen(stage, "elbow", "slider")
    arm = get_articulations().at("/World/Arm")
    arm.set_velocities([0.6, 0.0, 0.0])
    get_timeline().play()
    for _ in range(30):
        get_app().update()
    assert at(ball)[2] < 4
    assert arm.positions == pytest.approx([0.3, 0, 0], abs=3e-3)  # nothing brakes the shoulder
    assert arm.velocities[0] == pytest.approx(0.6, rel=0.01)
    assert at(stage.GetPrimAtPath("/World/Arm/hand")) == pytest.approx(_hand(*arm.positions), abs=1e-5)
    assert "/World/Arm/hand" in engines.physics().rigid_bodies
    arm.set_positions([0.5, 0.25, 0.1])
    assert at(stage.GetPrimAtPath("/World/Arm/hand")) == pytest.approx(_hand(0.5, 0.25, 0.1), abs=1e-5)
    get_timeline().stop()
    assert at(stage.GetPrimAtPath("/World/Arm/hand")) == pytest.approx([2, 0, 0], abs=1e-6)


def test_links_at_rest_are_shown_where_their_base_is_put(stage):
    """They stayed where they were on the stage, and in pictures, until a joint moved."""
    planar_arm(stage)
    get_timeline().play()
    for _ in range(3):
        get_app().update()
    base = stage.GetPrimAtPath("/World/Arm/base")
    base.GetAttribute("xformOp:translate").Set((3, 4, 5))
    base.GetAttribute("xformOp:orient").Set(Gf.Quatf(0.5**0.5, 0, 0, 0.5**0.5))
    get_app().update()
    for name, reach in (("base", 0), ("upper", 0), ("lower", 1), ("hand", 2)):
        assert at(stage.GetPrimAtPath(f"/World/Arm/{name}")) == pytest.approx([3, 4 + reach, 5], abs=1e-5)


def test_a_link_pushes_what_is_in_its_way(stage):
    planar_arm(stage)
    ball = link(stage, "/World/Ball", (2, 0.3, 0))
    ball.CreateAttribute("physxRigidBody:disableGravity", Sdf.ValueTypeNames.Bool).Set(True)
    _stiffen(stage, "elbow", "slider")
    arm = get_articulations().at("/World/Arm")
    arm.set_velocities([0.6, 0.0, 0.0])
    get_timeline().play()
    for _ in range(30):
        get_app().update()
    # Of the arm's momentum about the shoulder, 5 kg m² times its velocity, the ball of 1 kg at 2 m takes its part,
    # and turns.
    assert arm.velocities[0] == pytest.approx(0.6 * 5 / (5 + 4), rel=0.1)
    assert at(ball)[1] > 0.48


def test_efforts_push_joints_for_one_step(stage):
    planar_arm(stage)
    _stiffen(stage, "elbow", "slider")
    arm = get_articulations().at("/World/Arm")
    with pytest.raises(PhysicsError, match="/World/Arm: no effort acts"):
        arm.apply_efforts([1.0, 0.0, 0.0])
    get_timeline().play()
    for _ in range(30):
        arm.apply_efforts([2.0, 0.0, 0.0])
        get_app().update()
    turned = 2.0 / 5 * 0.5  # torque over inertia, for half a second
    assert arm.velocities[0] == pytest.approx(turned, rel=0.02)
    for _ in range(30):
        get_app().update()
    assert arm.velocities[0] == pytest.approx(turned, rel=0.02)


def _stiffen(stage, *joints: str) -> None:
    """Give joints drives that hold them where they are."""
    for name in joints:
        drive = UsdPhysics.DriveAPI.Apply(stage.GetPrimAtPath(f"/World/Arm/{name}"), _INSTANCES[name])
        drive.CreateStiffnessAttr(1e5)
        drive.CreateDampingAttr(1e3)
