"""Watertightness: of millions of rays at edges and corners of closed meshes none passes, in any placement."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.bvh import compressed_on_cpu
from tests.render.bvh.rays import trace
from tests.render.bvh.test_query import random_rotation
from tests.render.images import radiance
from tests.sampled_cases import crossed
from usdsdg_render.device.device_scene import DeviceScene

RAYS = 120_000


def bumpy() -> scenes.Prototype:
    """A closed star-shaped mesh around the origin: a ball of uneven radius."""
    ball = scenes.sphere(rings=40)
    rng = np.random.default_rng(5)
    waves = ball.points @ rng.normal(size=(3, 6)) * 4 + rng.uniform(0, 6, 6)
    return scenes.prototype(ball.points * (1 + 0.08 * np.sin(waves).sum(1, keepdims=True)), ball.triangles)


def needles() -> scenes.Prototype:
    """A ball whose triangles are a thousand times longer than wide."""
    turns, count = np.arange(1500) * 2 * np.pi / 1500, 1500
    ring = np.stack([np.cos(turns), np.sin(turns), 0 * turns], -1)
    points = np.concatenate([[[0, 0, 1]], ring, [[0, 0, -1]]])
    i, j = np.arange(count), np.roll(np.arange(count), -1)
    caps = [np.stack([0 * i, 1 + i, 1 + j], -1), np.stack([0 * i + count + 1, 1 + j, 1 + i], -1)]
    return scenes.prototype(points, np.concatenate(caps))


SHAPES = {"ball": lambda: scenes.sphere(rings=64), "bumpy": bumpy, "needles": needles, "box": scenes.cube}


def sheared() -> np.ndarray:
    matrix = scenes.moved((0.3, -0.1, 0.2))
    matrix[:3, :3] = [[1.0, 0.8, -0.3], [0.0, 0.7, 0.9], [0.2, 0.0, 1.3]]
    return matrix


def turned(seed: int, **values) -> np.ndarray:
    return scenes.moved(rotation=random_rotation(np.random.default_rng(seed)), **values)


PLACES = {
    "as it is": scenes.moved(),
    "turned": turned(1, translation=(3.0, -2.0, 7.0)),
    "flat": turned(2, scale=(1.0, 1e-3, 40.0), translation=(0.5, 0.25, -1.0)),
    "mirrored, far away": turned(3, scale=(-2.0, 0.3, 5.0), translation=(3e4, -2e4, 1e4)),
    "aside": scenes.moved((0.0, 0.0, 3.0), scale=50.0),
    "tiny": turned(4, scale=(1e-5, 3e-5, 2e-5), translation=(0.1, 0.2, 0.3)),
    "sheared": sheared(),
}


def aims(prototype: scenes.Prototype, rng: np.random.Generator) -> np.ndarray:
    """(RAYS, 3) points in the mesh's frame: its vertices, midpoints of its edges, and other points of its edges."""
    corners = prototype.points[prototype.triangles[rng.integers(0, len(prototype.triangles), RAYS)]].astype(np.float64)
    part = np.repeat([0.0, 0.5, np.nan], RAYS // 3)[:, None]
    part = np.where(np.isnan(part), rng.random((RAYS, 1)), part)
    side = rng.integers(0, 3, RAYS)
    rows = np.arange(RAYS)
    return corners[rows, side] * (1 - part) + corners[rows, (side + 1) % 3] * part


def placed_rays(shape: str, place: str, *, seed: int):
    """(scene, origins, directions) of rays from inside of a placed mesh to its corners and edges."""
    rng = np.random.default_rng(seed)
    prototype, matrix = SHAPES[shape](), PLACES[place]
    scene = scenes.scene_of([(prototype, matrix, 0)])
    start = rng.uniform(-0.1, 0.1, (RAYS, 3)) * (rng.random((RAYS, 1)) < 0.5)
    # Rays from the center of a symmetric mesh run in its planes of symmetry.
    origins, targets = (each @ matrix[:3, :3] + matrix[3, :3] for each in (start, aims(prototype, rng)))
    origins = origins.astype(np.float32).astype(np.float64)
    directions = targets - origins
    return scene, origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


@pytest.mark.parametrize(("place", "shape"), crossed(PLACES, SHAPES))
def test_no_ray_escapes(shape, place):
    scene, origins, directions = placed_rays(shape, place, seed=6)
    on_device = DeviceScene("cpu")
    on_device.sync(scene)
    assert (trace(on_device, origins, directions)["instance"] == 0).all()
    assert (trace(on_device, origins, directions, any_hit=True)["instance"] == 0).all()


@pytest.mark.parametrize(("place", "shape"), crossed(["aside", "flat", "sheared"], SHAPES))
def test_no_ray_escapes_a_compressed_tree(shape, place):
    scene, origins, directions = placed_rays(shape, place, seed=7)
    on_device = DeviceScene("cpu")
    on_device.sync(scene)
    some = slice(0, None, 6)
    rays = origins[some].astype(np.float32), directions[some].astype(np.float32)
    reach = np.full(len(rays[0]), 1e30, np.float32)
    assert (compressed_on_cpu.trace(on_device, scene, *rays, reach=reach)[:, 3] == 0).all()


@pytest.mark.parametrize("place", PLACES)
def test_no_ray_enters(place):
    """Rays from outside to front-facing vertices and edges hit there, not at the far side."""
    rng = np.random.default_rng(8)
    ball, matrix = scenes.sphere(rings=64), PLACES[place]
    scene = scenes.scene_of([(ball, matrix, 0)])
    local = aims(ball, rng)
    start = rng.normal(size=(RAYS, 3))
    start *= 3 / np.linalg.norm(start, axis=1, keepdims=True)
    faces = ((start - local) * local).sum(1) > 0.3 * np.linalg.norm(start - local, axis=1)
    origins, targets = (each[faces] @ matrix[:3, :3] + matrix[3, :3] for each in (start, local))
    origins = origins.astype(np.float32).astype(np.float64)
    distance = np.linalg.norm(targets - origins, axis=1, keepdims=True)
    hits = trace(scene, origins, (targets - origins) / distance)
    assert faces.sum() > 0.2 * RAYS
    assert (hits["instance"] == 0).all()
    np.testing.assert_array_less(hits["t"], 1.01 * distance[:, 0] + 1e-6 * np.abs(origins).max())


def test_an_edge_near_zero_is_watertight_for_rays_in_its_plane():
    """Vertices made by cosines lie 6e-17 beside the plane x = 0; rays in that plane must still hit."""
    ball = scenes.sphere(rings=64)
    beside = np.abs(ball.points[:, 0])
    assert ((beside > 0) & (beside < 1e-15)).sum() > 100
    up = np.linspace(-0.95, 0.95, 5001)
    for away in (3.0, 100.0, 1e4):
        origins = np.stack([0 * up, 0 * up - away, up], -1)
        hits = trace(scenes.scene_of([(ball, scenes.moved(), 0)]), origins, (0, 1, 0))
        np.testing.assert_allclose(hits["t"], away - np.sqrt(1 - up**2), atol=2e-3 + 1e-6 * away)


@pytest.mark.parametrize(("place", "shape"), crossed(["as it is", "turned", "flat", "aside"], ["box", "bumpy"]))
def test_no_light_leaks_in(shape, place):
    """Paths start at walls, also in corners; a very bright dome outside must stay invisible."""
    matrix = PLACES[place]
    walls = scenes.material(base_color=0.9, specular=0.0, roughness=1.0)
    scene = scenes.scene_of([(SHAPES[shape](), matrix, 0)], materials=[walls], dome=scenes.white_dome(1e6))
    eye, target = (np.array(at) @ matrix[:3, :3] + matrix[3, :3] for at in ((0.05, 0.02, -0.03), (0.9, 0.8, 0.85)))
    view = scenes.view_from(eye, target, size=(48, 48), focal_length=8.0, clipping_range=(1e-6, 1e6))
    lit = radiance(scene, view, samples=32, bounces=6).max(-1) > 0
    # A path that starts a millionth of the room's size off its wall may, once in a million, start behind the next wall.
    assert lit.sum() <= 1
