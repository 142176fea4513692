"""Hulls with a cap on their vertices: they lie close to the whole hull on all sides, and balance where it does."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from usdsdg.session.stage_context import new_stage
from usdsdg_physics import NewtonEngine
from usdsdg_physics.parse.shapes.convex_hulls import MAX_HULL_VERTICES, HullCache


def ball(rows=24, columns=48):
    polar, turn = np.meshgrid(np.linspace(0, np.pi, rows), np.linspace(0, 2 * np.pi, columns, endpoint=False))
    points = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=-1)
    return points.reshape(-1, 3)


def can(sides=60):
    turn = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    return np.concatenate([np.column_stack([ring, np.full(sides, z)]) for z in (-1.0, 1.0)])


def bent_plate():
    """A plate whose normal is none of the axes, nor halfway between any: its extremes along those lie in a plane."""
    side = np.linspace(-1, 1, 12)
    u, v = (axis.ravel() for axis in np.meshgrid(side, side))
    across, along = np.array([3.0, -2.0, 1.0]), np.array([1.0, 2.0, 1.0])
    normal = np.cross(across, along)
    bulge = 0.05 * (1 - u**2) * (1 - v**2)
    points = [np.outer(u, across), np.outer(v, along)]
    return np.concatenate([sum(points) + sign * np.outer(bulge, normal / np.linalg.norm(normal)) for sign in (1, -1)])


SHAPES = {"ball": (ball, 0.08), "can": (can, 0.015), "bent plate": (bent_plate, 0.02)}


def supports(points, directions):
    return (points @ directions.T).max(axis=0)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_capped_hull_is_near_the_whole_one_on_all_sides(shape):
    make, most = SHAPES[shape]
    points = make()
    hull = HullCache().hull(points)
    assert len(hull.vertices) <= MAX_HULL_VERTICES
    directions = np.random.default_rng(0).normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    missing = supports(points, directions) - supports(hull.vertices.astype(float), directions)
    assert missing.min() > -1e-6, "nothing is added"
    assert missing.max() < most


@pytest.mark.parametrize("shape", ["ball", "can"])
def test_a_capped_hull_keeps_extents_and_center(shape):
    points = SHAPES[shape][0]()
    hull = HullCache().hull(points)
    np.testing.assert_allclose(hull.vertices.min(axis=0), points.min(axis=0), atol=1e-6)
    np.testing.assert_allclose(hull.vertices.max(axis=0), points.max(axis=0), atol=1e-6)
    np.testing.assert_allclose(hull.centroid, 0.0, atol=0.01)


def test_hulls_of_few_points_keep_all():
    corners = can(sides=30)
    hull = HullCache().hull(corners)
    assert {tuple(point) for point in hull.vertices} == {tuple(point) for point in corners.astype(np.float32)}


def test_a_ball_of_mesh_that_is_put_down_stays():
    stage = new_stage()
    mesh = UsdGeom.Mesh.Define(stage, "/World/Ball")
    rows, columns = 24, 48
    points = ball(rows, columns).reshape(columns, rows, 3)
    mesh.CreatePointsAttr((0.5 * points).reshape(-1, 3).astype(np.float32))
    faces = [
        (c * rows + r, c * rows + r + 1, (c + 1) % columns * rows + r + 1, (c + 1) % columns * rows + r)
        for c in range(columns)
        for r in range(rows - 1)
    ]
    mesh.CreateFaceVertexCountsAttr([4] * len(faces))
    mesh.CreateFaceVertexIndicesAttr([corner for face in faces for corner in face])
    mesh.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0.5))
    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
    UsdPhysics.RigidBodyAPI.Apply(mesh.GetPrim())
    floor = UsdGeom.Cube.Define(stage, "/World/Floor")
    floor.AddTranslateOp().Set(Gf.Vec3d(0, 0, -1))
    floor.AddScaleOp().Set(Gf.Vec3f(5, 5, 1))
    UsdPhysics.CollisionAPI.Apply(floor.GetPrim())
    engine = NewtonEngine(stage)
    engine.play()
    for _ in range(120):
        engine.step(1 / 60)
    place = UsdGeom.Xformable(mesh).GetLocalTransformation().ExtractTranslation()
    np.testing.assert_allclose(place, (0, 0, 0.5), atol=0.02)
