"""A collider that is switched on inside bodies frees its center."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics

from tests.physics.scenes import add, new_stage, playing, position

UPDATE = 1.0 / 60.0


def _camera_with_collider(stage, at, radius):
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.AddTranslateOp().Set(Gf.Vec3d(*at))
    sphere = UsdGeom.Sphere.Define(stage, "/World/Camera/CollisionSphere")
    sphere.CreateRadiusAttr(radius)
    switch = UsdPhysics.CollisionAPI.Apply(sphere.GetPrim()).CreateCollisionEnabledAttr(False)
    return camera, switch


def _bodies_at(engine, point):
    return [hit for hit in engine.overlap_sphere(0.01, point) if not hit.collision.endswith("CollisionSphere")]


def _speed(prim):
    return float(np.linalg.norm(prim.GetAttribute("physics:velocity").Get() or (0, 0, 0)))


@pytest.mark.parametrize("radius", [0.25, 1.25])
@pytest.mark.parametrize("moved", [False, True])
def test_four_updates_free_a_camera_from_a_large_box(radius, moved):
    stage = new_stage()
    camera, switch = _camera_with_collider(stage, (9, 0, 0) if moved else (0.4, 0.1, 0), radius)
    crate = add(stage, "/World/crate", at=(0, 0, 0), scale=(1, 0.8, 0.9), gravity=False)
    engine = playing(stage)
    engine.advance(2 * UPDATE)
    if moved:
        camera.GetPrim().GetAttribute("xformOp:translate").Set(Gf.Vec3d(0.4, 0.1, 0))
    assert _bodies_at(engine, (0.4, 0.1, 0))
    switch.Set(True)
    for _ in range(4):
        engine.advance(UPDATE)
    switch.Set(False)
    assert not _bodies_at(engine, (0.4, 0.1, 0))
    assert _speed(crate) <= 3.0 + 1e-3


def test_a_body_that_only_touches_the_collider_is_pushed_as_gently_as_in_physx():
    stage = new_stage()
    _, switch = _camera_with_collider(stage, (0, 0, 0), 1.25)
    toy = add(stage, "/World/toy", "Sphere", at=(0.6, 0, 0), scale=(0.1, 0.1, 0.1), gravity=False)
    engine = playing(stage)
    engine.advance(UPDATE)
    switch.Set(True)
    for _ in range(4):
        engine.advance(UPDATE)
    moved = position(toy)[0] - 0.6
    assert 0.05 < moved <= 3.0 * 4 * UPDATE + 1e-3


def test_a_body_elsewhere_keeps_its_own_speed():
    stage = new_stage()
    _, switch = _camera_with_collider(stage, (0, 0, 0), 0.25)
    add(stage, "/World/crate", at=(0, 0, 0), scale=(1, 1, 1), gravity=False)
    ball = add(stage, "/World/ball", "Sphere", at=(0, 9, 0), gravity=False)
    ball.CreateAttribute("physics:velocity", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(0, 10, 0))
    engine = playing(stage)
    engine.advance(UPDATE)
    switch.Set(True)
    for _ in range(4):
        engine.advance(UPDATE)
    assert _speed(ball) == pytest.approx(10.0, rel=1e-3)
