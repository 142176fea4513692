"""Mechanisms of joints against closed forms.

The solver's steps of 1/240 s end with the velocity that they integrate with, so that what moves is half of one ahead;
amplitudes and periods are within 1 %. PhysX (ovphysx 0.7.0, 60 steps per second) is within 0.3 % of the equations of
the pendulum, the double pendulum and the damped door here.
"""

from __future__ import annotations

from contextlib import nullcontext

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics
from scipy.special import ellipk

from tests.physics.mechanisms import angle, drive, free_axes, joint, limit, rod, rotation
from tests.physics.scenes import add, new_stage, playing, position, set_value, velocity
from tests.sampled_cases import crossed
from usdsdg.errors import UsdsdgWarning

G, STEP = 9.81, 1.0 / 60.0
LAG = 1.0 / 480.0  # half of the solver's step


def integrated(acceleration, start: list[float], times: np.ndarray) -> np.ndarray:
    """Positions (T, N) of a system that starts at rest, by Runge-Kutta with steps of 0.2 ms."""
    n, h = len(start), 2e-4
    y = np.array([*start, *[0.0] * n])

    def rate(y):
        return np.concatenate([y[n:], acceleration(y[:n], y[n:])])

    found, t = [], 0.0
    for time in times:
        while t < time - 1e-9:
            k1 = rate(y)
            k2 = rate(y + h / 2 * k1)
            k3 = rate(y + h / 2 * k2)
            y, t = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + h * k3)), t + h
        found.append(y[:n].copy())
    return np.array(found)


def _add_late(stage) -> float:
    add(stage, "/World/late", at=(9, 0, 0), gravity=False)
    return 1.0


def _set_mass(stage) -> float:
    UsdPhysics.MassAPI(stage.GetPrimAtPath("/World/box")).GetMassAttr().Set(3.0)
    return 3.0


def test_a_pendulum_swings_as_its_equation_says():
    stage, start = new_stage(), 0.6
    bob = rod(stage, "/World/bob", (0, 0, 2), (0, -0.5 * np.sin(start), 2 - 0.5 * np.cos(start)))
    joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/bob", (0, 0, 2))
    engine = playing(stage)
    found = []
    for _ in range(180):
        engine.step(STEP)
        offset = position(bob) - (0, 0, 2)
        assert np.linalg.norm(offset) == pytest.approx(0.25, abs=1e-6)
        found.append(np.arctan2(-offset[1], -offset[2]))
    inertia = 0.25**2 + (0.5**2 + 0.04**2) / 12
    times = np.arange(1, 181) * STEP + LAG
    expected = integrated(lambda q, _: -G * 0.25 / inertia * np.sin(q), [start], times)[:, 0]
    assert np.array(found) == pytest.approx(expected, abs=0.01 * start)


def test_a_pendulum_that_swings_far_keeps_its_period():
    """It lost 3 % of its energy in ten seconds, and its periods became 2 % shorter.

    They are K(sin(q/2)) / (pi/2) times that of small swings, K being the complete elliptic integral.
    """
    stage, start = new_stage(), 2.0
    bob = rod(stage, "/World/bob", (0, 0, 0), (0, -np.sin(start), -np.cos(start)))
    joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/bob", (0, 0, 0))
    engine = playing(stage)
    found = []
    for _ in range(600):
        engine.step(STEP)
        found.append(-position(bob)[1])
    offsets = np.array(found)
    before = np.flatnonzero((offsets[:-1] > 0.0) & (offsets[1:] <= 0.0))
    passes = before + offsets[before] / (offsets[before] - offsets[before + 1])
    inertia = 0.25 + (1.0 + 0.04**2) / 12
    period = 4 * np.sqrt(inertia / (G * 0.5)) * ellipk(np.sin(start / 2) ** 2)
    assert np.diff(passes) * STEP == pytest.approx(np.full(4, period), rel=3e-3)


def test_a_double_pendulum_swings_as_its_equations_say():
    stage, starts, length, width = new_stage(), (0.6, 0.9), 0.5, 0.04
    ends = [np.array([0, -length * np.sin(q), -length * np.cos(q)]) for q in starts]
    top = np.array([0, 0, 2.0])
    upper = rod(stage, "/World/upper", top, top + ends[0])
    lower = rod(stage, "/World/lower", top + ends[0], top + ends[0] + ends[1])
    joint(stage, "/World/shoulder", UsdPhysics.RevoluteJoint, "", "/World/upper", top.tolist())
    joint(stage, "/World/elbow", UsdPhysics.RevoluteJoint, "/World/upper", "/World/lower", (top + ends[0]).tolist())
    inertia = length**2 / 4 + (length**2 + width**2) / 12

    def acceleration(q, v):
        coupling = length**2 / 2
        mass = np.array([[inertia + length**2, coupling * np.cos(q[0] - q[1])], [0, inertia]])
        mass[1, 0] = mass[0, 1]
        turning = coupling * np.sin(q[0] - q[1]) * np.array([-(v[1] ** 2), v[0] ** 2])
        return np.linalg.solve(mass, turning - G * length * np.array([1.5 * np.sin(q[0]), 0.5 * np.sin(q[1])]))

    engine = playing(stage)
    found = []
    for _ in range(120):
        engine.step(STEP)
        first = 2 * (position(upper) - top)
        second = 2 * (position(lower) - top - first)
        found.append([np.arctan2(-end[1], -end[2]) for end in (first, second)])
    expected = integrated(acceleration, list(starts), np.arange(1, 121) * STEP + LAG)
    assert np.array(found) == pytest.approx(expected, abs=0.01 * max(starts))


