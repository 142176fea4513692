"""Distance joints against closed forms: rods, ropes and springs between bodies of every kind."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics

from tests.physics.mechanisms import joint, rod
from tests.physics.scenes import add, new_stage, playing, position, velocity

G, STEP = 9.81, 1.0 / 60.0


def ball(stage, path: str, at, *, mass: float = 1.0, gravity: bool = True):
    prim = add(stage, path, "Sphere", at=at, scale=(0.05, 0.05, 0.05), gravity=gravity)
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(mass)
    return prim


def tie(stage, path: str, body0: str, body1: str, at0, at1, *, least=-1.0, most=-1.0, spring=None):
    """A distance joint between points that are given in the frames of bodies, of which \"\" is the world."""
    made = UsdPhysics.DistanceJoint.Define(stage, path)
    for relation, body in ((made.CreateBody0Rel(), body0), (made.CreateBody1Rel(), body1)):
        relation.SetTargets([Sdf.Path(body)] if body else [])
    made.CreateLocalPos0Attr(Gf.Vec3f(*at0))
    made.CreateLocalPos1Attr(Gf.Vec3f(*at1))
    made.CreateMinDistanceAttr(least)
    made.CreateMaxDistanceAttr(most)
    if spring is not None:
        prim = made.GetPrim()
        prim.AddAppliedSchema("PhysxPhysicsDistanceJointAPI")
        prefix = "physxPhysicsDistanceJoint:spring"
        prim.CreateAttribute(f"{prefix}Enabled", Sdf.ValueTypeNames.Bool).Set(True)
        prim.CreateAttribute(f"{prefix}Stiffness", Sdf.ValueTypeNames.Float).Set(spring[0])
        prim.CreateAttribute(f"{prefix}Damping", Sdf.ValueTypeNames.Float).Set(spring[1])
    return made


def swing(length: float, start: float, times: np.ndarray) -> np.ndarray:
    """Angles from the vertical of a point on a massless rod, at rest at the start."""
    y, t, h, found = np.array([start, 0.0]), 0.0, 1e-4, []
    for time in times:
        while t < time - 1e-9:
            middle = y + h / 2 * np.array([y[1], -G / length * np.sin(y[0])])
            y, t = y + h * np.array([middle[1], -G / length * np.sin(middle[0])]), t + h
        found.append(y[0])
    return np.array(found)


@pytest.mark.parametrize("least", [0.5, -1.0])
def test_a_ball_on_a_rod_or_a_rope_swings_like_a_point(least):
    """Half a swing, of which each step takes a part of the speed; PhysX (ovphysx 0.7.0) is 70 mm off at 60 steps per
    second."""
    stage, start = new_stage(), 1.0
    bob = ball(stage, "/World/bob", (0, 0.5 * np.sin(start), 2 - 0.5 * np.cos(start)))
    tie(stage, "/World/tie", "", "/World/bob", (0, 0, 2), (0, 0, 0), least=least, most=0.5)
    engine = playing(stage)
    found, lengths = [], []
    for _ in range(50):
        engine.step(STEP)
        offset = position(bob) - (0, 0, 2)
        lengths.append(np.linalg.norm(offset))
        found.append(np.arctan2(offset[1], -offset[2]))
    expected = swing(0.5, start, np.arange(1, 51) * STEP)
    assert np.array(found) == pytest.approx(expected, abs=0.01 * np.ptp(expected))
    assert np.array(lengths) == pytest.approx(0.5, abs=2e-4)


def test_a_rope_is_slack_until_it_is_taut():
    stage = new_stage()
    weight = ball(stage, "/World/weight", (0, 0, 2))
    tie(stage, "/World/rope", "", "/World/weight", (0, 0, 2), (0, 0, 0), most=0.5)
    engine = playing(stage)
    for _ in range(12):
        engine.step(STEP)
    assert position(weight)[2] == pytest.approx(2 - G * 0.2**2 / 2, abs=0.02)
    for _ in range(48):
        engine.step(STEP)
    assert position(weight) == pytest.approx([0, 0, 1.5], abs=1e-4)
    assert velocity(weight) == pytest.approx([0, 0, 0], abs=1e-3)


