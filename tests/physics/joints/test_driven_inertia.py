"""Drives of accelerations, their highest forces, and velocities that a joint keeps while other prims change."""

import numpy as np
import pytest
from pxr import Gf, UsdPhysics

from tests.physics.mechanisms import drive, free_axes, joint
from tests.physics.scenes import add, new_stage, playing, position

STEP = 1 / 60


def _turntable(stage, paths, out):
    """A cube that turns about Z by a drive, and another that slides from its middle along X to `out`."""
    for path, mass in zip(paths, (1.0, 2.0)):
        UsdPhysics.MassAPI.Apply(add(stage, path, gravity=False)).CreateMassAttr(mass)
    turn = joint(stage, "/World/turn", UsdPhysics.RevoluteJoint, "", paths[0], (0, 0, 0), axis="Z")
    slide = joint(stage, "/World/slide", UsdPhysics.PrismaticJoint, *paths, (0, 0, 0), axis="X")
    drive(slide, "linear", stiffness=1e5, damping=1e4, target=out)
    drive(turn, "angular", stiffness=0.4, damping=0.1, target=10.0, kind="acceleration")


@pytest.mark.parametrize("out", [0.0, 1.0])
def test_an_acceleration_drive_follows_the_inertia_that_it_moves(out):
    """The same curve where the slide is out, with 60 times the inertia; it was slower by as much."""
    stage, paths = new_stage(), ("/World/table", "/World/weight")
    _turntable(stage, paths, out)
    engine = playing(stage)
    engine.set_joint_state(["/World/slide"], [out])
    found = []
    for _ in range(60):
        engine.step(STEP)
        found.append(np.degrees(engine.joint_positions(["/World/turn"])[0]))
    assert engine.joint_positions(["/World/slide"]) == pytest.approx([out], abs=1e-3)
    stiffness, damping = np.degrees(0.4), np.degrees(0.1)
    times = np.arange(1, 61) * STEP + 1 / 480
    rate = np.sqrt(stiffness - damping**2 / 4)
    swing = np.cos(rate * times) + damping / 2 / rate * np.sin(rate * times)
    assert found == pytest.approx(10 * (1 - np.exp(-damping / 2 * times) * swing), abs=0.15)


@pytest.mark.parametrize("free", [("rotY", "rotZ"), ("rotX", "rotZ"), ("transX", "rotZ"), ("transX", "rotY", "rotZ")])
def test_joints_of_several_axes_go_on_where_something_is_added(free):
    """Their velocities were measured about the axes at the start, and turned into others."""
    runs = []
    for adds in (False, True):
        stage = new_stage()
        body = add(stage, "/World/body", at=(0.4, 0.1, 0), scale=(0.2, 0.1, 0.05), gravity=False)
        api = UsdPhysics.RigidBodyAPI(body)
        api.CreateVelocityAttr(Gf.Vec3f(0.3, 0.5, -0.8))
        api.CreateAngularVelocityAttr(Gf.Vec3f(40, 100, 150))
        free_axes(joint(stage, "/World/joint", UsdPhysics.Joint, "", "/World/body", (0, 0, 0)), *free)
        engine = playing(stage)
        path = []
        for step in range(40):
            if adds and step == 20:
                add(stage, "/World/other", at=(0, 0, 50), gravity=False)
                joint(stage, "/World/hinge", UsdPhysics.RevoluteJoint, "", "/World/other", (0, 0.1, 50))
            engine.step(STEP)
            path.append(position(body))
        runs.append(path)
    assert np.linalg.norm(np.array(runs[0][20]) - (0.4, 0.1, 0)) > 0.1
    assert np.array(runs[1]) == pytest.approx(np.array(runs[0]), abs=1e-4)


@pytest.mark.parametrize("meters", [1.0, 0.01])
@pytest.mark.parametrize("kind", ["force", "acceleration"])
def test_the_highest_force_of_a_drive_is_a_force(kind, meters):
    """Of acceleration drives too, as in PhysX: ovphysx 0.7.0 has 2 m/s and 0.3 rad/s after a second."""
    stage, unit = new_stage(meters_per_unit=meters), 1.0 / meters
    paths = ("/World/slides", "/World/turns")
    for path, y in zip(paths, (0.0, 3.0 * unit)):
        body = add(stage, path, at=(0, y, 0), scale=(0.1 * unit,) * 3, gravity=False)
        UsdPhysics.MassAPI.Apply(body).CreateMassAttr(2.0)
    slide = joint(stage, "/World/slide", UsdPhysics.PrismaticJoint, "", paths[0], (0, 0, 0), axis="X")
    turn = joint(stage, "/World/turn", UsdPhysics.RevoluteJoint, "", paths[1], (0, 3.0 * unit, 0), axis="X")
    strength = {"stiffness": 1e6, "damping": 1e3, "kind": kind}
    drive(slide, "linear", target=10.0 * unit, max_force=4.0 * unit, **strength)
    drive(turn, "angular", target=100.0, max_force=0.004 * unit**2, **strength)
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    inertia = 2.0 * 0.2**2 / 6
    assert engine.velocities(paths)[0, 0] * meters == pytest.approx(4.0 / 2.0, rel=1e-3)
    assert engine.velocities(paths)[1, 3] == pytest.approx(0.004 / inertia, rel=1e-3)