def test_a_slider_stops_at_its_limit_and_a_drive_carries_a_weight():
    stage = new_stage()
    free = add(stage, "/World/free", at=(0, 0, 1))
    limit(joint(stage, "/World/rail", UsdPhysics.PrismaticJoint, "", "/World/free", (0, 0, 1), axis="Z"), -0.3, 0.3)
    held = add(stage, "/World/held", at=(1, 0, 1))
    UsdPhysics.MassAPI.Apply(held).CreateMassAttr(2.0)
    lift = joint(stage, "/World/lift", UsdPhysics.PrismaticJoint, "", "/World/held", (1, 0, 1), axis="Z")
    api = drive(lift, "linear", stiffness=1000.0, damping=100.0, target=0.2)
    weak = add(stage, "/World/weak", at=(2, 0, 1))
    UsdPhysics.MassAPI.Apply(weak).CreateMassAttr(2.0)
    rail = joint(stage, "/World/weak_lift", UsdPhysics.PrismaticJoint, "", "/World/weak", (2, 0, 1), axis="Z")
    drive(rail, "linear", stiffness=1000.0, damping=100.0, target=0.2, max_force=15.0)
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    assert position(free) == pytest.approx([0, 0, 0.7], abs=1e-4)
    assert position(held) == pytest.approx([1, 0, 1.2 - 2 * G / 1000], abs=1e-4)
    fall = (G - 15.0 / 2.0) / 2  # what the drive's force leaves of gravity
    assert 1 - position(weak)[2] == pytest.approx(fall, rel=0.01)
    api.GetTargetPositionAttr().Set(-0.1)
    for _ in range(60):
        engine.step(STEP)
    assert position(held) == pytest.approx([1, 0, 0.9 - 2 * G / 1000], abs=1e-4)


def test_a_hinge_turns_to_its_target_in_degrees_and_stops_at_its_limit():
    stage = new_stage()
    arm = rod(stage, "/World/arm", (0, 0, 1), (0.5, 0, 1))
    hinge = joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/arm", (0, 0, 1), axis="Z")
    limit(hinge, -20.0, 45.0)
    api = drive(hinge, "angular", stiffness=10.0, damping=1.0, target=30.0)
    engine = playing(stage)
    for _ in range(90):
        engine.step(STEP)
    assert position(arm) == pytest.approx([0.25 * np.cos(np.pi / 6), 0.25 * np.sin(np.pi / 6), 1], abs=1e-4)
    assert engine.joint_positions(["/World/hinge"]) == pytest.approx([np.pi / 6], abs=1e-4)
    api.GetTargetPositionAttr().Set(90.0)
    for _ in range(90):
        engine.step(STEP)
    assert np.degrees(engine.joint_positions(["/World/hinge"])) == pytest.approx([45.0], abs=0.05)


def test_a_parallelogram_closes_and_swings_as_one_pendulum():
    stage, start, length = new_stage(), 0.5, 0.5
    low = np.array([0, -length * np.sin(start), -length * np.cos(start)])
    a, b = np.array([0, 0, 2.0]), np.array([0, 0.6, 2.0])
    left = rod(stage, "/World/left", a, a + low)
    bar = rod(stage, "/World/bar", a + low, b + low)
    right = rod(stage, "/World/right", b, b + low)
    for name, body0, body1, at in (
        ("a", "", "/World/left", a), ("b", "", "/World/right", b),
        ("c", "/World/left", "/World/bar", a + low), ("d", "/World/bar", "/World/right", b + low),
    ):  # fmt: skip
        joint(stage, f"/World/{name}", UsdPhysics.RevoluteJoint, body0, body1, at.tolist())
    engine = playing(stage)
    found = []
    for _ in range(120):
        engine.step(STEP)
        found.append(np.arctan2(*-(position(left) - a)[1:]))
        assert position(right) - position(left) == pytest.approx([0, 0.6, 0], abs=5e-4)
        assert position(bar)[1:] - a[1:] == pytest.approx(2 * (position(left) - a)[1:] + (0.3, 0), abs=5e-4)
    rods = 2 * (length**2 / 4 + (length**2 + 0.04**2) / 12)
    rate = (2 * G * length / 2 + G * length) / (rods + length**2)
    times = np.arange(1, 121) * STEP + LAG
    expected = integrated(lambda q, _: -rate * np.sin(q), [start], times)[:, 0]
    assert np.array(found) == pytest.approx(expected, abs=0.01 * start)


