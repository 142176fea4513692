"""Loops of joints against closed forms, whichever joint of them closes the loop."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Sdf, UsdPhysics

from tests.physics.mechanisms import drive, free_axes, joint, limit, rod, rotation
from tests.physics.scenes import add, new_stage, playing, position

G, STEP = 9.81, 1.0 / 60.0


def plate(stage, name: str, at, *, mass: float = 2.0, joints=()) -> None:
    """A box of some mass on rails along z at either side of it."""
    UsdPhysics.MassAPI.Apply(add(stage, f"/World/{name}", at=at)).CreateMassAttr(mass)


@pytest.mark.parametrize("driven", ["left", "right"])
def test_a_plate_on_two_rails_is_carried_by_the_drive_of_either(driven, recwarn):
    stage = new_stage()
    plate(stage, "plate", (0, 0, 1))
    for name, y in (("left", 0.1), ("right", -0.1)):
        made = joint(stage, f"/World/{name}", UsdPhysics.PrismaticJoint, "", "/World/plate", (0, y, 1), axis="Z")
        if name == driven:
            limit(made, -0.5, 0.5)
            drive(made, "linear", stiffness=1000.0, damping=100.0, target=0.2)
    engine = playing(stage)
    for _ in range(90):
        engine.step(STEP)
    lifted = 0.2 - 2.0 * G / 1000
    assert position(stage.GetPrimAtPath("/World/plate")) == pytest.approx([0, 0, 1 + lifted], abs=1e-4)
    assert engine.joint_positions(["/World/left", "/World/right"]) == pytest.approx([lifted] * 2, abs=1e-4)
    assert engine.rigid_bodies == ("/World/plate",)
    assert engine.mass_properties(["/World/plate"]).mass == pytest.approx([2.0])  # also where the loop is cut
    assert not recwarn


class FourBars:
    """Rods of 0.4, 0.6 and 0.5 m between two hinges that are 0.7 m apart, and the equation of their only coordinate."""

    LENGTHS, BASE = (0.4, 0.6, 0.5), 0.7

    def corners(self, angle: float) -> np.ndarray:
        """The ends (4, 2) of the rods in y, z; `angle` is that of the first below the horizontal."""
        a, b, c = self.LENGTHS
        first, last = np.array([0.0, 2.0]), np.array([self.BASE, 2.0])
        second = first + a * np.array([np.cos(angle), -np.sin(angle)])
        to_last = last - second
        distance = np.linalg.norm(to_last)
        turn = np.arctan2(to_last[1], to_last[0]) - np.arccos((b**2 + distance**2 - c**2) / (2 * b * distance))
        return np.array([first, second, second + b * np.array([np.cos(turn), np.sin(turn)]), last])

    def swing(self, angle: float, times: np.ndarray) -> np.ndarray:
        """Angles at times, from rest, by Lagrange's equation for the energy as a function of the angle."""

        def centers_and_turns(q: float) -> np.ndarray:
            corners = self.corners(q)
            along = np.diff(corners, axis=0)
            return np.hstack([(corners[1:] + corners[:-1]) / 2, np.arctan2(along[:, 1], along[:, 0])[:, None]])

        def inertia(q: float) -> float:
            slopes = (centers_and_turns(q + 1e-5) - centers_and_turns(q - 1e-5)) / 2e-5
            about = (np.array(self.LENGTHS) ** 2 + 0.04**2) / 12
            return float((slopes[:, :2] ** 2).sum() + (about * slopes[:, 2] ** 2).sum())

        def rate(y: np.ndarray) -> np.ndarray:
            q, v = y
            pull = -G * (centers_and_turns(q + 1e-5) - centers_and_turns(q - 1e-5))[:, 1].sum() / 2e-5
            change = (inertia(q + 1e-4) - inertia(q - 1e-4)) / 2e-4
            return np.array([v, (pull - 0.5 * change * v**2) / inertia(q)])

        y, t, h, found = np.array([angle, 0.0]), 0.0, 1e-3, []
        for time in times:
            while t < time - 1e-9:
                step = min(h, time - t)
                k1 = rate(y)
                k2 = rate(y + step / 2 * k1)
                k3 = rate(y + step / 2 * k2)
                y, t = y + step / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + step * k3)), t + step
            found.append(y[0])
        return np.array(found)


