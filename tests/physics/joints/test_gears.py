"""Gears and racks couple joints as in PhysX, whose signs and units ovphysx 0.7.0 gave."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Sdf, UsdPhysics

from tests.physics.mechanisms import drive, joint
from tests.physics.scenes import add, new_stage, playing, position
from tests.sampled_cases import crossed

STEP = 1.0 / 60.0


def wheel(stage, name: str, y: float, kind: type = UsdPhysics.RevoluteJoint, axis: str = "X"):
    """A body on a joint to the world."""
    path = f"/World/{name}"
    add(stage, path, at=(0, y, 1), scale=(0.02, 0.1, 0.1), gravity=False)
    return joint(stage, f"{path}_joint", kind, "", path, (0, y, 1), axis=axis)


def gear(stage, path: str, first: str, second: str, ratio: float, *, rack: bool = False):
    prim = stage.DefinePrim(path, "PhysxPhysicsRackAndPinionJoint" if rack else "PhysxPhysicsGearJoint")
    names = ("hinge", "prismatic", "ratio") if rack else ("hinge0", "hinge1", "gearRatio")
    for end, name in enumerate((first, second)):
        prim.CreateRelationship(f"physics:body{end}", custom=False).SetTargets([f"/World/{name}"])
        prim.CreateRelationship(f"physics:{names[end]}", custom=False).SetTargets([f"/World/{name}_joint"])
    prim.CreateAttribute(f"physics:{names[2]}", Sdf.ValueTypeNames.Float).Set(ratio)
    return prim


@pytest.mark.parametrize(("ratio", "expected"), [(1.0, -30.0), (2.0, -60.0), (-0.5, 15.0)])
def test_a_gear_turns_the_other_way_by_its_ratio(ratio, expected, recwarn):
    stage = new_stage()
    drive(wheel(stage, "first", 0.0), "angular", damping=100.0, target_velocity=30.0)
    wheel(stage, "second", 0.3)
    gear(stage, "/World/gear", "first", "second", ratio)
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    joints = ["/World/first_joint", "/World/second_joint"]
    assert np.degrees(engine.joint_velocities(joints)) == pytest.approx([30.0, expected], rel=1e-3)
    assert np.degrees(engine.joint_positions(joints)) == pytest.approx([30.0, expected], rel=1e-2)
    assert not recwarn


@pytest.mark.parametrize("meters", [1.0, 0.01])
def test_a_rack_slides_by_the_degrees_over_its_ratio(meters):
    stage, unit = new_stage(meters_per_unit=meters), 1.0 / meters
    for name, y in (("pinion", 0.0), ("rack", 0.3 * unit)):
        add(stage, f"/World/{name}", at=(0, y, unit), scale=(0.02 * unit, 0.1 * unit, 0.1 * unit), gravity=False)
    turn = joint(stage, "/World/pinion_joint", UsdPhysics.RevoluteJoint, "", "/World/pinion", (0, 0, unit))
    joint(stage, "/World/rack_joint", UsdPhysics.PrismaticJoint, "", "/World/rack", (0, 0.3 * unit, unit), axis="Y")
    drive(turn, "angular", damping=100.0 * unit**2, target_velocity=30.0)
    gear(stage, "/World/mesh", "pinion", "rack", 100.0 * meters, rack=True)
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    assert position(stage.GetPrimAtPath("/World/rack"))[1] * meters == pytest.approx(0.3 + 0.3, rel=1e-2)


def test_a_train_of_gears_carries_its_load_to_the_drive():
    """The inertia that a torque of 1 N m accelerates is the sum of all, each times its ratio squared."""
    stage = new_stage()
    for number in range(3):
        wheel(stage, f"wheel_{number}", 0.3 * number)
        UsdPhysics.MassAPI.Apply(stage.GetPrimAtPath(f"/World/wheel_{number}")).CreateMassAttr(1.0)
    # The second pair is authored before the first, and its wheels the other way round.
    gear(stage, "/World/b", "wheel_2", "wheel_1", 0.5)
    gear(stage, "/World/a", "wheel_0", "wheel_1", 3.0)
    engine = playing(stage)
    for _ in range(30):
        engine.apply_joint_efforts(["/World/wheel_0_joint"], [1.0])
        engine.step(STEP)
    inertia = (0.2**2 + 0.2**2) / 12
    speed = 0.5 / (inertia * (1 + 3**2 + 6**2))
    found = engine.joint_velocities([f"/World/wheel_{number}_joint" for number in range(3)])
    assert found == pytest.approx(np.array([1.0, -3.0, 6.0]) * speed, rel=0.01)


def test_gears_keep_the_angles_that_they_start_with():
    stage = new_stage()
    second = wheel(stage, "second", 0.3)
    drive(wheel(stage, "first", 0.0), "angular", damping=100.0, target_velocity=0.0)
    prim = second.GetPrim()
    prim.AddAppliedSchema("PhysicsJointStateAPI:angular")
    prim.CreateAttribute("state:angular:physics:position", Sdf.ValueTypeNames.Float, custom=False).Set(25.0)
    gear(stage, "/World/gear", "first", "second", 1.0)
    engine = playing(stage)
    for _ in range(10):
        engine.step(STEP)
    assert np.degrees(engine.joint_positions(["/World/first_joint", "/World/second_joint"])) == pytest.approx(
        [0.0, 25.0], abs=1e-3
    )


def test_a_gear_that_couples_nothing_is_named(recwarn):
    stage = new_stage()
    wheel(stage, "first", 0.0)
    gear(stage, "/World/gear", "first", "missing", 1.0)
    engine = playing(stage)
    engine.step(STEP)
    assert any("/World/gear couples no two joints" in str(warning.message) for warning in recwarn)


def test_a_gear_that_is_disabled_lets_go():
    stage = new_stage()
    drive(wheel(stage, "first", 0.0), "angular", damping=100.0, target_velocity=30.0)
    wheel(stage, "second", 0.3)
    prim = gear(stage, "/World/gear", "first", "second", 1.0)
    enabled = prim.CreateAttribute("physics:jointEnabled", Sdf.ValueTypeNames.Bool)
    enabled.Set(False)
    engine = playing(stage)
    for _ in range(30):
        engine.step(STEP)
    assert engine.joint_velocities(["/World/second_joint"]) == pytest.approx([0.0], abs=1e-6)
    enabled.Set(True)
    for _ in range(30):
        engine.step(STEP)
    assert np.degrees(engine.joint_velocities(["/World/second_joint"])) == pytest.approx([-30.0], rel=0.01)


def test_a_gear_that_is_removed_while_playing_lets_go():
    stage = new_stage()
    api = drive(wheel(stage, "first", 0.0), "angular", damping=100.0, target_velocity=30.0)
    wheel(stage, "second", 0.3)
    gear(stage, "/World/gear", "first", "second", 1.0)
    engine, second = playing(stage), ["/World/second_joint"]
    engine.advance(0.5)
    stage.RemovePrim("/World/gear")
    api.GetTargetVelocityAttr().Set(0.0)
    engine.advance(0.5)
    assert np.degrees(engine.joint_velocities(second)) == pytest.approx([-30.0], abs=1.0)
    assert np.degrees(engine.joint_velocities(["/World/first_joint"])) == pytest.approx([0.0], abs=0.1)


@pytest.mark.parametrize(
    ("side", "axes", "swapped"), crossed([1.0, -1.0], ["XY", "YX", "ZX", "XZ"], [(), ("pinion",), ("rack",)])
)
def test_a_rack_goes_where_the_rim_of_its_pinion_goes(axes, side, swapped):
    """PhysX drives it along axis x (rack - pinion), whichever end of a joint the body is."""
    axis, slide = (np.eye(3)["XYZ".index(letter)] for letter in axes)
    offset = 0.3 * side * np.cross(axis, slide)
    stage = new_stage()
    for name, at, kind, letter in (
        ("pinion", np.zeros(3), UsdPhysics.RevoluteJoint, axes[0]),
        ("rack", offset, UsdPhysics.PrismaticJoint, axes[1]),
    ):
        add(stage, f"/World/{name}", at=tuple(at), scale=(0.05,) * 3, gravity=False)
        ends = (f"/World/{name}", "") if name in swapped else ("", f"/World/{name}")
        made = joint(stage, f"/World/{name}_joint", kind, *ends, tuple(at), axis=letter)
        if name == "pinion":
            drive(made, "angular", damping=100.0, target_velocity=-30.0 if name in swapped else 30.0)
    gear(stage, "/World/mesh", "pinion", "rack", 100.0, rack=True)
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    moved = position(stage.GetPrimAtPath("/World/rack")) - offset
    rim = np.cross(axis, offset)
    assert moved == pytest.approx(0.3 * rim / np.linalg.norm(rim), abs=5e-3)


@pytest.mark.parametrize("swapped", ["first", "second"])
def test_gears_turn_their_bodies_against_each_other(swapped):
    """Also where the body of a hinge is its first end, as in PhysX."""
    stage = new_stage()
    for name, y in (("first", 0.0), ("second", 0.3)):
        made = wheel(stage, name, y)
        if name == swapped:
            stage.RemovePrim(made.GetPath())
            made = joint(stage, f"/World/{name}_joint", UsdPhysics.RevoluteJoint, f"/World/{name}", "", (0, y, 1))
        if name == "first":
            drive(made, "angular", damping=100.0, target_velocity=-30.0 if name == swapped else 30.0)
    gear(stage, "/World/gear", "first", "second", 2.0)
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    turning = np.degrees(engine.velocities(["/World/first", "/World/second"])[:, 3])
    assert turning == pytest.approx([30.0, -60.0], rel=1e-2)


@pytest.mark.parametrize("collides", [False, True])
def test_bodies_in_gear_do_not_collide(collides):
    """As those of other joints: overlapping wheels turn freely unless `collisionEnabled` is authored."""
    stage = new_stage()
    drive(wheel(stage, "first", 0.0), "angular", damping=100.0, target_velocity=30.0)
    wheel(stage, "second", 0.15)
    gear(stage, "/World/gear", "first", "second", 1.0).CreateAttribute(
        "physics:collisionEnabled", Sdf.ValueTypeNames.Bool
    ).Set(collides)
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    turned = np.degrees(engine.joint_positions(["/World/first_joint"]))[0]
    assert (turned == pytest.approx(30.0, rel=0.02)) != collides