def test_a_general_joint_moves_along_its_free_axes_only():
    stage = new_stage()
    body = add(stage, "/World/body", at=(0, 0, 1))
    made = joint(stage, "/World/d6", UsdPhysics.Joint, "", "/World/body", (0, 0, 1))
    free_axes(made, "rotZ", transX=(-1.0, 1.0), transY=(-0.05, 0.05))
    drive(made, "transX", stiffness=4000.0, damping=400.0, target=0.3)
    drive(made, "rotZ", stiffness=1.0, damping=0.1, target=60.0)
    drive(made, "transY", damping=400.0, target_velocity=0.5)
    engine = playing(stage)
    for _ in range(120):
        engine.step(STEP)
    assert position(body) == pytest.approx([0.3, 0.05, 1], abs=1e-3)
    assert np.degrees(angle(body, 2, 0)) == pytest.approx(60.0, abs=0.1)
    assert rotation(body)[2] == pytest.approx([0, 0, 1], abs=1e-6)


def test_a_general_joint_that_locks_no_axis_drives_and_limits_its_axes():
    """A body that is held at a distance along x and does not fall on, and moves and turns freely else."""
    stage = new_stage()
    body = add(stage, "/World/body", at=(0, 0, 1))
    set_value(body, "physics:velocity", Gf.Vec3f(0, 0.5, 0))
    set_value(body, "physics:angularVelocity", Gf.Vec3f(0, 0, 30))
    made = joint(stage, "/World/d6", UsdPhysics.Joint, "", "/World/body", (0, 0, 1))
    every = ("transX", "transY", "rotX", "rotY", "rotZ")
    free_axes(made, *every, transZ=(-0.2, 0.5))
    drive(made, "transX", stiffness=4000.0, damping=400.0, target=0.3)
    engine = playing(stage)
    for _ in range(120):
        engine.step(STEP)
    assert position(body) == pytest.approx([0.3, 1.0, 0.8], abs=5e-3)
    assert np.degrees(angle(body, 2, 0)) == pytest.approx(60.0, abs=0.5)
    set_value(body, "physics:angularVelocity", Gf.Vec3f(0, 0, -45))
    for _ in range(60):
        engine.step(STEP)
    assert body.GetAttribute("physics:angularVelocity").Get() == pytest.approx([0, 0, -45], abs=0.1)
    assert np.degrees(angle(body, 2, 0)) == pytest.approx(15.0, abs=1.0)


def test_a_door_on_two_hinges_turns_by_its_inertia_and_stops_open(recwarn):
    stage, width, mass = new_stage(), 0.8, 20.0
    add(stage, "/World/frame", at=(0, 0, 1), scale=(0.05, 0.05, 1), body=False)
    door = add(stage, "/World/door", at=(0.05 + width / 2, 0, 1), scale=(width / 2, 0.02, 0.9))
    UsdPhysics.MassAPI.Apply(door).CreateMassAttr(mass)
    for name, z in (("top", 1.7), ("bottom", 0.3)):
        path = f"/World/{name}"
        made = joint(stage, path, UsdPhysics.RevoluteJoint, "/World/frame", "/World/door", (0.05, 0, z), axis="Z")
        limit(made, -90.0, 90.0)
    engine = playing(stage)
    for _ in range(30):
        engine.apply_joint_efforts(["/World/top"], [4.0])
        engine.step(STEP)
    inertia = mass * ((width / 2) ** 2 + (width**2 + 0.04**2) / 12)
    assert engine.joint_velocities(["/World/top"])[0] == pytest.approx(4.0 * 0.5 / inertia, rel=0.01)
    for _ in range(270):
        engine.step(STEP)
    assert np.degrees(engine.joint_positions(["/World/top"])) == pytest.approx([90.0], abs=0.05)
    assert position(door) == pytest.approx([0.05, width / 2, 1], abs=1e-3)
    assert not recwarn


def test_a_damped_door_slows_down_exponentially():
    """I dω/dt = -c ω, with 4 N m s/rad: the door is authored turning by 60 degrees per second."""
    stage, width, mass, damping = new_stage(), 0.8, 20.0, 4.0
    add(stage, "/World/frame", at=(0, 0, 1), scale=(0.05, 0.05, 1), body=False)
    door = add(stage, "/World/door", at=(0.05 + width / 2, 0, 1), scale=(width / 2, 0.02, 0.9))
    UsdPhysics.MassAPI.Apply(door).CreateMassAttr(mass)
    UsdPhysics.RigidBodyAPI(door).CreateAngularVelocityAttr(Gf.Vec3f(0, 0, 60))
    UsdPhysics.RigidBodyAPI(door).CreateVelocityAttr(Gf.Vec3f(0, np.radians(60) * width / 2, 0))
    hinge = joint(
        stage, "/World/hinge", UsdPhysics.RevoluteJoint, "/World/frame", "/World/door", (0.05, 0, 1), axis="Z"
    )
    drive(hinge, "angular", damping=np.radians(damping))
    engine = playing(stage)
    speeds = []
    for _ in range(120):
        engine.step(STEP)
        speeds.append(np.degrees(engine.joint_velocities(["/World/hinge"])[0]))
    inertia = mass * ((width / 2) ** 2 + (width**2 + 0.04**2) / 12)
    assert speeds == pytest.approx(60 * np.exp(-damping * STEP * np.arange(1, 121) / inertia), rel=0.01)


