"""Friction of round faces, whose contacts are corners of polygons that are not opposite, against closed forms.

PhysX (ovphysx 0.7.0) keeps the same disks within 0.02 mm and the cones within 0.3 mm.
"""

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from tests.physics.scenes import add, collide, make_body, mesh, new_stage, physics_material, playing, position
from tests.sampled_cases import crossed

STEP = 1 / 60
G = 9.81
FRICTION = 0.5
RADIUS = 0.2


def _stage():
    stage = new_stage()
    material = physics_material(stage, "/World/m", friction=FRICTION)
    add(stage, "/World/ground", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False, material=material)
    return stage, material


def _set_motion(body, *, velocity=(0, 0, 0), spin=0.0):
    api = UsdPhysics.RigidBodyAPI(body)
    api.CreateVelocityAttr(Gf.Vec3f(*velocity))
    api.CreateAngularVelocityAttr(Gf.Vec3f(0, 0, np.degrees(spin)))


@pytest.mark.parametrize(("kind", "gap"), crossed(["Cylinder", "Cone"], [0.0, 0.0005, 0.2]))
def test_disks_that_spin_stay_where_they_are(kind, gap):
    """Friction turns them back, and its sum is nothing: it moved them by 22 mm."""
    stage, material = _stage()
    body = add(stage, "/World/b", kind, at=(0, 0, 0.05 + gap), scale=(RADIUS, RADIUS, 0.05), material=material)
    _set_motion(body, spin=10.0)
    playing(stage).advance(90 * STEP)
    assert np.hypot(*position(body)[:2]) < 1e-3


@pytest.mark.parametrize("kind", ["Cylinder", "Cone"])
def test_disks_that_spin_slow_down(kind):
    """Friction at the rim takes mu m g R; spread over the face it would take two thirds of that.

    The moment of inertia is half (of cones 0.3) of m R².
    """
    stage, material = _stage()
    body = add(stage, "/World/b", kind, at=(0, 0, 0.05), scale=(RADIUS, RADIUS, 0.05), material=material)
    _set_motion(body, spin=10.0)
    engine, spin = playing(stage), []
    for _ in range(6):
        engine.advance(STEP)
        spin.append(np.radians(body.GetAttribute("physics:angularVelocity").Get()[2]))
    slowed = (10.0 - spin[-1]) / (6 * STEP)
    most = FRICTION * G / RADIUS / (0.5 if kind == "Cylinder" else 0.3)
    assert 0.66 * most < slowed < 1.02 * most


@pytest.mark.parametrize("kind", ["Cylinder", "Cone"])
def test_disks_slide_straight(kind):
    """As far as v² / (2 mu g), without a turn."""
    stage, material = _stage()
    body = add(stage, "/World/b", kind, at=(0, 0, 0.02), scale=(RADIUS, RADIUS, 0.02), material=material)
    _set_motion(body, velocity=(2, 0, 0))
    engine = playing(stage)
    engine.advance(20 * STEP)
    assert abs(np.radians(body.GetAttribute("physics:angularVelocity").Get()[2])) < 0.01
    engine.advance(40 * STEP)
    assert position(body) == pytest.approx([2.0**2 / (2 * FRICTION * G), 0.0, 0.02], abs=0.012)
    assert abs(position(body)[1]) < 1e-3


def test_disks_on_disks_spin_in_place():
    stage, material = _stage()
    coins = [
        add(
            stage,
            f"/World/coin{i}",
            "Cylinder",
            at=(0, 0, 0.01 + 0.02 * i),
            scale=(0.05, 0.05, 0.01),
            material=material,
        )
        for i in range(3)
    ]
    for number, coin in enumerate(coins):
        _set_motion(coin, spin=20.0 if number % 2 else -20.0)
    playing(stage).advance(60 * STEP)
    assert all(np.hypot(*position(coin)[:2]) < 1e-3 for coin in coins)


def test_round_meshes_spin_in_place():
    """A plate of 24 corners is a convex hull."""
    stage, _ = _stage()
    angles = np.arange(24) * 2 * np.pi / 24
    ring = np.stack([0.15 * np.cos(angles), 0.15 * np.sin(angles)], axis=1)
    points = np.vstack([np.hstack([ring, np.full((24, 1), z)]) for z in (-0.02, 0.02)])
    sides = [(i, (i + 1) % 24, 24 + i) for i in range(24)] + [
        ((i + 1) % 24, 24 + (i + 1) % 24, 24 + i) for i in range(24)
    ]
    caps = [(0, i + 1, i) for i in range(1, 23)] + [(24, 24 + i, 25 + i) for i in range(1, 23)]
    plate = mesh(stage, "/World/plate", points, np.array(sides + caps)).GetPrim()
    UsdGeom.Xformable(plate).AddTranslateOp().Set((0, 0, 0.02))
    collide(plate)
    make_body(plate)
    _set_motion(plate, spin=10.0)
    playing(stage).advance(90 * STEP)
    assert np.hypot(*position(plate)[:2]) < 1.5e-3
