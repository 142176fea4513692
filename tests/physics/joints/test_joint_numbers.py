"""Numbers of joints that contradict each other or that nothing has are named, with what counts in their place."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import UsdPhysics

from tests.physics.mechanisms import drive, free_axes, joint, limit, rotation
from tests.physics.scenes import add, new_stage, playing, position, warnings_of
from tests.sampled_cases import crossed


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        (UsdPhysics.RevoluteJoint, "the lower limit of rotX, 30 degrees, is above the upper one, -30, so the joint"),
        (UsdPhysics.PrismaticJoint, "the lower limit of transX, 30 units, is above the upper one, -30, so the joint"),
    ],
)
def test_limits_in_the_wrong_order_are_named(kind, text):
    stage = new_stage()
    add(stage, "/World/box")
    made = joint(stage, "/World/joint", kind, "", "/World/box", (0, 0, 0))
    limit(made, -30.0, 30.0)
    assert not warnings_of(stage)
    limit(made, 30.0, 30.0)
    assert not warnings_of(stage)
    limit(made, 30.0, -30.0)
    (message,) = warnings_of(stage)
    assert message.startswith(f"/World/joint: {text}")


def test_locked_axes_of_a_general_joint_are_not_named():
    stage = new_stage()
    add(stage, "/World/box")
    free_axes(joint(stage, "/World/joint", UsdPhysics.Joint, "", "/World/box", (0, 0, 0)), "rotX")
    assert not warnings_of(stage)


@pytest.mark.parametrize("gains", [{"stiffness": -5.0}, {"damping": -5.0}])
def test_drives_that_push_away_are_named(gains):
    stage = new_stage()
    add(stage, "/World/box")
    drive(joint(stage, "/World/joint", UsdPhysics.RevoluteJoint, "", "/World/box", (0, 0, 0)), "angular", **gains)
    (message,) = warnings_of(stage)
    (name,) = gains
    assert message == (
        f"/World/joint: drive:angular:physics:{name} is -5, so it counts as 0. Set a positive number, or 0."
    )


@pytest.mark.parametrize("name", ["stiffness", "damping", "target", "target_velocity"])
@pytest.mark.parametrize("number", [np.inf, -np.inf, np.nan])
def test_numbers_of_drives_that_are_not_finite_are_named(name, number):
    """An infinite stiffness let the drive go without a word."""
    stage = new_stage()
    add(stage, "/World/box")
    numbers = {"stiffness": 5.0, name: number}
    drive(joint(stage, "/World/joint", UsdPhysics.RevoluteJoint, "", "/World/box", (0, 0, 0)), "angular", **numbers)
    (message,) = warnings_of(stage)
    attribute = {"target": "targetPosition", "target_velocity": "targetVelocity"}.get(name, name)
    assert message.startswith(f"/World/joint: drive:angular:physics:{attribute} is {number:g}, so it counts as 0.")


def test_a_least_distance_above_the_greatest_is_named_and_counts():
    stage = new_stage()
    ball = add(stage, "/World/ball", "Sphere", at=(0, 0, -0.7))
    made = joint(stage, "/World/joint", UsdPhysics.DistanceJoint, "", "/World/ball", (0, 0, 0))
    made.CreateLocalPos1Attr((0, 0, 0))
    made.CreateMinDistanceAttr(0.5)
    made.CreateMaxDistanceAttr(0.3)
    (message,) = warnings_of(stage)
    assert message.startswith("/World/joint: physics:minDistance is 0.5, which is above physics:maxDistance, 0.3, so")
    playing(stage).advance(2.0)
    assert position(ball) == pytest.approx([0, 0, -0.5], abs=5e-3)


@pytest.mark.parametrize(("name", "number"), crossed(["transX", "transZ", "rotX", "rotY"], [0.3, -0.2, 0.0]))
def test_equal_limits_of_a_general_joint_hold_its_axis_at_their_number(name, number):
    """As in PhysX (ovphysx 0.7.0), which moves a box by 0.3 m, and turns one by 30 degrees."""
    stage = new_stage()
    box = add(stage, "/World/box", at=(2, 0, 1))
    made = joint(stage, "/World/joint", UsdPhysics.Joint, "", "/World/box", (2, 0, 1))
    end = 100.0 * number if name.startswith("rot") else number
    free_axes(made, **{name: (end, end)})
    assert not warnings_of(stage)
    playing(stage).advance(1.0)
    axis = np.eye(3)["XYZ".index(name[-1])]
    turned = np.array(rotation(box))
    if name.startswith("rot"):
        assert position(box) == pytest.approx([2, 0, 1], abs=1e-4)
        angle = np.radians(end)
        cross = np.cross(np.eye(3), axis)
        expected = np.eye(3) - np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
        assert turned == pytest.approx(expected, abs=1e-3)
    else:
        assert position(box) == pytest.approx([2, 0, 1] + number * axis, abs=1e-4)
        assert turned == pytest.approx(np.eye(3), abs=1e-4)