@pytest.mark.parametrize("meters", [1.0, 0.01])
def test_units_and_scale_of_frames(meters):
    """A lever of 0.2 m below a scaled prim, in meters and in centimeters, carries what a drive's torque says."""
    stage = new_stage(meters_per_unit=meters)
    unit = 1.0 / meters
    lever = add(stage, "/World/lever", at=(0.1 * unit, 0, unit), scale=(0.1 * unit, 0.02 * unit, 0.02 * unit))
    UsdPhysics.MassAPI.Apply(lever).CreateMassAttr(3.0)
    made = joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/lever", (0, 0, unit), axis="Y")
    # Torque per degree in stage units.
    drive(made, "angular", stiffness=2.0 * unit**2, damping=0.2 * unit**2)
    engine = playing(stage)
    for _ in range(90):
        engine.step(STEP)
    turned = np.degrees(engine.joint_positions(["/World/hinge"])[0])
    assert turned == pytest.approx(3.0 * G * 0.1 * np.cos(np.radians(turned)) / 2.0, rel=1e-3)


def test_an_acceleration_drive_does_not_depend_on_mass():
    stage = new_stage()
    found = []
    for number, mass in enumerate((0.1, 20.0)):
        body = add(stage, f"/World/body_{number}", at=(number, 0, 1), gravity=False)
        UsdPhysics.MassAPI.Apply(body).CreateMassAttr(mass)
        path = f"/World/rail_{number}"
        made = joint(stage, path, UsdPhysics.PrismaticJoint, "", f"/World/body_{number}", (number, 0, 1), axis="Y")
        drive(made, "linear", stiffness=100.0, damping=2.0, target=0.1, kind="acceleration")
        found.append(body)
    engine = playing(stage)
    path = []
    for _ in range(60):
        engine.step(STEP)
        path.append([position(body)[1] for body in found])
    light, heavy = np.array(path).T
    assert heavy == pytest.approx(light, abs=1e-5)
    assert np.array(path).max() > 0.15  # it overshoots: the damping is a tenth of critical


def test_jointed_bodies_do_not_collide_unless_they_say_so():
    stage = new_stage()
    for name, y in (("apart", 0.0), ("together", 2.0)):
        add(stage, f"/World/{name}_post", at=(0, y, 1), scale=(0.1, 0.1, 0.1), body=False)
        door = rod(stage, f"/World/{name}", (0.05, y, 1), (0.85, y, 1))
        path = f"/World/{name}_hinge"
        made = joint(
            stage, path, UsdPhysics.RevoluteJoint, f"/World/{name}_post", f"/World/{name}", (0.1, y, 1), axis="Z"
        )
        made.CreateCollisionEnabledAttr(name == "apart")
        drive(made, "angular", stiffness=1.0, damping=0.1, target=90.0)
    engine = playing(stage)
    for _ in range(120):
        engine.step(STEP)
    apart, together = np.degrees(engine.joint_positions(["/World/apart_hinge", "/World/together_hinge"]))
    assert together == pytest.approx(90, abs=0.1)
    assert apart < 60  # the door, which starts inside of the post, stays with it
    assert door


@pytest.mark.parametrize("articulated", [False, True])
def test_a_disabled_joint_holds_nothing_and_can_be_enabled(articulated):
    """Where its body is, if that is the base of an articulation; else it takes the body back, as in PhysX."""
    stage = new_stage()
    body = add(stage, "/World/body", at=(0, 0, 5))
    if articulated:
        UsdPhysics.ArticulationRootAPI.Apply(body)
    made = joint(stage, "/World/fix", UsdPhysics.FixedJoint, "", "/World/body", (0, 0, 5))
    made.CreateJointEnabledAttr(False)
    engine = playing(stage)
    for _ in range(30):
        engine.step(STEP)
    fallen = position(body)[2]
    assert fallen == pytest.approx(5 - G / 8, abs=0.05)
    made.GetJointEnabledAttr().Set(True)
    for _ in range(30):
        engine.step(STEP)
    assert position(body)[2] == pytest.approx(fallen if articulated else 5.0, abs=1e-6)
    engine.stop()
    assert position(body)[2] == 5


def test_what_joints_are_attached_to_carries_them():
    """A pendulum below a kinematic body follows it."""
    stage = new_stage()
    cart = add(stage, "/World/cart", at=(0, 0, 2))
    UsdPhysics.RigidBodyAPI(cart).CreateKinematicEnabledAttr(True)
    bob = rod(stage, "/World/bob", (0, 0, 2), (0, 0, 1.5))
    joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "/World/cart", "/World/bob", (0, 0, 2))
    engine = playing(stage)
    translate = UsdGeom.Xformable(cart).GetOrderedXformOps()[0]
    for step in range(30):
        translate.Set(Gf.Vec3d(0, 0.5 * ((step + 1) * STEP) ** 2 * 2.0, 2))
        engine.step(STEP)
    offset = position(bob) - position(cart)
    assert np.linalg.norm(offset) == pytest.approx(0.25, abs=1e-5)
    inertia = 0.25**2 + (0.5**2 + 0.04**2) / 12
    expected = integrated(
        lambda q, _: 0.25 / inertia * (2.0 * np.cos(q) - G * np.sin(q)), [0.0], np.array([0.5 + LAG])
    )[0, 0]
    assert np.arctan2(-offset[1], -offset[2]) == pytest.approx(expected, abs=0.02 * expected)


