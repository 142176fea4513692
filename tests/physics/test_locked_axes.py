"""Axes that bodies do not move along or turn about, against closed forms."""

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
