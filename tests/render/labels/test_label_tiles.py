"""The label pass by tiles has the bits of the pass that traces each ray by itself."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import DEVICE, renderer_of
from tests.sampled_cases import crossed
from usdsdg_render.device.camera import views_record
from usdsdg_render.labels import label_pass
from usdsdg_render.labels.aov import AOVS

pytestmark = pytest.mark.skipif(DEVICE != "cpu", reason="tiles are traced on CPUs")

NAMES = [name for name, each in AOVS.items() if each.reads not in ("material", "hemisphere")]


def by_pixels(views, device):
    record = views_record(views, device)
    record.are_pinholes = 0
    return record


def soup(rng) -> scenes.Prototype:
    """Triangles of all sizes; some are there twice, some have corners in common, some lie in planes of the axes."""
    count = int(rng.integers(1, 300))
    points = rng.normal(size=(count, 1, 3)) * 2 + rng.normal(size=(count, 3, 3)) * rng.choice([0.02, 0.2, 1.0])
    if rng.random() < 0.4:
        points = np.round(points * 4) / 4
    triangles = np.arange(3 * count).reshape(count, 3)
    return scenes.prototype(points.reshape(-1, 3), np.concatenate([triangles, triangles[: count // 3]]))


def some_scene(rng, unit: float, center: np.ndarray) -> scenes.Scene:
    """Shapes beside, in and exactly upon each other; some are flat, mirrored, or a thousand times as long as wide."""
    shapes = [scenes.cube(), scenes.square(), scenes.sphere(rings=int(rng.integers(3, 30))), soup(rng), soup(rng)]
    placed = []
    for _ in range(int(rng.integers(1, 30))):
        rotation = np.eye(3) if rng.random() < 0.3 else np.linalg.qr(rng.normal(size=(3, 3)))[0]
        scale = rng.uniform(0.1, 1, 3) * rng.choice([0.1, 1, 1, 3])
        if rng.random() < 0.2:
            scale[rng.integers(3)] *= rng.choice([1e-3, -1, 0, 1e3])
        position = rng.uniform(-2, 2, 3)
        position = np.round(position) if rng.random() < 0.3 else position
        matrix = scenes.moved(position * unit + center, scale=scale * unit, rotation=rotation)
        placed += [(shapes[rng.integers(len(shapes))], matrix, 0)] * (2 if rng.random() < 0.1 else 1)
    opacity = {"opacity": float(rng.choice([0.0, 0.3, 1.0])), "opacity_threshold": float(rng.choice([0.0, 0.5]))}
    return scenes.scene_of(placed, materials=[scenes.material(**opacity if rng.random() < 0.3 else {})])


def some_view(rng, unit: float, center: np.ndarray):
    straight = rng.random() < 0.3  # where columns and rows of pixels meet edges of shapes exactly
    eye, target = ((0, -5, 0), (0, 0, 0)) if straight else (rng.normal(size=3) * rng.choice([0.5, 3, 10]), np.ones(3))
    near = float(rng.choice([0.01, 0.1, 3.0])) * unit
    return scenes.view_from(
        np.multiply(eye, unit) + center,
        np.multiply(target, unit) + center,
        size=(int(rng.integers(1, 60)), int(rng.integers(1, 40))),
        clipping_range=(near, near * float(rng.choice([2, 10, 1e6]))),
        horizontal_aperture_offset=float(rng.normal()),
        focal_length=float(rng.choice([2, 5, 24, 24, 2000])),
    )


def assert_has_bits_of_rays(tiles, renderer, view, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(label_pass, "views_record", by_pixels)
        pixels = renderer.labels(view, NAMES)
    for name in NAMES:
        np.testing.assert_array_equal(tiles[name].view(np.uint32), pixels[name].view(np.uint32), err_msg=name)


@pytest.mark.parametrize(("unit", "far"), crossed([1.0, 1e-3, 1e5], [0.0, 1e2, 1e6]))
def test_tiles_have_the_bits_of_rays(monkeypatch, unit, far):
    shown = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        center = far * rng.normal(size=3)
        renderer = renderer_of(some_scene(rng, unit, center))
        for _ in range(2):
            view = some_view(rng, unit, center)
            tiles = renderer.labels(view, NAMES)
            assert_has_bits_of_rays(tiles, renderer, view, monkeypatch)
            shown += np.count_nonzero(tiles["instance"] >= 0)
    assert shown > 2000


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_where_surfaces_coincide_a_ray_decides(monkeypatch, tilt):
    rng = np.random.default_rng(0)
    turn = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    places = turn @ np.append(rng.integers(-3, 4, (2, 40)), np.zeros((1, 40)), 0)
    shapes = [scenes.square(), scenes.cube()]
    placed = [(shapes[k % 2], scenes.moved(at, rotation=turn), 0) for k, at in enumerate(places.T)]
    renderer = renderer_of(scenes.scene_of(placed))
    for eye in ((0, -8, 3), (1, 2, 9), (6, 5, 4)):
        view = scenes.view_from(eye, size=(64, 48))
        assert_has_bits_of_rays(renderer.labels(view, NAMES), renderer, view, monkeypatch)
