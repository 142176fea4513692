"""Surfaces that carry what lies on them, against closed forms; PhysX (ovphysx 0.7.0) gives the same within 1 %."""

import numpy as np
import pytest
from pxr import Gf, UsdPhysics

from tests.physics.scenes import add, new_stage, physics_material, playing, position, velocity
from usdsdg import errors
from usdsdg.stage.schemas import physx

STEP = 1 / 60
FRICTION = 0.5


def _belt(stage, *, speed=(1.0, 0.0, 0.0), scale=(3.0, 0.5, 0.1), local=True, spin=(0.0, 0.0, 0.0), **options):
    material = physics_material(stage, "/World/rubber", friction=FRICTION)
    belt = add(stage, "/World/belt", scale=scale, material=material, **options)
    UsdPhysics.RigidBodyAPI(belt).CreateKinematicEnabledAttr(True)
    surface = physx.PhysxSurfaceVelocityAPI.Apply(belt)
    surface.CreateSurfaceVelocityAttr(Gf.Vec3f(*speed))
    surface.CreateSurfaceAngularVelocityAttr(Gf.Vec3f(*spin))
    surface.CreateSurfaceVelocityLocalSpaceAttr(local)
    return belt, material


def test_a_belt_accelerates_a_box_by_friction_to_its_own_speed():
    """v = mu g t, then the belt's; a local velocity is scaled with the prim, as in PhysX."""
    stage = new_stage()
    _, material = _belt(stage)
    box = add(stage, "/World/box", at=(-2, 0, 0.2), material=material)
    engine = playing(stage)
    engine.advance(30 * STEP)
    assert velocity(box) == pytest.approx([FRICTION * 9.81 * 0.5, 0, 0], rel=0.03, abs=0.01)
    engine.advance(30 * STEP)
    assert velocity(box) == pytest.approx([3.0, 0, 0], rel=0.01, abs=0.01)


def test_a_turned_belt_carries_along_its_own_axis_or_that_of_the_world():
    for local, expected in ((True, [0, 1, 0]), (False, [1, 0, 0])):
        stage = new_stage()
        _, material = _belt(
            stage, speed=(0.5, 0, 0) if local else (1, 0, 0), scale=(2, 2, 0.1), rotate=(0, 0, 90), local=local
        )
        box = add(stage, "/World/box", at=(-1, -1, 0.2), material=material)
        playing(stage).advance(60 * STEP)
        assert velocity(box) == pytest.approx(expected, rel=0.01, abs=0.01)


def test_a_turntable_turns_what_lies_on_it():
    """ω r around its center, and ω: 30 degrees per second at 0.3 m."""
    stage = new_stage()
    _, material = _belt(stage, speed=(0, 0, 0), spin=(0, 0, 30), scale=(1, 1, 0.1))
    box = add(stage, "/World/box", at=(0.3, 0, 0.2), material=material)
    playing(stage).advance(60 * STEP)
    angle = np.radians(30.0)
    assert position(box)[:2] == pytest.approx([0.3 * np.cos(angle), 0.3 * np.sin(angle)], abs=3e-3)
    assert box.GetAttribute("physics:angularVelocity").Get()[2] == pytest.approx(30.0, rel=0.03)


def test_a_belt_starts_and_stops_what_rests_on_it():
    stage = new_stage()
    belt, material = _belt(stage, speed=(0, 0, 0))
    box = add(stage, "/World/box", at=(-2, 0, 0.2), material=material)
    engine = playing(stage)
    engine.advance(1.0)
    assert position(box)[0] == pytest.approx(-2.0, abs=1e-3)
    belt.GetAttribute("physxSurfaceVelocity:surfaceVelocity").Set(Gf.Vec3f(0.1, 0, 0))
    engine.advance(1.0)
    assert velocity(box)[0] == pytest.approx(0.3, rel=0.01)
    belt.CreateAttribute(
        "physxSurfaceVelocity:surfaceVelocityEnabled", belt.GetAttribute("physics:kinematicEnabled").GetTypeName()
    ).Set(False)
    engine.advance(1.0)
    assert velocity(box) == pytest.approx([0, 0, 0], abs=1e-3)


def test_a_moving_belt_that_is_no_kinematic_body_carries_too():
    stage = new_stage()
    material = physics_material(stage, "/World/rubber", friction=FRICTION)
    add(stage, "/World/ground", at=(0, 0, -0.2), scale=(5, 5, 0.1), body=False, material=material)
    belt = add(stage, "/World/belt", scale=(2, 1, 0.1), material=material)
    UsdPhysics.MassAPI.Apply(belt).CreateMassAttr(1000.0)
    physx.PhysxSurfaceVelocityAPI.Apply(belt).CreateSurfaceVelocityAttr(Gf.Vec3f(0, 0.5, 0))
    box = add(stage, "/World/box", at=(0, 0, 0.2), scale=(0.05, 0.05, 0.1), material=material)
    UsdPhysics.MassAPI.Apply(box).CreateMassAttr(0.1)
    playing(stage).advance(30 * STEP)
    # On the ground the belt drives the other way by its own surface.
    assert velocity(box)[1] - velocity(belt)[1] == pytest.approx(0.5, rel=0.05)


def test_surfaces_of_static_colliders_are_named():
    stage = new_stage()
    table = add(stage, "/World/table", scale=(1, 1, 0.1), body=False)
    physx.PhysxSurfaceVelocityAPI.Apply(table).CreateSurfaceVelocityAttr(Gf.Vec3f(1, 0, 0))
    box = add(stage, "/World/box", at=(0, 0, 0.2))
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning, match="/World/table.*kinematicEnabled"):
        playing(stage).advance(30 * STEP)
    errors.forget_warnings()
    assert velocity(box) == pytest.approx([0, 0, 0], abs=1e-2)
