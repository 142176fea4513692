"""How high things rebound: the square of the restitution of the height that they fall, however long a step is."""

import numpy as np
import pytest
from pxr import UsdPhysics

from tests.physics.impacts import calm_scenes
from tests.physics.scenes import add, new_stage, physics_material, playing, position, set_value, velocity

RESTITUTIONS = (0.1, 0.3, 0.5, 0.9)


def _apex(heights: np.ndarray) -> float:
    """The greatest height between the first impact and the next."""
    rising = np.diff(heights) > 0.0
    start = int(rising.argmax())
    fall = int((~rising[start:]).argmax())
    return float(heights[start : start + fall + 1].max())


@pytest.mark.parametrize(("kind", "rate"), [("Sphere", 60), ("Cube", 60), ("Sphere", 240), ("Sphere", 600)])
def test_a_rebound_has_the_height_that_restitution_says(kind, rate):
    """At 240 steps a second, 2.7 cm instead of 1 cm with a restitution of 0.1, and 10.6 cm instead of 9 with 0.3.

    At 60 steps, what rises 1 cm ends its way within the step in which it lands, and is as much as 2.5 mm too high.
    """
    stage = calm_scenes.rebounds(RESTITUTIONS, kind=kind)
    set_value(stage.GetPrimAtPath("/PhysicsScene"), "physxScene:timeStepsPerSecond", rate)
    engine, things = playing(stage), calm_scenes.things(stage)
    paths = []
    for _ in range(rate):
        engine.step(1.0 / rate)
        paths.append([position(thing)[2] - 0.1 for thing in things])
    heights = [_apex(path) for path in np.array(paths).T]
    assert heights == pytest.approx(np.square(RESTITUTIONS), rel=0.01, abs=2.5e-3 if rate == 60 else 1e-4)


def test_what_meets_in_the_air_parts_with_its_share_of_speed():
    """Both fall, so nothing pulls them together, and each has half of the momentum before and after."""
    stage = new_stage()
    material = physics_material(stage, "/World/material", restitution=0.5)
    upper = add(stage, "/World/upper", "Sphere", at=(0, 0, 1), material=material)
    lower = add(stage, "/World/lower", "Sphere", at=(0, 0, 0), material=material)
    UsdPhysics.RigidBodyAPI(upper).CreateVelocityAttr((0, 0, -2))
    engine = playing(stage)
    for _ in range(60):
        engine.step(1.0 / 60.0)
    assert [velocity(each)[2] + 9.81 for each in (upper, lower)] == pytest.approx([-0.5, -1.5], abs=1e-3)


def test_without_gravity_a_ball_leaves_a_wall_with_its_share_of_speed():
    stage = new_stage()
    material = physics_material(stage, "/World/material", restitution=0.6)
    add(stage, "/World/wall", at=(1, 0, 0), scale=(0.1, 1, 1), body=False, material=material)
    ball = add(stage, "/World/ball", "Sphere", gravity=False, material=material)
    UsdPhysics.RigidBodyAPI(ball).CreateVelocityAttr((3, 0, 0))
    engine = playing(stage)
    for _ in range(60):
        engine.step(1.0 / 60.0)
    assert velocity(ball)[0] == pytest.approx(-1.8, rel=1e-3)
    assert position(ball)[0] == pytest.approx(0.8 - 1.8 * (1.0 - 0.8 / 3.0), abs=0.02)
