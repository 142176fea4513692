"""Octagons in the picture hold every point of a shape that is before the camera, and little else."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from tests.render import scenes
from usdsdg_render.device.camera import camera_array
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.kernels.labels.screen_bounds import ANYWHERE, MARGIN, SIDES, bound_on_screen

# Weights of column and row, of sides and their opposites.
LINES = np.array([(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, -1.0)])
SHAPES = [scenes.sphere(), scenes.cube()]


def placed(rng: np.random.Generator, count: int, spread: float):
    """Turned, stretched balls and cubes, on a device, with the points of each in the world."""
    objects, points = [], []
    for k in range(count):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        matrix = scenes.moved(rng.uniform(-spread, spread, 3), scale=rng.uniform(0.1, 0.8, 3), rotation=turn)
        objects.append((SHAPES[k % 2], matrix, 0))
        points.append(SHAPES[k % 2].points.astype(np.float64) @ matrix[:3, :3] + matrix[3, :3])
    on_device = DeviceScene("cpu")
    on_device.sync(scenes.scene_of(objects))
    return on_device, points


def octagons(on_device: DeviceScene, view, count: int) -> tuple[np.ndarray, np.ndarray]:
    """(count, 4) lower and upper bounds of each line, of all instances."""
    ends = wp.empty((1, count, SIDES), dtype=wp.float32, device="cpu")
    tested = wp.array(np.arange(count), dtype=wp.int32, device="cpu")
    inputs = [on_device.tables, on_device.supports, camera_array([view], "cpu"), tested, 0]
    wp.launch(bound_on_screen, dim=(1, count), inputs=inputs, outputs=[ends], device="cpu")
    bounds = ends.numpy()[0].astype(np.float64)
    bounds[np.abs(bounds) > 0.5 * ANYWHERE] *= np.inf
    return -bounds[:, 4:], bounds[:, :4]


def values(view, points: np.ndarray) -> np.ndarray:
    """(V, 4) of each line for points in the world, which are all before the camera."""
    pixels, _ = view.project(points)
    return pixels @ LINES.T


@pytest.mark.parametrize("projection", ["pinhole", "orthographic"])
def test_shapes_before_the_camera(projection):
    on_device, points = placed(np.random.default_rng(1), 60, 2.0)
    wide = {"horizontal_aperture": 60.0} if projection == "orthographic" else {}
    offset = {"horizontal_aperture_offset": 2.0, "vertical_aperture_offset": -1.0}
    view = scenes.view_from((9, -4, 3), size=(640, 480), projection_type=projection, **offset, **wide)
    lower, upper = octagons(on_device, view, 60)
    for k, shape in enumerate(points):
        seen = values(view, shape)
        assert (lower[k] <= seen.min(0) - MARGIN).all()
        assert (upper[k] >= seen.max(0) + MARGIN).all()
        # Hardly larger than what is there.
        assert (upper[k] - lower[k] <= 1.1 * np.ptp(seen, axis=0) + 2 * MARGIN + 1.0).all()


def test_shapes_around_and_beside_the_camera():
    on_device, points = placed(np.random.default_rng(2), 300, 2.0)
    view = scenes.view_from((0, 0, 0), (1, 0.2, 0.1), size=(640, 480), clipping_range=(0.01, 100))
    lower, upper = octagons(on_device, view, 300)
    bounded = 0
    for k, shape in enumerate(points):
        # Points of the triangles, too, not of the corners alone: some corners lie behind.
        mixed = np.random.default_rng(k).dirichlet(np.full(3, 0.3), (len(SHAPES[k % 2].triangles), 20))
        corners = shape[SHAPES[k % 2].triangles]
        inside = (mixed @ corners).reshape(-1, 3)
        _, depth = view.project(inside)
        ahead = inside[depth > 0.01]
        if len(ahead):
            seen = values(view, ahead)
            assert (lower[k] <= seen.min(0)).all()
            assert (upper[k] >= seen.max(0)).all()
            bounded += np.isfinite([lower[k], upper[k]]).all() or (depth.min() < 0 and np.isfinite(lower[k]).any())
        elif depth.max() < 0:
            assert (lower[k] > upper[k]).any()
    assert bounded > 50


def test_out_of_range_is_nowhere():
    on_device, _ = placed(np.random.default_rng(3), 4, 0.1)
    for clipping in ((0.1, 5.0), (20.0, 100.0)):
        view = scenes.view_from((10, 0, 0), size=(64, 48), clipping_range=clipping)
        lower, upper = octagons(on_device, view, 4)
        assert (lower > upper).all()
