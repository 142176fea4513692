"""Chains of links that swing freely, however fast they whip."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from pxr import UsdPhysics

from tests.physics.mechanisms import joint, rod, rotation
from tests.physics.scenes import new_stage, playing, position
from tests.sampled_cases import sampled

G, STEP, LENGTH, MASS, WIDTH = 9.81, 1.0 / 60.0, 0.1, 0.1, 0.02


def chain(stage, links: int, kind: type):
    """Links in a horizontal row, of which the first hangs on the world."""
    paths = [f"/World/link{k}" for k in range(links)]
    for k, path in enumerate(paths):
        rod(stage, path, (k * LENGTH, 0, 2), ((k + 1) * LENGTH, 0, 2), width=WIDTH, mass=MASS)
        options = {"axis": "Y"} if kind is UsdPhysics.RevoluteJoint else {}
        joint(stage, f"/World/joint{k}", kind, paths[k - 1] if k else "", path, (k * LENGTH, 0, 2), **options)
    return paths


def energy(engine, stage, paths) -> float:
    """Kinetic and potential energy [J], which is zero at the start."""
    velocities = engine.velocities(paths)
    heights = np.array([position(stage.GetPrimAtPath(path))[2] for path in paths]) - 2.0
    axes = np.array([rotation(stage.GetPrimAtPath(path))[2] for path in paths])
    twist, turn = (velocities[:, 3:] * axes).sum(axis=1), (velocities[:, 3:] ** 2).sum(axis=1)
    # Of boxes, per mass.
    across, along = (LENGTH**2 + WIDTH**2) / 12.0, WIDTH**2 / 6.0
    kinetic = 0.5 * ((velocities[:, :3] ** 2).sum() + (across * (turn - twist**2) + along * twist**2).sum())
    return MASS * (G * heights.sum() + kinetic)


@pytest.mark.parametrize(("links", "kind"), sampled([(8, UsdPhysics.SphericalJoint), (12, UsdPhysics.RevoluteJoint)]))
def test_a_chain_that_falls_from_the_horizontal_gains_little_energy(links, kind):
    stage = new_stage()
    paths = chain(stage, links, kind)
    engine = playing(stage)
    available = MASS * G * LENGTH * links**2 / 2.0  # from the horizontal to hanging
    gained = []
    for _ in range(150):
        engine.step(STEP)
        gained.append(energy(engine, stage, paths) / available)
    # The solver is of first order. In four substeps of a step, however fast links turn, they gain six times as much as
    # they had, or end as poses that are not numbers.
    assert max(gained) < 0.25
    assert min(gained) > -0.6


@pytest.mark.parametrize("kind", sampled([UsdPhysics.RevoluteJoint, UsdPhysics.SphericalJoint]))
def test_a_chain_that_carries_far_more_than_its_mass_moves_on(kind):
    """Ten links with 5000 times the mass of one: in single precision their mass matrix has no inverse."""
    stage = new_stage()
    links, load = 10, 5000 * MASS
    paths = chain(stage, links, kind)
    x = links * LENGTH
    rod(stage, "/World/load", (x, 0, 2), (x + 0.1, 0, 2), width=0.1, mass=load)
    options = {"axis": "Y"} if kind is UsdPhysics.RevoluteJoint else {}
    joint(stage, "/World/hook", kind, paths[-1], "/World/load", (x, 0, 2), **options)
    weight = stage.GetPrimAtPath("/World/load")
    engine, lowest = playing(stage), 0.0
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "the solver gave a pose that is not a number")
        for _ in range(120):
            engine.step(STEP)
            drop, speed = 2 - position(weight)[2], np.linalg.norm(engine.velocities(["/World/load"])[0, :3])
            lowest = max(lowest, drop)
            # Nearly all energy is the load's. The solver, which is of first order, adds a fifth of what it had.
            assert speed**2 / 2 - G * drop < 0.4 * G * x
            assert np.linalg.norm(position(weight) - (0, 0, 2)) < x + 0.05 + 1e-3
    assert lowest == pytest.approx(x + 0.05, rel=0.02)


def test_rounding_alone_shakes_no_chain_that_carries_far_more_than_its_mass():
    """Under this load hinges gained 38 % while armature only just kept their mass matrix from having no inverse."""
    stage = new_stage()
    links, load = 10, 4950 * MASS
    paths = chain(stage, links, UsdPhysics.RevoluteJoint)
    x = links * LENGTH
    rod(stage, "/World/load", (x, 0, 2), (x + 0.1, 0, 2), width=0.1, mass=load)
    joint(stage, "/World/hook", UsdPhysics.RevoluteJoint, paths[-1], "/World/load", (x, 0, 2), axis="Y")
    weight, engine, gained = stage.GetPrimAtPath("/World/load"), playing(stage), []
    for _ in range(120):
        engine.step(STEP)
        drop, speed = 2 - position(weight)[2], np.linalg.norm(engine.velocities(["/World/load"])[0, :3])
        gained.append((speed**2 / 2 - G * drop) / (G * x))
    assert max(gained) < 0.3
