"""A seven-joint arm with a gripper: holds its pose under drives, reaches targets, and carries a cube."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import UsdPhysics

from tests.physics.mechanisms import drive, joint, limit, rotation
from tests.physics.scenes import add, new_stage, playing, position

STEP = 1.0 / 60.0
AXES, LINK = "ZYZYZYZ", 0.15
BASE = 0.05  # of the base's bottom, above the ground
# Of the joints about y, whose sum is 180 degrees where the gripper points down: with the cube between its fingers, and
# straight above that by 40, 80 and 120 mm.
HEIGHTS = (0.0, 0.04, 0.08, 0.12)


class Arm:
    """The arm stands upright at the origin, with links of 15 cm and fingers that slide along y."""

    def __init__(self) -> None:
        self.stage = new_stage()
        add(self.stage, "/World/ground", at=(0, 0, -0.5), scale=(2, 2, 0.5), body=False)
        self._box("base", (0, 0, BASE + 0.05), (0.06, 0.06, 0.05), 5.0)
        UsdPhysics.ArticulationRootAPI.Apply(self.stage.GetPrimAtPath("/World/base"))
        joint(self.stage, "/World/fix", UsdPhysics.FixedJoint, "", "/World/base", (0, 0, BASE))
        self.drives, z, below = [], BASE + 0.1, "/World/base"
        for number, axis in enumerate(AXES):
            link = self._box(f"link_{number}", (0, 0, z + LINK / 2), (0.03, 0.03, LINK / 2), 1.0 - 0.1 * number)
            made = joint(
                self.stage, f"/World/joint_{number}", UsdPhysics.RevoluteJoint, below, link, (0, 0, z), axis=axis
            )
            limit(made, -160.0, 160.0)
            self.drives.append(drive(made, "angular", stiffness=500.0, damping=50.0, max_force=200.0))
            below, z = link, z + LINK
        self.hand = self._box("hand", (0, 0, z + 0.02), (0.03, 0.08, 0.02), 0.3)
        joint(self.stage, "/World/wrist", UsdPhysics.FixedJoint, below, self.hand, (0, 0, z))
        self.fingers = []
        for name, side in (("left", 1), ("right", -1)):
            finger = self._box(name, (0, side * 0.05, z + 0.08), (0.015, 0.01, 0.04), 0.1)
            path = f"/World/{name}_slide"
            made = joint(
                self.stage, path, UsdPhysics.PrismaticJoint, self.hand, finger, (0, side * 0.05, z + 0.04), axis="Y"
            )
            limit(made, -0.05, 0.05)
            api = drive(made, "linear", stiffness=2000.0, damping=100.0, max_force=40.0)
            self.fingers.append((api, side))
        self.joints = [f"/World/joint_{number}" for number in range(7)]

    def _box(self, name: str, at, half, mass: float) -> str:
        prim = add(self.stage, f"/World/{name}", at=at, scale=half)
        UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(mass)
        return f"/World/{name}"

    def target(self, angles) -> None:
        for api, angle in zip(self.drives, angles):
            api.GetTargetPositionAttr().Set(float(angle))

    def grip(self, closed: float) -> None:
        for api, side in self.fingers:
            api.GetTargetPositionAttr().Set(-side * closed)

    def pose_of(self, path: str) -> tuple[np.ndarray, np.ndarray]:
        prim = self.stage.GetPrimAtPath(path)
        return position(prim), rotation(prim)


def above(height: float, *, at: float = 0.36) -> np.ndarray:
    """Angles [degrees] that point the gripper down with its fingertips at a height, by the law of cosines."""
    # From the second joint, at the height of base and first link, to the sixth, over two links of 0.3 m each.
    x, z = at, height + 0.01 + 4 * 0.04 - 0.04 + 2 * LINK - (BASE + 0.1 + LINK)
    reach = np.hypot(x, z)
    half = np.arccos(reach / 0.6)
    first = np.arctan2(x, z) - half
    return np.degrees(np.array([0, first, 0, 2 * half, 0, np.pi - first - 2 * half, 0]))


def run(engine, arm: Arm, start, end, steps: int) -> None:
    for step in range(steps):
        s = (step + 1) / steps
        arm.target(start + (end - start) * (3 * s**2 - 2 * s**3))
        engine.step(STEP)


def test_it_stands_as_authored_and_reaches_its_targets():
    arm = Arm()
    engine = playing(arm.stage)
    start = {path: arm.pose_of(path) for path in engine.rigid_bodies}
    for _ in range(60):
        engine.step(STEP)
    for path, (at, turned) in start.items():
        now = arm.pose_of(path)
        assert np.linalg.norm(now[0] - at) < 1e-3
        assert np.degrees(np.arccos(np.clip((np.trace(now[1] @ turned.T) - 1) / 2, -1, 1))) < 0.5
    target = np.array([10.0, 40.0, -20.0, 60.0, 30.0, 45.0, 10.0])
    arm.target(target)
    for _ in range(180):
        engine.step(STEP)
    # What a drive gives way to gravity is the torque over its stiffness of 500 N m per degree.
    assert np.degrees(engine.joint_positions(arm.joints)) == pytest.approx(target, abs=0.1)
    now = [arm.pose_of(path)[0] for path in start]
    for _ in range(60):
        engine.step(STEP)
    assert np.array([arm.pose_of(path)[0] for path in start]) == pytest.approx(np.array(now), abs=1e-6)


def test_it_grips_a_cube_and_carries_it():
    arm = Arm()
    cube = add(arm.stage, "/World/cube", at=(0.36, 0, 0.02), scale=(0.02, 0.02, 0.02))
    UsdPhysics.MassAPI.Apply(cube).CreateMassAttr(0.1)
    engine = playing(arm.stage)
    run(engine, arm, np.zeros(7), above(0.12), 90)
    run(engine, arm, above(0.12), above(0.0), 60)
    run(engine, arm, above(0.0), above(0.0), 30)
    assert position(cube) == pytest.approx([0.36, 0, 0.02], abs=1e-4)
    arm.grip(0.03)
    run(engine, arm, above(0.0), above(0.0), 60)

    def in_hand() -> tuple[np.ndarray, np.ndarray]:
        (at, axes), (center, turned) = arm.pose_of(arm.hand), arm.pose_of("/World/cube")
        return (center - at) @ axes.T, turned @ axes.T

    gripped = in_hand()
    for number in range(len(HEIGHTS) - 1):
        run(engine, arm, above(HEIGHTS[number]), above(HEIGHTS[number + 1]), 20)
    side = above(0.12) + np.array([60.0, 0, 0, 0, 0, 0, 30.0])
    run(engine, arm, above(0.12), side, 90)
    run(engine, arm, side, side, 90)
    radius = np.hypot(*position(cube)[:2])
    assert position(cube)[2] == pytest.approx(0.14, abs=2e-3)
    assert radius == pytest.approx(0.36, abs=2e-3)
    offset, turned = in_hand()
    assert np.linalg.norm(offset - gripped[0]) < 1e-3
    assert np.degrees(np.arccos(np.clip((np.trace(turned @ gripped[1].T) - 1) / 2, -1, 1))) < 0.5
    arm.grip(0.0)
    run(engine, arm, side, side, 60)
    assert position(cube)[2] == pytest.approx(0.02, abs=1e-3)