def test_a_strut_keeps_things_apart():
    stage = new_stage()
    weight = ball(stage, "/World/weight", (0, 0, 2.4))
    tie(stage, "/World/strut", "", "/World/weight", (0, 0, 2), (0, 0, 0), least=0.3)
    rail = joint(stage, "/World/rail", UsdPhysics.PrismaticJoint, "", "/World/weight", (0, 0, 2.4), axis="Z")
    assert rail
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    assert position(weight) == pytest.approx([0, 0, 2.3], abs=1e-4)


@pytest.mark.parametrize("meters", [1.0, 0.01])
def test_a_spring_carries_a_weight_and_swings_at_its_rate(meters):
    """ω² = k/m around the place where the spring carries the weight; below its length it does nothing."""
    stage, unit = new_stage(meters_per_unit=meters), 1.0 / meters
    mass, stiffness = 2.0, 200.0
    weight = ball(stage, "/World/weight", (0, 0, 2 * unit), mass=mass)
    UsdGeom.Xformable(weight).GetOrderedXformOps()[-1].Set(Gf.Vec3f(0.05 * unit))
    tie(stage, "/World/spring", "", "/World/weight", (0, 0, 2.5 * unit), (0, 0, 0), most=0.5 * unit,
        spring=(stiffness, 0.0))  # fmt: skip
    engine = playing(stage)
    found = []
    for _ in range(60):
        engine.step(STEP)
        found.append(position(weight)[2] * meters)
    rate, sag = np.sqrt(stiffness / mass), mass * G / stiffness
    times = np.arange(1, 61) * STEP + 1 / 480
    assert np.array(found) == pytest.approx(2 - sag * (1 - np.cos(rate * times)), abs=0.02 * sag)


def test_a_spring_that_is_stiffer_than_the_steps_does_not_explode():
    stage = new_stage()
    weight = ball(stage, "/World/weight", (0, 0, 2), mass=0.1)
    tie(stage, "/World/spring", "", "/World/weight", (0, 0, 2.5), (0, 0, 0), most=0.5, spring=(1e7, 1e3))
    engine = playing(stage)
    for _ in range(120):
        engine.step(STEP)
    assert position(weight) == pytest.approx([0, 0, 2], abs=2e-3)


def test_a_chain_of_ropes_hangs_between_a_kinematic_body_and_a_link(recwarn):
    """Four balls, each 10 cm from the next; the last one pulls the lower end of an arm."""
    stage = new_stage()
    hook = ball(stage, "/World/hook", (0, 0, 3))
    UsdPhysics.RigidBodyAPI(hook).CreateKinematicEnabledAttr(True)
    arm = rod(stage, "/World/arm", (0.5, 0, 2.0), (0.5, 0, 3.0))
    joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/arm", (0.5, 0, 3.0), axis="Y")
    names = ["/World/hook", *(f"/World/ball_{i}" for i in range(4)), "/World/arm"]
    for i, path in enumerate(names[1:-1]):
        ball(stage, path, (0.1 * (i + 1), 0, 3), mass=0.2)
    for i, (first, second) in enumerate(pairwise(names)):
        last = second == "/World/arm"
        # The arm's lower end, in its scaled frame, is at (0.5, 0, 2).
        tie(stage, f"/World/rope_{i}", first, second, (0, 0, 0), (0, 0, -1 if last else 0), most=0.7 if last else 0.1)
    engine = playing(stage)
    for _ in range(300):
        engine.step(STEP)
    at = [position(stage.GetPrimAtPath(path)) for path in names[:-1]]
    low = 2 * position(arm) - (0.5, 0, 3.0)
    assert [np.linalg.norm(b - a) for a, b in zip(at, [*at[1:], low])] == pytest.approx([*[0.1] * 4, 0.7], abs=2e-3)
    assert np.linalg.norm(position(arm) - (0.5, 0, 3.0)) == pytest.approx(0.5, abs=1e-5)
    assert not recwarn


def test_a_rope_that_is_pulled_slowly_takes_along_what_rests():
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False)
    box = add(stage, "/World/box", at=(1, 0, 0.1))
    hand = ball(stage, "/World/hand", (0.5, 0, 0.1))
    UsdPhysics.RigidBodyAPI(hand).CreateKinematicEnabledAttr(True)
    tie(stage, "/World/rope", "/World/hand", "/World/box", (0, 0, 0), (0, 0, 0), most=0.5)
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    assert position(box)[0] == pytest.approx(1.0, abs=1e-5)
    translate = UsdGeom.Xformable(hand).GetOrderedXformOps()[0]
    for step in range(60):
        translate.Set(Gf.Vec3d(0.5 - 0.01 * (step + 1) / 60, 0, 0.1))  # 1 cm/s
        engine.step(STEP)
    assert position(box)[0] == pytest.approx(0.99, abs=2e-4)


