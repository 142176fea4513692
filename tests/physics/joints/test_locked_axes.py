"""Axes that bodies do not move along or turn about, against closed forms.

PhysX (ovphysx 0.7.0) is within 0.2 % of the same, for a locked position, for two locked rotations of a tilted box and
for a box that slides down a slope with all rotations locked.
"""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdPhysics

from tests.physics.scenes import add, fallen, new_stage, physics_material, playing, position, velocity

STEP = 1 / 60
X, Y, Z = 1, 2, 4


def _locked(stage, path="/World/box", *, along=0, about=0, speed=(0, 0, 0), spin=(0, 0, 0), **options):
    prim = add(stage, path, **options)
    prim.CreateAttribute("physxRigidBody:lockedPosAxis", Sdf.ValueTypeNames.Int).Set(along)
    prim.CreateAttribute("physxRigidBody:lockedRotAxis", Sdf.ValueTypeNames.Int).Set(about)
    UsdPhysics.RigidBodyAPI(prim).CreateVelocityAttr(Gf.Vec3f(*speed))
    UsdPhysics.RigidBodyAPI(prim).CreateAngularVelocityAttr(Gf.Vec3f(*spin))
    return prim


def _spin(prim):
    return np.array(prim.GetAttribute("physics:angularVelocity").Get())


def test_a_body_does_not_move_along_locked_axes():
    stage = new_stage()
    prim = _locked(stage, along=X | Z, speed=(1, 2, 3))
    playing(stage).advance(60 * STEP)
    assert position(prim) == pytest.approx([0, 2, 0], abs=1e-4)
    assert velocity(prim) == pytest.approx([0, 2, 0], abs=1e-5)


def test_other_axes_are_free():
    stage = new_stage()
    prim = _locked(stage, along=X, about=X, speed=(1, 0, 0), spin=(0, 90, 0))
    playing(stage).advance(60 * STEP)
    assert position(prim) == pytest.approx([0, 0, -fallen(60)], abs=1e-3)
    assert _spin(prim) == pytest.approx([0, 90, 0], rel=1e-3, abs=1e-2)


@pytest.mark.parametrize("tilt", [0, 30])
def test_a_body_turns_about_the_axis_that_is_left(tilt):
    stage = new_stage()
    prim = _locked(stage, about=X | Y, spin=(90, 0, 90), gravity=False, rotate=(0, tilt, 0), scale=(0.1, 0.2, 0.3))
    playing(stage).advance(60 * STEP)
    assert _spin(prim) == pytest.approx([0, 0, 90], rel=5e-3, abs=0.1)


def test_a_box_on_an_edge_slides_down_without_tipping():
    """a = g (sin 35° - mu cos 35°), although the ground touches only one of its edges."""
    stage = new_stage()
    material = physics_material(stage, "/World/m", friction=0.5)
    add(stage, "/World/slope", scale=(5, 2, 0.1), rotate=(0, 35, 0), body=False, material=material)
    prim = _locked(stage, at=(0, 0, 0.37), about=X | Y | Z, material=material)
    engine = playing(stage)
    engine.advance(20 * STEP)  # it falls on the slope first
    before = velocity(prim)
    engine.advance(40 * STEP)
    angle = np.radians(35)
    expected = 9.81 * (np.sin(angle) - 0.5 * np.cos(angle)) * 40 * STEP
    assert np.linalg.norm(velocity(prim) - before) == pytest.approx(expected, rel=0.03)
    assert _spin(prim) == pytest.approx([0, 0, 0], abs=1e-3)


def test_a_locked_body_stops_what_hits_it():
    """A ball hits a box that cannot move, and bounces off as from a wall."""
    stage = new_stage()
    bouncy = physics_material(stage, "/World/m", friction=0.0, restitution=1.0)
    wall = _locked(stage, "/World/wall", along=X | Y | Z, about=X | Y | Z, gravity=False, material=bouncy)
    ball = add(stage, "/World/ball", "Sphere", at=(-1, 0, 0), gravity=False, material=bouncy)
    UsdPhysics.RigidBodyAPI(ball).CreateVelocityAttr(Gf.Vec3f(2, 0, 0))
    playing(stage).advance(60 * STEP)
    assert position(wall) == pytest.approx([0, 0, 0], abs=1e-4)
    assert velocity(ball)[0] == pytest.approx(-2.0, rel=0.03)