def test_floating_bodies_keep_their_momentum():
    stage = new_stage()
    for name, x in (("a", 0.0), ("b", 0.4)):
        body = add(stage, f"/World/{name}", at=(x, 0, 1), gravity=False)
        UsdPhysics.MassAPI.Apply(body).CreateMassAttr(1.0)
    UsdPhysics.RigidBodyAPI(stage.GetPrimAtPath("/World/a")).CreateVelocityAttr(Gf.Vec3f(0, 1, 0))
    joint(stage, "/World/ball", UsdPhysics.SphericalJoint, "/World/a", "/World/b", (0.2, 0, 1))
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    a, b = (stage.GetPrimAtPath(f"/World/{name}") for name in "ab")
    # Of half a turn around each other the solver's steps make an error of first order.
    assert position(a) + position(b) == pytest.approx([0.4, 1.0, 2.0], abs=0.01)
    ends = [position(a) + 0.2 * rotation(a)[0], position(b) - 0.2 * rotation(b)[0]]
    assert ends[0] == pytest.approx(ends[1], abs=1e-5)


def test_what_cannot_be_simulated_is_held(recwarn):
    stage = new_stage()
    body = add(stage, "/World/body", at=(0, 0, 5))
    wheel = add(stage, "/World/wheel", at=(1, 0, 5))
    joint(stage, "/World/axle", UsdPhysics.RevoluteJoint, "/World/body", "/World/wheel", (1, 0, 5))
    screw = stage.DefinePrim("/World/screw", "PhysxPhysicsScrewJoint")
    screw.CreateRelationship("physics:body0", custom=False).AddTarget("/World/body")
    engine = playing(stage)
    for _ in range(10):
        engine.step(STEP)
    assert position(body)[2] == position(wheel)[2] == 5
    assert any("/World/screw" in str(warning.message) for warning in recwarn)


def test_mimic_joints_follow():
    stage = new_stage()
    base = add(stage, "/World/base", at=(0, 0, 1))
    joint(stage, "/World/fix", UsdPhysics.FixedJoint, "", "/World/base", (0, 0, 1))
    for name, y in (("left", 0.3), ("right", -0.3)):
        add(stage, f"/World/{name}", at=(0, y, 1), scale=(0.02, 0.02, 0.02))
        made = joint(
            stage,
            f"/World/{name}_rail",
            UsdPhysics.PrismaticJoint,
            "/World/base",
            f"/World/{name}",
            (0, y, 1),
            axis="Y",
        )
    drive(stage_joint(stage, "/World/left_rail"), "linear", stiffness=500.0, damping=50.0, target=-0.1)
    made.GetPrim().AddAppliedSchema("PhysxMimicJointAPI:rotX")
    made.GetPrim().CreateRelationship("physxMimicJoint:rotX:referenceJoint").SetTargets(["/World/left_rail"])
    made.GetPrim().CreateAttribute("physxMimicJoint:rotX:gearing", Sdf.ValueTypeNames.Float).Set(1.0)
    engine = playing(stage)
    for _ in range(90):
        engine.step(STEP)
    left, right = engine.joint_positions(["/World/left_rail", "/World/right_rail"])
    assert left == pytest.approx(-0.1, abs=2e-3)
    assert right == pytest.approx(-left, abs=2e-3)
    assert base


def stage_joint(stage, path: str) -> UsdPhysics.Joint:
    return UsdPhysics.Joint(stage.GetPrimAtPath(path))


def test_states_of_joints_are_where_they_start_and_are_shown():
    stage = new_stage()
    arm = rod(stage, "/World/arm", (0, 0, 1), (0.5, 0, 1))
    made = joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/arm", (0, 0, 1), axis="Z")
    prim = made.GetPrim()
    prim.AddAppliedSchema("PhysicsJointStateAPI:angular")
    state = prim.CreateAttribute("state:angular:physics:position", Sdf.ValueTypeNames.Float, custom=False)
    speed = prim.CreateAttribute("state:angular:physics:velocity", Sdf.ValueTypeNames.Float, custom=False)
    state.Set(90.0)
    speed.Set(60.0)
    engine = playing(stage)
    for _ in range(30):
        engine.step(STEP)
    assert state.Get() == pytest.approx(120.0, abs=0.2)
    assert speed.Get() == pytest.approx(60.0, abs=0.2)
    assert position(arm)[:2] == pytest.approx(
        [0.25 * np.cos(np.radians(120)), 0.25 * np.sin(np.radians(120))], abs=1e-3
    )
    state.Set(0.0)  # an edit while playing moves the joint
    engine.step(STEP)
    assert state.Get() == pytest.approx(1.0, abs=0.02)
    engine.stop()
    assert (state.Get(), speed.Get()) == (90.0, 60.0)