def four_bars(stage, start: float) -> list:
    corners = [np.array([0.0, *corner]) for corner in FourBars().corners(start)]
    names = ("", "first", "middle", "last", "")
    rods = [rod(stage, f"/World/{names[i + 1]}", corners[i], corners[i + 1]) for i in range(3)]
    for number, at in enumerate(corners):
        above, below = (f"/World/{name}" if name else "" for name in names[number : number + 2])
        joint(stage, f"/World/hinge_{number}", UsdPhysics.RevoluteJoint, above, below, at.tolist())
    return rods


def test_four_bars_swing_as_their_equation_says():
    """PhysX (ovphysx 0.7.0) is 2 mrad off at 60 steps per second, and 0.5 mrad at 240."""
    stage, start = new_stage(), 0.6
    first = four_bars(stage, start)[0]
    engine = playing(stage)
    found = []
    for _ in range(90):
        engine.step(STEP)
        y, z = position(first)[1:] - (0, 2)
        found.append(np.arctan2(-z, y))
    expected = FourBars().swing(start, np.arange(1, 91) * STEP + 1 / 480)
    assert np.array(found) == pytest.approx(expected, abs=0.002 * np.ptp(expected))


def test_drives_of_all_hinges_of_a_loop_carry_its_weight():
    """They come to rest where the energy of weight and springs is least; one of the hinges closes the loop."""
    stage, start, stiffness = new_stage(), 0.6, 0.1
    first = four_bars(stage, start)[0]
    for number in range(4):
        hinge = UsdPhysics.Joint(stage.GetPrimAtPath(f"/World/hinge_{number}"))
        drive(hinge, "angular", stiffness=stiffness, damping=stiffness / 10)
    engine = playing(stage)
    for _ in range(180):
        engine.step(STEP)
    y, z = position(first)[1:] - (0, 2)

    def energy(angle: float) -> float:
        turns, centers = [], []
        for q in (start, angle):
            corners = FourBars().corners(q)
            along = np.diff(corners, axis=0)
            turns.append(np.concatenate([[0.0], np.arctan2(along[:, 1], along[:, 0]), [0.0]]))
            centers.append((corners[1:] + corners[:-1]) / 2)
        bends = np.diff(turns[1] - turns[0])
        return G * centers[1][:, 1].sum() + 0.5 * np.degrees(stiffness) * (bends**2).sum()

    angles = np.linspace(start, start + 0.5, 5001)
    expected = angles[np.argmin([energy(angle) for angle in angles])]
    assert expected - start > 0.1
    assert np.arctan2(-z, y) == pytest.approx(expected, abs=1e-3)


def test_a_drawer_on_two_slides_opens_to_its_limit(recwarn):
    """Both slides connect the same two bodies, off the center of mass, as those of a cupboard do."""
    stage = new_stage()
    add(stage, "/World/cupboard", at=(0, 0, 0.5), scale=(0.25, 0.25, 0.5), body=False)
    drawer = add(stage, "/World/drawer", at=(0, 0, 0.6), scale=(0.24, 0.2, 0.08))
    UsdPhysics.MassAPI.Apply(drawer).CreateMassAttr(4.0)
    for side in (-1, 1):
        path = f"/World/slide_{'left' if side < 0 else 'right'}"
        at = (0, side * 0.2, 0.55)
        limit(joint(stage, path, UsdPhysics.PrismaticJoint, "/World/cupboard", "/World/drawer", at), 0.0, 0.4)
    engine = playing(stage)
    for _ in range(30):
        engine.apply_joint_efforts(["/World/slide_left"], [2.0])
        engine.step(STEP)
    # The velocity leads by half of the solver's step.
    assert engine.joint_velocities(["/World/slide_right"]) == pytest.approx([2.0 / 4.0 * 0.5], rel=1e-3)
    for _ in range(120):
        engine.step(STEP)
    assert position(drawer) == pytest.approx([0.4, 0, 0.6], abs=5e-4)
    assert not recwarn