def test_a_body_that_is_tilted_while_playing_turns_about_the_same_axis_of_the_world():
    stage = new_stage()
    prim = _locked(stage, about=X | Y, gravity=False, rotate=(0, 0, 0), scale=(0.1, 0.2, 0.3))
    engine = playing(stage)
    engine.advance(STEP)
    prim.GetAttribute("xformOp:rotateXYZ").Set(Gf.Vec3f(0, 50, 0))
    prim.GetAttribute("physics:angularVelocity").Set(Gf.Vec3f(0, 0, 90))
    engine.advance(30 * STEP)
    assert _spin(prim) == pytest.approx([0, 0, 90], rel=5e-3, abs=0.1)


@pytest.mark.parametrize("offset", [0.0, 0.05])
def test_what_hits_a_body_with_one_locked_axis_bounces_as_off_a_wall(offset):
    """A box that may not move along z but along x and y, also where its center of mass is not at its origin."""
    stage = new_stage()
    bouncy = physics_material(stage, "/World/m", friction=0.0, restitution=1.0)
    box = _locked(stage, "/World/box", along=Z, about=X | Y, gravity=False, material=bouncy)
    UsdPhysics.MassAPI.Apply(box).CreateCenterOfMassAttr(Gf.Vec3f(10 * offset, 0, 0))
    ball = add(stage, "/World/ball", "Sphere", at=(0, 0, 0.5), scale=(0.1, 0.1, 0.1), gravity=False, material=bouncy)
    UsdPhysics.RigidBodyAPI(ball).CreateVelocityAttr(Gf.Vec3f(0, 0, -2))
    playing(stage).advance(30 * STEP)
    assert velocity(ball) == pytest.approx([0, 0, 2], rel=0.01, abs=0.01)
    assert position(box) == pytest.approx([0, 0, 0], abs=1e-4)


@pytest.mark.parametrize("offset", [0.0, 0.05])
def test_a_push_off_the_center_turns_a_body_about_its_free_axes_only(offset):
    """ω = r F t / I about z, and nothing about x, which is locked: the force has an arm about both."""
    stage = new_stage()
    prim = _locked(stage, about=X, gravity=False, rotate=(0, 0, 0), scale=(0.1, 0.2, 0.3))
    mass = UsdPhysics.MassAPI.Apply(prim)
    mass.CreateMassAttr(2.0)
    mass.CreateCenterOfMassAttr(Gf.Vec3f(10 * offset, 0, 0))
    mass.CreateDiagonalInertiaAttr(Gf.Vec3f(0.1, 0.1, 0.2))
    engine = playing(stage)
    for _ in range(6):
        engine.apply_forces(["/World/box"], [[0.0, 3.0, 0.0]], positions=[[offset + 0.1, 0.0, 0.2]])
        engine.step(STEP)
    assert np.radians(_spin(prim)) == pytest.approx([0, 0, 0.1 * 3.0 * 0.1 / 0.2], rel=0.01, abs=1e-3)
    assert velocity(prim)[1] == pytest.approx(3.0 / 2.0 * 0.1, rel=0.01)


def test_a_box_that_may_not_tip_about_one_axis_is_pushed_without_giving_way():
    """A kinematic hand pushes the top of a box, which slides on its friction instead of lifting its edge."""
    stage = new_stage()
    material = physics_material(stage, "/World/m", friction=0.8)
    add(stage, "/World/ground", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False, material=material)
    box = _locked(stage, "/World/box", at=(0, 0, 0.3), scale=(0.05, 0.1, 0.3), about=Y, material=material)
    hand = add(stage, "/World/hand", at=(-0.1, 0, 0.55), scale=(0.05, 0.05, 0.05))
    UsdPhysics.RigidBodyAPI(hand).CreateKinematicEnabledAttr(True)
    engine = playing(stage)
    heights = []
    for step in range(60):
        hand.GetAttribute("xformOp:translate").Set(Gf.Vec3d(-0.1 + 0.5 * (step + 1) * STEP, 0, 0.55))
        engine.step(STEP)
        heights.append(position(box)[2])
    assert position(box)[0] == pytest.approx(0.5, abs=5e-3)
    assert np.ptp(heights) < 1e-3
    assert _spin(box) == pytest.approx([0, 0, 0], abs=0.5)
