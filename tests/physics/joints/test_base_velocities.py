"""What a velocity of one body does to those that are jointed to it, in articulations and outside.

PhysX (ovphysx 0.7.0) gives the same velocities after the first step to two digits in all cases but one: it ignores
velocities of links that are no base, which have their momentum here.
"""

import numpy as np
import pytest
from pxr import Gf, UsdPhysics

from tests.physics.mechanisms import joint
from tests.physics.scenes import add, new_stage, playing, position, velocity
from tests.sampled_cases import crossed

STEP = 1 / 60
GIVEN = (0.3, 1.0, 0.0)
PATHS = ("/World/b0", "/World/b1", "/World/b2")
MASSES = (1.0, 2.0, 3.0)


def _chain(*roots: str):
    """Three cubes of 0.2 m in a line with hinges between them, without gravity."""
    stage = new_stage()
    bodies = []
    for number, (path, mass) in enumerate(zip(PATHS, MASSES)):
        body = add(stage, path, at=(number, 0, 0), gravity=False)
        UsdPhysics.MassAPI.Apply(body).CreateMassAttr(mass)
        if path in roots:
            UsdPhysics.ArticulationRootAPI.Apply(body)
        bodies.append(body)
    for number in (0, 1):
        ends = PATHS[number : number + 2]
        joint(stage, f"/World/j{number}", UsdPhysics.RevoluteJoint, *ends, (number + 0.5, 0, 0), axis="Z")
    return stage, bodies


def _give(body) -> None:
    UsdPhysics.RigidBodyAPI(body).CreateVelocityAttr(Gf.Vec3f(*GIVEN))


@pytest.mark.parametrize(("when", "base"), crossed(["before", "playing"], [0, 1, 2]))
def test_the_base_of_an_articulation_takes_its_links_along(base, when):
    stage, bodies = _chain(PATHS[base])
    for body in bodies:  # As in stages that were saved while they did not move.
        UsdPhysics.RigidBodyAPI(body).CreateVelocityAttr(Gf.Vec3f(0))
    if when == "before":
        _give(bodies[base])
    engine = playing(stage)
    if when == "playing":
        engine.step(STEP)
        _give(bodies[base])
    before = [position(body) for body in bodies]
    for _ in range(30):
        engine.step(STEP)
    for body, start in zip(bodies, before):
        assert position(body) - start == pytest.approx(np.multiply(GIVEN, 0.5), abs=1e-4)
        assert velocity(body) == pytest.approx(GIVEN, abs=1e-5)
    assert np.degrees(engine.joint_positions(["/World/j0", "/World/j1"])) == pytest.approx([0, 0], abs=0.01)


def _after_impulse(body: int) -> np.ndarray:
    """Velocities (3, 3) of bodies in x, y, and about z, after one got its velocity: Lagrange multipliers of hinges."""
    inertia = np.repeat(MASSES, 3) * np.tile([1, 1, 0.2**2 / 6], 3)
    rows = []
    for first in (0, 1):
        for axis in (0, 1):
            row = np.zeros((3, 3))
            row[first, axis], row[first + 1, axis] = 1, -1
            if axis == 1:  # half a meter from both
                row[first, 2], row[first + 1, 2] = 0.5, 0.5
            rows.append(row.ravel())
    held = np.array(rows)
    start = np.zeros((3, 3))
    start[body, :2] = GIVEN[:2]
    start = start.ravel()
    impulse = np.linalg.solve(held / inertia @ held.T, -held @ start)
    return (start + held.T @ impulse / inertia).reshape(3, 3)


@pytest.mark.parametrize("when", ["before", "playing"])
@pytest.mark.parametrize("body", [0, 1, 2])
def test_bodies_outside_of_articulations_share_their_momentum(body, when):
    stage, bodies = _chain()
    if when == "before":
        _give(bodies[body])
    engine = playing(stage)
    if when == "playing":
        engine.step(STEP)
        _give(bodies[body])
    engine.step(1e-4)
    expected = _after_impulse(body)
    assert np.array([velocity(each)[:2] for each in bodies]) == pytest.approx(expected[:, :2], abs=2e-3)
    spins = [each.GetAttribute("physics:angularVelocity").Get()[2] for each in bodies]
    assert np.radians(spins) == pytest.approx(expected[:, 2], abs=2e-3)


@pytest.mark.parametrize(
    ("others", "base"), crossed(["", "a mass", "a mass, beside another body"], ["floats", "articulation", "fixed"])
)
def test_a_base_that_is_put_somewhere_takes_its_links_along(base, others, recwarn):
    """Also where a mass is set in the same frame, as randomizers do: links stayed, and the robot went between both."""
    stage, bodies = _chain(*PATHS[: base != "floats"])
    if "beside" in others:
        add(stage, "/World/bystander", at=(-9, 0, 0), gravity=False)
    if base == "fixed":
        joint(stage, "/World/fix", UsdPhysics.FixedJoint, "", PATHS[0], (0, 0, 0))
    engine = playing(stage)
    for _ in range(3):
        engine.step(STEP)
    bodies[0].GetAttribute("xformOp:translate").Set(Gf.Vec3d(1, 2, 3))
    if others:
        UsdPhysics.MassAPI(bodies[1]).GetMassAttr().Set(2.5)
    for _ in range(3):
        engine.step(STEP)
        for number, body in enumerate(bodies):
            assert position(body) == pytest.approx([1 + number, 2, 3], abs=1e-5)
    assert not [each for each in recwarn if "jump together" in str(each.message)]