def test_a_mechanism_that_is_moved_while_playing_keeps_its_joints():
    """Two rods on a hinge, of which the first is fixed to the world: set elsewhere alone, and with all above it.

    They are an articulation, whose base stays where it is put.
    """
    stage = new_stage()
    group = UsdGeom.Xform.Define(stage, "/World/group")
    UsdPhysics.ArticulationRootAPI.Apply(group.GetPrim())
    shift = group.AddTranslateOp()
    rod(stage, "/World/group/base", (0, 0, 1), (0, 0, 1.5))
    rod(stage, "/World/group/arm", (0, 0, 1.5), (0.5, 0, 1.5))
    joint(stage, "/World/group/fix", UsdPhysics.FixedJoint, "", "/World/group/base", (0, 0, 1))
    made = joint(
        stage, "/World/group/hinge", UsdPhysics.RevoluteJoint, "/World/group/base", "/World/group/arm", (0, 0, 1.5),
        axis="Z",
    )  # fmt: skip
    drive(made, "angular", stiffness=10.0, damping=1.0, target=40.0)
    base, arm = (stage.GetPrimAtPath(f"/World/group/{name}") for name in ("base", "arm"))
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    offset = position(arm) - position(base)
    assert np.degrees(engine.joint_positions(["/World/group/hinge"])) == pytest.approx([40.0], abs=0.1)
    shift.Set(Gf.Vec3d(3, 0, 0))
    engine.step(STEP)
    assert position(base) == pytest.approx([3, 0, 1.25], abs=1e-5)
    assert position(arm) - position(base) == pytest.approx(offset, abs=1e-3)
    UsdGeom.Xformable(base).GetOrderedXformOps()[0].Set(Gf.Vec3d(0, 2, 1.25))
    engine.step(STEP)
    assert position(base) == pytest.approx([3, 2, 1.25], abs=1e-5)
    assert position(arm) - position(base) == pytest.approx(offset, abs=1e-3)
    assert np.degrees(engine.joint_positions(["/World/group/hinge"])) == pytest.approx([40.0], abs=0.1)


def test_what_is_added_while_playing_does_not_disturb_joints():
    stage, found = new_stage(), []
    bob = rod(stage, "/World/bob", (0, 0, 2), (0, -0.3, 1.6))
    joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/bob", (0, 0, 2))
    engine = playing(stage)
    for step in range(60):
        if step == 30:
            add(stage, "/World/new", at=(3, 0, 1))
        engine.step(STEP)
        found.append(engine.joint_velocities(["/World/hinge"])[0])
    # The acceleration, which gravity bounds, is all that changes the velocity from step to step.
    assert np.abs(np.diff(found)).max() < 1.5 * G / 0.5 * STEP
    assert position(bob)[2] < 2


@pytest.mark.parametrize(("ends", "mass"), crossed([("", "/World/wheel"), ("/World/wheel", "")], [None, 3.0]))
def test_whole_turns_of_a_hinge_are_kept_where_physics_reads_the_stage_again(ends, mass):
    """A wheel at 720 degrees, which its drive holds there, does not turn back."""
    stage = new_stage()
    wheel = add(stage, "/World/wheel", gravity=False)
    UsdPhysics.MassAPI.Apply(wheel).CreateMassAttr(1.0)
    hinge = joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, *ends, (0, 0, 0), axis="Z")
    drive(hinge, "angular", stiffness=1.0, damping=0.2, target=720.0)
    engine = playing(stage)
    engine.advance(4.0)
    assert np.degrees(engine.joint_positions(["/World/hinge"])) == pytest.approx([720.0], abs=0.5)
    if mass is None:
        add(stage, "/World/late", at=(9, 0, 0), gravity=False)
    else:
        UsdPhysics.MassAPI(wheel).GetMassAttr().Set(mass)
    engine.advance(STEP)
    assert np.degrees(engine.joint_positions(["/World/hinge"])) == pytest.approx([720.0], abs=0.5)
    assert engine.joint_velocities(["/World/hinge"]) == pytest.approx([0.0], abs=0.05)


@pytest.mark.parametrize("edit", [_add_late, _set_mass])
def test_an_effort_acts_although_physics_reads_the_stage_again_before_the_step(edit):
    stage = new_stage()
    box = add(stage, "/World/box", gravity=False)
    UsdPhysics.MassAPI.Apply(box).CreateMassAttr(1.0)
    joint(stage, "/World/slide", UsdPhysics.PrismaticJoint, "", "/World/box", (0, 0, 0))
    engine = playing(stage)
    engine.advance(STEP)
    engine.apply_joint_efforts(["/World/slide"], [60.0])
    mass = edit(stage)
    engine.advance(2 * STEP)
    assert velocity(box) == pytest.approx([60.0 / mass * STEP, 0, 0], rel=1e-4, abs=1e-6)


@pytest.mark.parametrize(("force", "breaks"), [(25.0, False), (15.0, True)])
def test_a_joint_breaks_under_more_than_its_force(force, breaks):
    """A weight of 2 kg, 19.6 N, hangs on a fixed joint below a kinematic body."""
    stage = new_stage()
    beam = add(stage, "/World/beam", at=(0, 0, 3))
    UsdPhysics.RigidBodyAPI(beam).CreateKinematicEnabledAttr(True)
    weight = add(stage, "/World/weight", at=(0, 0, 2))
    UsdPhysics.MassAPI.Apply(weight).CreateMassAttr(2.0)
    made = joint(stage, "/World/hook", UsdPhysics.FixedJoint, "/World/beam", "/World/weight", (0, 0, 2.5))
    made.CreateBreakForceAttr(force)
    engine = playing(stage)
    for _ in range(30):
        engine.step(STEP)
    fallen = 2 - position(weight)[2]
    assert fallen == pytest.approx(G / 8 if breaks else 0.0, abs=0.1 if breaks else 1e-6)


