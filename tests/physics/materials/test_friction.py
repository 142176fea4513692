"""Static friction and combine modes of materials, against closed forms.

PhysX (ovphysx 0.7.0) gives the same speeds to three digits, on a slope and for each combine mode on flat ground.
"""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdPhysics

from tests.physics.scenes import add, new_stage, physics_material, playing, position, velocity
from usdsdg.stage.schemas import physx

STEP = 1 / 60
G = 9.81


def _material(stage, path, *, static, dynamic, mode="average", restitution=0.0):
    material = physics_material(stage, path, friction=dynamic, restitution=restitution)
    UsdPhysics.MaterialAPI(material.GetPrim()).GetStaticFrictionAttr().Set(static)
    api = physx.PhysxMaterialAPI.Apply(material.GetPrim())
    api.CreateFrictionCombineModeAttr(mode)
    api.CreateRestitutionCombineModeAttr(mode)
    return material


def _on_slope(stage, degrees, material, speed):
    """A box 0.2 mm above a slope down the x axis, moving down at a speed."""
    add(stage, "/World/slope", scale=(9, 2, 0.1), rotate=(0, degrees, 0), body=False, material=material)
    angle = np.radians(degrees)
    up, down = np.array([np.sin(angle), 0, np.cos(angle)]), np.array([np.cos(angle), 0, -np.sin(angle)])
    box = add(stage, "/World/box", at=tuple(0.2002 * up), rotate=(0, degrees, 0), material=material)
    UsdPhysics.RigidBodyAPI(box).CreateVelocityAttr(Gf.Vec3f(*(speed * down)))
    return box


def test_what_rests_sticks_and_what_slides_slides():
    """tan 30° is 0.58: below the static, above the dynamic friction."""
    for speed in (0.0, 1.0):
        stage = new_stage()
        box = _on_slope(stage, 30, _material(stage, "/World/m", static=0.9, dynamic=0.2), speed)
        playing(stage).advance(60 * STEP)
        slope = np.radians(30)
        expected = 1.0 + G * (np.sin(slope) - 0.2 * np.cos(slope)) if speed else 0.0
        assert np.linalg.norm(velocity(box)) == pytest.approx(expected, rel=0.01, abs=1e-3)


def test_what_static_friction_cannot_hold_slides_with_dynamic_friction():
    stage = new_stage()
    box = _on_slope(stage, 35, _material(stage, "/World/m", static=0.5, dynamic=0.1), 0.0)
    playing(stage).advance(60 * STEP)
    slope = np.radians(35)
    assert np.linalg.norm(velocity(box)) == pytest.approx(G * (np.sin(slope) - 0.1 * np.cos(slope)), rel=0.02)


@pytest.mark.parametrize("gravity", [True, False])
def test_a_push_that_static_friction_cannot_hold_makes_a_box_slide_at_once(gravity):
    """It crept for a quarter of a second, until it was as fast as friction can stop within a substep.

    Without gravity of its own, the box is pressed down as hard by a force.
    """
    stage = new_stage()
    material = _material(stage, "/World/m", static=0.6, dynamic=0.3)
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(9, 2, 0.1), body=False, material=material)
    box = add(stage, "/World/box", at=(0, 0, 0.05), scale=(0.3, 0.3, 0.05), gravity=gravity, material=material)
    UsdPhysics.MassAPI.Apply(box).CreateMassAttr(2.0)
    engine, weight, speeds = playing(stage), 2.0 * G, []
    for push in (0.58, 0.62):
        for _ in range(60):
            engine.apply_forces(["/World/box"], [[push * weight, 0, 0 if gravity else -weight]])
            engine.step(STEP)
        speeds.append(velocity(box)[0])
    assert speeds == pytest.approx([0.0, (0.62 - 0.3) * G], rel=0.03, abs=1e-3)


@pytest.mark.parametrize(
    ("modes", "friction"),
    [
        (("average", "average"), 0.4),
        (("min", "average"), 0.2),
        (("average", "multiply"), 0.12),
        (("multiply", "min"), 0.12),
        (("min", "max"), 0.6),
    ],
)
def test_combine_modes_of_friction(modes, friction):
    """A sliding box is braked by mu g; of two modes the one later in average, min, multiply, max counts."""
    stage = new_stage()
    own, other = (
        _material(stage, f"/World/m{value}", static=value / 10, dynamic=value / 10, mode=mode)
        for value, mode in zip((2, 6), modes)
    )
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(9, 2, 0.1), body=False, material=own)
    box = add(stage, "/World/box", at=(-4, 0, 0.1), material=other)
    UsdPhysics.RigidBodyAPI(box).CreateVelocityAttr(Gf.Vec3f(3, 0, 0))
    playing(stage).advance(30 * STEP)
    assert velocity(box)[0] == pytest.approx(3.0 - friction * G * 0.5, rel=0.03)


@pytest.mark.parametrize(("mode", "restitution"), [("min", 0.0), ("max", 0.8)])
def test_combine_modes_of_restitution(mode, restitution):
    stage = new_stage()
    soft, bouncy = (
        _material(stage, f"/World/m{value}", static=0.5, dynamic=0.5, mode=mode, restitution=value / 10)
        for value in (0, 8)
    )
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False, material=soft)
    ball = add(stage, "/World/ball", "Sphere", at=(0, 0, 1.1), material=bouncy)
    engine, heights = playing(stage), []
    for _ in range(60):
        engine.advance(STEP)
        heights.append(position(ball)[2] - 0.1)
    bounced = max(heights[heights.index(min(heights)) :])
    assert bounced == pytest.approx(restitution**2, rel=0.12, abs=0.01)


@pytest.mark.parametrize(("threshold", "bounces"), [(0.0, True), (3.0, True), (6.0, False)])
def test_contacts_bounce_from_the_threshold_of_the_scene_on(threshold, bounces):
    """From a height of 1 m a ball arrives with 4.4 m/s."""
    stage = new_stage()
    stage.GetPrimAtPath("/PhysicsScene").CreateAttribute("physxScene:bounceThreshold", Sdf.ValueTypeNames.Float).Set(
        threshold
    )
    material = _material(stage, "/World/m", static=0.5, dynamic=0.5, restitution=0.8)
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False, material=material)
    ball = add(stage, "/World/ball", "Sphere", at=(0, 0, 1.1), material=material)
    engine, heights = playing(stage), []
    for _ in range(60):
        engine.advance(STEP)
        heights.append(position(ball)[2] - 0.1)
    bounced = max(heights[heights.index(min(heights)) :])
    assert bounced == pytest.approx(0.8**2 if bounces else 0.0, rel=0.12, abs=0.01)