@pytest.mark.parametrize("spring", [None, (5000.0, 10.0)])
@pytest.mark.parametrize(("force", "breaks"), [(25.0, False), (15.0, True)])
def test_a_rope_breaks_under_more_than_its_force(force, breaks, spring):
    """A weight of 2 kg, 19.6 N."""
    stage = new_stage()
    weight = ball(stage, "/World/weight", (0, 0, 2), mass=2.0)
    made = tie(stage, "/World/rope", "", "/World/weight", (0, 0, 2.5), (0, 0, 0), most=0.496 if spring else 0.5,
               spring=spring)  # fmt: skip
    made.CreateBreakForceAttr(force)
    engine = playing(stage)
    for _ in range(30):
        engine.step(STEP)
    fallen = 2 - position(weight)[2]
    assert fallen == pytest.approx(G / 8 if breaks else 0.0, abs=0.1 if breaks else 2e-3)


def test_both_ends_move_by_their_masses():
    """Two balls that fly apart on a slack rope: when it is taut they go on together, with their momentum."""
    stage = new_stage()
    light = ball(stage, "/World/light", (0, 0, 1), mass=1.0, gravity=False)
    heavy = ball(stage, "/World/heavy", (0.3, 0, 1), mass=3.0, gravity=False)
    UsdPhysics.RigidBodyAPI(light).CreateVelocityAttr(Gf.Vec3f(-2, 0, 0))
    tie(stage, "/World/rope", "/World/light", "/World/heavy", (0, 0, 0), (0, 0, 0), most=0.5)
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    assert velocity(light) == pytest.approx([-0.5, 0, 0], abs=1e-3)
    assert velocity(heavy) == pytest.approx([-0.5, 0, 0], abs=1e-3)
    assert position(heavy)[0] - position(light)[0] == pytest.approx(0.5, abs=1e-3)


def test_a_rope_that_is_made_shorter_while_playing_lifts_its_weight():
    stage = new_stage()
    weight = ball(stage, "/World/weight", (0, 0, 1.5))
    made = tie(stage, "/World/rope", "", "/World/weight", (0, 0, 2), (0, 0, 0), most=0.5)
    engine = playing(stage)
    for step in range(60):
        if step % 15 == 0:
            made.GetMaxDistanceAttr().Set(0.49 - 0.01 * step / 15)
        engine.step(STEP)
    assert position(weight) == pytest.approx([0, 0, 1.54], abs=1e-3)


def test_a_d6_joint_that_limits_its_distance_is_a_rope():
    stage = new_stage()
    bob = ball(stage, "/World/bob", (0, 0.5, 2))
    prim = joint(stage, "/World/rope", UsdPhysics.Joint, "", "/World/bob", (0, 0.5, 2)).GetPrim()
    UsdPhysics.Joint(prim).CreateLocalPos0Attr(Gf.Vec3f(0, 0, 2))
    limit = UsdPhysics.LimitAPI.Apply(prim, "distance")
    limit.CreateLowAttr(-1.0)
    limit.CreateHighAttr(0.5)
    engine = playing(stage)
    for _ in range(30):
        engine.step(STEP)
    assert position(bob)[2] < 1.9
    assert np.linalg.norm(position(bob) - (0, 0, 2)) == pytest.approx(0.5, abs=2e-3)


def test_a_distance_limit_beside_others_is_named(recwarn):
    stage = new_stage()
    ball(stage, "/World/bob", (0, 0.5, 2))
    prim = joint(stage, "/World/rope", UsdPhysics.Joint, "", "/World/bob", (0, 0.5, 2)).GetPrim()
    UsdPhysics.LimitAPI.Apply(prim, "distance").CreateHighAttr(0.5)
    UsdPhysics.LimitAPI.Apply(prim, "transX").CreateHighAttr(0.5)
    playing(stage).step(STEP)
    assert any("/World/rope: limit:distance has no effect beside" in str(each.message) for each in recwarn)