@pytest.mark.parametrize(("torque", "breaks"), [(5.0, False), (3.0, True)])
def test_a_joint_breaks_under_more_than_its_torque(torque, breaks):
    """A weight of 2 kg 0.2 m beside a fixed joint, 3.92 N m."""
    stage = new_stage()
    beam = add(stage, "/World/beam", at=(0, 0, 3))
    UsdPhysics.RigidBodyAPI(beam).CreateKinematicEnabledAttr(True)
    weight = add(stage, "/World/weight", at=(0.2, 0, 2.5))
    UsdPhysics.MassAPI.Apply(weight).CreateMassAttr(2.0)
    made = joint(stage, "/World/hook", UsdPhysics.FixedJoint, "/World/beam", "/World/weight", (0, 0, 2.5))
    made.CreateBreakTorqueAttr(torque)
    engine = playing(stage)
    for _ in range(30):
        engine.step(STEP)
    fallen = 2.5 - position(weight)[2]
    assert fallen == pytest.approx(G / 8 if breaks else 0.0, abs=0.1 if breaks else 1e-6)


@pytest.mark.parametrize("kind", [UsdPhysics.RevoluteJoint, UsdPhysics.SphericalJoint])
def test_a_free_hinge_passes_on_no_torque(kind):
    """A rod that swings fast through the plane of its hinge, of which each torque would break the joint."""
    stage = new_stage()
    bob = rod(stage, "/World/bob", (0, 0, 2), (0, -1.0, 2))
    joint(stage, "/World/hinge", kind, "", "/World/bob", (0, 0, 2)).CreateBreakTorqueAttr(0.05)
    engine = playing(stage)
    for _ in range(90):
        engine.step(STEP)
    from_hinge = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(bob).ExtractTranslation()) - (0, 0, 2)
    assert np.linalg.norm(from_hinge) == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize("signs", [(1, -1), (-1, 1), (-1, -1)])
@pytest.mark.parametrize(("limits", "expected"), [(None, 0.0), ((300.0, 400.0), 360.0), ((-400.0, -200.0), -360.0)])
def test_signs_of_quaternions_are_no_turns(signs, limits, expected):
    """q and -q are one rotation: a hinge begins within half a turn of 0, or in its limits."""
    stage = new_stage()
    add(stage, "/World/box", at=(0, 0, 1), gravity=False)
    made = joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/box", (0, 0, 1), axis="Z")
    made.CreateLocalRot0Attr(Gf.Quatf(signs[0]))
    made.CreateLocalRot1Attr(Gf.Quatf(signs[1]))
    if limits is not None:
        made.CreateLowerLimitAttr(limits[0])
        made.CreateUpperLimitAttr(limits[1])
    engine = playing(stage)
    engine.step(STEP)
    assert np.degrees(engine.joint_positions(["/World/hinge"])) == pytest.approx([expected], abs=1e-3)
    assert engine.joint_velocities(["/World/hinge"]) == pytest.approx([0.0], abs=1e-3)


def test_friction_holds_a_joint_up_to_its_torque():
    """Levers whose weight asks for 0.98 N m at the hinge, which rubs with 1.2 and with 0.6 N m."""
    stage = new_stage()
    for number, friction in enumerate((1.2, 0.6)):
        lever = add(stage, f"/World/lever_{number}", at=(0.1, number, 1), scale=(0.1, 0.02, 0.02))
        UsdPhysics.MassAPI.Apply(lever).CreateMassAttr(1.0)
        path = f"/World/hinge_{number}"
        made = joint(stage, path, UsdPhysics.RevoluteJoint, "", f"/World/lever_{number}", (0, number, 1), axis="Y")
        UsdPhysics.ArticulationRootAPI.Apply(lever)
        made.GetPrim().AddAppliedSchema("PhysxJointAxisAPI:angular")
        name = "physxJointAxis:angular:staticFrictionEffort"
        made.GetPrim().CreateAttribute(name, Sdf.ValueTypeNames.Float).Set(friction)
    engine = playing(stage)
    for _ in range(12):
        engine.step(STEP)
    held, slides = engine.joint_velocities(["/World/hinge_0", "/World/hinge_1"])
    assert held == pytest.approx(0.0, abs=1e-4)
    inertia = 0.1**2 + (0.2**2 + 0.04**2) / 12
    assert slides == pytest.approx((G * 0.1 - 0.6) / inertia * 0.2, rel=0.1)  # a little less as it turns


