"""Damping of bodies that joints hold, against the closed form of its steps."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdPhysics

from tests.physics.mechanisms import free_axes, joint
from tests.physics.scenes import add, new_stage, playing
from tests.sampled_cases import crossed

STEP, SECONDS = 1.0 / 60.0, 1.0


def damped_body(stage, path: str, *, linear: float = 0.0, angular: float = 0.0, **options):
    prim = add(stage, path, gravity=False, angular_damping=angular, **options)
    prim.CreateAttribute("physxRigidBody:linearDamping", Sdf.ValueTypeNames.Float).Set(linear)
    return prim


def velocities_after(stage, *paths: str) -> np.ndarray:
    engine = playing(stage)
    for _ in range(round(SECONDS / STEP)):
        engine.step(STEP)
    return engine.velocities(paths)


def test_a_slider_loses_speed_by_its_linear_damping():
    stage = new_stage()
    UsdPhysics.RigidBodyAPI(damped_body(stage, "/World/a", linear=1.5)).CreateVelocityAttr(Gf.Vec3f(1, 0, 0))
    joint(stage, "/World/joint", UsdPhysics.PrismaticJoint, "", "/World/a", (0, 0, 0), axis="X")
    (velocity,) = velocities_after(stage, "/World/a")
    assert velocity[0] == pytest.approx(np.exp(-1.5 * SECONDS), rel=0.01)


@pytest.mark.parametrize("arm", [0.0, 0.5])
def test_a_hinged_body_loses_spin_by_its_angular_damping(arm):
    """Angular damping acts on the spin alone, which has a smaller part of the momentum the longer the arm."""
    stage = new_stage()
    prim = damped_body(stage, "/World/a", angular=2.0)
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(3.0)
    api = UsdPhysics.RigidBodyAPI(prim)
    api.CreateAngularVelocityAttr(Gf.Vec3f(0, 0, 90))
    api.CreateVelocityAttr(Gf.Vec3f(0, np.radians(90) * arm, 0))
    joint(stage, "/World/joint", UsdPhysics.RevoluteJoint, "", "/World/a", (-arm, 0, 0), axis="Z")
    (velocity,) = velocities_after(stage, "/World/a")
    own = 0.2**2 / 6.0  # of a cube's inertia per mass
    assert velocity[5] == pytest.approx(np.radians(90) * np.exp(-2.0 * SECONDS * own / (own + arm**2)), rel=0.02)


def test_links_that_float_turn_less_against_each_other_and_keep_their_momentum():
    stage = new_stage()
    damped_body(stage, "/World/a")
    prim = damped_body(stage, "/World/b", angular=2.0)
    UsdPhysics.RigidBodyAPI(prim).CreateAngularVelocityAttr(Gf.Vec3f(0, 0, 90))
    joint(stage, "/World/joint", UsdPhysics.RevoluteJoint, "/World/a", "/World/b", (0, 0, 0), axis="Z")
    pairs = UsdPhysics.FilteredPairsAPI.Apply(prim)
    pairs.CreateFilteredPairsRel().SetTargets(["/World/a"])
    first, second = velocities_after(stage, "/World/a", "/World/b")[:, 5]
    # Equal inertias: what one loses the other gets, so that the difference decays at twice the rate.
    assert first + second == pytest.approx(np.radians(90), rel=0.01)
    assert second - first == pytest.approx(np.radians(90) * np.exp(-4.0 * SECONDS), rel=0.08)


@pytest.mark.parametrize(("slides", "rate"), crossed([("transX",), ("transX", "transY", "transZ")], [60.0, 240.0]))
def test_bodies_that_slide_on_each_other_while_they_turn_keep_their_momentum(slides, rate):
    """In free space, without damping: the joint transmits forces across the slide, and momentum is m v of both."""
    stage = new_stage()
    prims = [damped_body(stage, f"/World/{name}", at=(x, 0, 0)) for name, x in (("a", -0.5), ("b", 0.5))]
    spin = np.radians(rate)
    for prim, x in zip(prims, (-0.5, 0.5)):
        UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(1.0)
        api = UsdPhysics.RigidBodyAPI(prim)
        api.CreateAngularVelocityAttr(Gf.Vec3f(0, 0, rate))
        # They turn about the middle, slide apart, and fly off together.
        api.CreateVelocityAttr(Gf.Vec3f(2.0 * x, spin * x + 1.0, 0))
    made = joint(stage, "/World/joint", UsdPhysics.Joint, "/World/a", "/World/b", (0, 0, 0))
    free_axes(made, *slides)
    engine = playing(stage)
    for _ in range(60):
        engine.step(STEP)
    velocities = engine.velocities(["/World/a", "/World/b"])
    assert velocities[:, :3].sum(axis=0) == pytest.approx([0, 2, 0], abs=1e-3)


def test_a_joint_whose_axes_are_all_free_holds_nothing():
    """A cube that spins about x and z beside one that flies off: their velocities stay as they are."""
    stage = new_stage()
    spinning, flying = damped_body(stage, "/World/a"), damped_body(stage, "/World/b", at=(1, 0, 0))
    UsdPhysics.RigidBodyAPI(spinning).CreateAngularVelocityAttr(Gf.Vec3f(50, 0, 50))
    UsdPhysics.RigidBodyAPI(flying).CreateVelocityAttr(Gf.Vec3f(0, 1, 0))
    joint(stage, "/World/joint", UsdPhysics.Joint, "/World/a", "/World/b", (0.5, 0, 0))
    first, second = velocities_after(stage, "/World/a", "/World/b")
    assert first == pytest.approx([0, 0, 0, *np.radians([50, 0, 50])], abs=1e-4)
    assert second == pytest.approx([0, 1, 0, 0, 0, 0], abs=1e-4)