def test_a_loop_that_floats_falls_like_anything_else():
    """Four boxes in a ring, each on a slide to the next: none of the joints can close the loop without being cut."""
    stage = new_stage()
    corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    boxes = [add(stage, f"/World/box_{i}", at=(*corner, 5)) for i, corner in enumerate(corners)]
    for number in range(4):
        made = joint(
            stage, f"/World/joint_{number}", UsdPhysics.Joint, f"/World/box_{number}",
            f"/World/box_{(number + 1) % 4}", (*corners[number], 5),
        )  # fmt: skip
        free_axes(made, transX=(-0.1, 0.1), transY=(-0.1, 0.1))
    UsdPhysics.RigidBodyAPI(boxes[0]).CreateVelocityAttr((2.0, 0.0, 0.0))
    engine = playing(stage)
    for _ in range(30):
        engine.step(STEP)
    centers = np.array([position(box) for box in boxes])
    assert centers.mean(axis=0) == pytest.approx([0.5 + 0.25, 0.5, 5 - G / 8], abs=0.025)
    assert np.ptp(centers[:, 2]) < 1e-3
    turned = [rotation(box) for box in boxes]
    assert np.ptp(turned, axis=0) == pytest.approx(np.zeros((3, 3)), abs=1e-3)
    gaps = [turned[i] @ (centers[(i + 1) % 4] - centers[i]) for i in range(4)]
    authored = [np.subtract((*corners[(i + 1) % 4], 0), (*corners[i], 0)) for i in range(4)]
    assert np.abs(np.subtract(gaps, authored)).max() < 0.1 + 1e-3


@pytest.mark.parametrize(("force", "breaks"), [(25.0, False), (4.0, True)])
def test_joints_of_a_loop_break(force, breaks):
    """A weight of 19.6 N below two fixed joints, of which one closes a loop."""
    stage = new_stage()
    plate(stage, "plate", (0, 0, 2))
    beam = add(stage, "/World/beam", at=(0, 0, 3))
    UsdPhysics.RigidBodyAPI(beam).CreateKinematicEnabledAttr(True)
    for name, y in (("left", 0.1), ("right", -0.1)):
        made = joint(stage, f"/World/{name}", UsdPhysics.FixedJoint, "/World/beam", "/World/plate", (0, y, 2.5))
        made.CreateBreakForceAttr(force)
    engine = playing(stage)
    for _ in range(30):
        engine.step(STEP)
    fallen = 2 - position(stage.GetPrimAtPath("/World/plate"))[2]
    assert fallen == pytest.approx(G / 8 if breaks else 0.0, abs=0.2 if breaks else 1e-4)


def test_the_second_hinge_of_a_door_rubs_too():
    """Two hinges of 1 N m each hold against 1.5, and not against 2.5."""
    stage = new_stage()
    for number in range(2):
        path = f"/World/door_{number}"
        UsdPhysics.MassAPI.Apply(add(stage, path, at=(0.4, 2 * number, 1), scale=(0.4, 0.02, 0.9))).CreateMassAttr(10.0)
        UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath(path))
        for name, z in (("top", 1.7), ("bottom", 0.3)):
            made = joint(
                stage, f"/World/{name}_{number}", UsdPhysics.RevoluteJoint, "", path, (0, 2 * number, z), axis="Z"
            )
            made.GetPrim().AddAppliedSchema("PhysxJointAxisAPI:angular")
            attribute = "physxJointAxis:angular:staticFrictionEffort"
            made.GetPrim().CreateAttribute(attribute, Sdf.ValueTypeNames.Float).Set(1.0)
    engine = playing(stage)
    for _ in range(30):
        engine.apply_joint_efforts(["/World/top_0", "/World/top_1"], [1.5, 2.5])
        engine.step(STEP)
    inertia = 10.0 * (0.4**2 + (0.8**2 + 0.04**2) / 12)
    assert engine.joint_velocities(["/World/top_0", "/World/top_1"]) == pytest.approx(
        [0.0, 0.5 * 0.5 / inertia], abs=2e-3
    )