@pytest.mark.parametrize("articulated", [False, True])
@pytest.mark.parametrize(
    ("name", "amount"),
    [
        ("physxJoint:jointFriction", 0.5),
        ("physxJoint:armature", 2.0),
        ("physxJoint:maxJointVelocity", 90.0),
        ("physxJointAxis:angular:viscousFrictionCoefficient", 0.05),
        ("physxJointAxis:angular:staticFrictionEffort", 5.0),
    ],
)
def test_what_rubs_or_resists_in_joints_acts_in_articulations_alone(name, amount, articulated):
    """PhysX (ovphysx 0.7.0) turns a hinged rod that begins with 4 rad/s on where there is no articulation."""
    stage, path = new_stage(), f"/World/{name.replace(':', '_')}"
    lever = add(stage, "/World/rod", at=(0.3, 0, 0), scale=(0.3, 0.05, 0.05), gravity=False)
    lever.CreateAttribute("physxRigidBody:linearDamping", Sdf.ValueTypeNames.Float).Set(0.0)
    made = joint(stage, path, UsdPhysics.RevoluteJoint, "", "/World/rod", (0, 0, 0), axis="Z")
    UsdPhysics.RigidBodyAPI(lever).CreateAngularVelocityAttr(Gf.Vec3f(0, 0, np.degrees(4)))
    UsdPhysics.RigidBodyAPI(lever).CreateVelocityAttr(Gf.Vec3f(0, 1.2, 0))
    if "armature" in name:
        # Without a drive an armature only changes what the velocity of the body is to its axis.
        drive(made, "angular", damping=0.1)
    made.GetPrim().AddAppliedSchema("PhysxJointAxisAPI:angular" if "Axis" in name else "PhysxJointAPI")
    made.GetPrim().CreateAttribute(name, Sdf.ValueTypeNames.Float).Set(amount)
    if articulated:
        UsdPhysics.ArticulationRootAPI.Apply(lever)
    plain = 4.0 * np.exp(-0.1 * np.degrees(1.0) * 5 * STEP / _rod_inertia()) if "armature" in name else 4.0
    with nullcontext() if articulated else pytest.warns(UsdsdgWarning, match=f"outside of articulations: {path}"):
        engine = playing(stage)
    for _ in range(5):
        engine.step(STEP)
    (speed,) = engine.joint_velocities([path])
    if articulated:
        assert abs(speed - plain) > 0.3
    else:
        assert speed == pytest.approx(plain, rel=0.03, abs=1e-3)


def _rod_inertia():
    """Of the rod of 6 kg about its hinge [kg m²]."""
    return 6.0 * (0.3**2 + (0.6**2 + 0.1**2) / 12)


def test_runs_repeat_bit_for_bit():
    def run():
        stage = new_stage()
        add(stage, "/World/ground", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False)
        start = (0, 0, 1.5)
        for number in range(4):
            end = (start[0] + 0.25, 0.02 * number, 1.5 - 0.05 * number)
            rod(stage, f"/World/link_{number}", start, end)
            joint(stage, f"/World/joint_{number}", UsdPhysics.SphericalJoint,
                  f"/World/link_{number - 1}" if number else "", f"/World/link_{number}", start)  # fmt: skip
            start = end
        add(stage, "/World/box", at=(0.2, 0.1, 0.3))
        engine = playing(stage)
        for _ in range(60):
            engine.step(STEP)
        return [tuple(position(stage.GetPrimAtPath(path))) for path in engine.rigid_bodies]

    assert run() == run()


@pytest.mark.parametrize("swapped", [False, True])
def test_a_universal_joint_swings_before_it_twists(swapped):
    """Without the swing about Y a rod along X stays level, since from body 0 it turns about Z first, as in PhysX.

    From its other end it twists about its own length first, and then swings about any direction: it falls.
    """
    stage = new_stage()
    bob = rod(stage, "/World/bob", (0, 0, 2), (1.0, 0, 2))
    set_value(bob, "physics:angularVelocity", Gf.Vec3f(60, 0, 40))
    ends = ("/World/bob", "") if swapped else ("", "/World/bob")
    free_axes(joint(stage, "/World/joint", UsdPhysics.Joint, *ends, (0, 0, 2)), "rotX", "rotZ")
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    assert (position(bob)[2] == pytest.approx(2.0, abs=5e-3)) != swapped


@pytest.mark.parametrize("sideways", [(0.0, 0.0, 0.0), (1.0, 0.3, 0.0)])
def test_three_axes_of_rotation_pass_where_two_of_them_coincide(sideways):
    """A rod on a slider with a ball at its end falls through the angles at which the axes of its joint are singular."""
    stage = new_stage()
    bob = rod(stage, "/World/bob", (0, 0, 2), (1.0, 0, 2))
    set_value(bob, "physics:velocity", Gf.Vec3f(*sideways))
    made = joint(stage, "/World/slider", UsdPhysics.Joint, "", "/World/bob", (0, 0, 2))
    free_axes(made, "transX", "rotX", "rotY", "rotZ")
    engine, energies = playing(stage), []
    for _ in range(240):
        engine.step(STEP)
        linear, height = velocity(bob), position(bob)[2]
        energies.append(0.5 * (linear @ linear) + G * (height - 2.0))
    assert np.isfinite(energies).all()
    # Of 1 kg; the energy of turning is left out, which is never negative.
    assert max(energies) < 0.5 * np.dot(sideways, sideways) + 0.05 * G
