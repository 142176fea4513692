"""8-DOP screen bounds contain every point of a shape in front of the camera, and little more."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from tests.render import scenes
from usdsdg_render.device.camera import camera_array
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.kernels.labels.screen_bounds import ANYWHERE, MARGIN, SIDES, bound_on_screen

# Weights of column and row, for a side and its opposite.
LINES = np.array([(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, -1.0)])
SHAPES = [scenes.sphere(), scenes.cube()]


def placed(rng: np.random.Generator, count: int, spread: float):
    """Upload rotated, scaled spheres and cubes; return them with the world points of each."""
    objects, points = [], []
    for k in range(count):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        matrix = scenes.moved(rng.uniform(-spread, spread, 3), scale=rng.uniform(0.1, 0.8, 3), rotation=turn)
        objects.append((SHAPES[k % 2], matrix, 0))
        points.append(SHAPES[k % 2].points.astype(np.float64) @ matrix[:3, :3] + matrix[3, :3])
    on_device = DeviceScene("cpu")
    on_device.sync(scenes.scene_of(objects))
    return on_device, points


def screen_bounds(on_device: DeviceScene, view, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Compute lower and upper bounds along each line, (count, 4), of all instances."""
    offsets = wp.empty((1, count, SIDES), dtype=wp.float32, device="cpu")
    tested = wp.array(np.arange(count), dtype=wp.int32, device="cpu")
    inputs = [on_device.tables, on_device.supports, camera_array([view], "cpu"), tested, 0]
    wp.launch(bound_on_screen, dim=(1, count), inputs=inputs, outputs=[offsets], device="cpu")
    bounds = offsets.numpy()[0].astype(np.float64)
    bounds[np.abs(bounds) > 0.5 * ANYWHERE] *= np.inf
    return -bounds[:, 4:], bounds[:, :4]


def values(view, points: np.ndarray) -> np.ndarray:
    """Project world points in front of the camera onto each line, (V, 4)."""
    pixels, _ = view.project(points)
    return pixels @ LINES.T


@pytest.mark.parametrize("projection", ["pinhole", "orthographic"])
def test_bounds_of_shapes_in_front_of_the_camera_are_tight(projection):
    on_device, points = placed(np.random.default_rng(1), 60, 2.0)
    wide = {"horizontal_aperture": 60.0} if projection == "orthographic" else {}
    offset = {"horizontal_aperture_offset": 2.0, "vertical_aperture_offset": -1.0}
    view = scenes.view_from((9, -4, 3), size=(640, 480), projection_type=projection, **offset, **wide)
    lower, upper = screen_bounds(on_device, view, 60)
    for k, shape in enumerate(points):
        seen = values(view, shape)
        assert (lower[k] <= seen.min(0) - MARGIN).all()
        assert (upper[k] >= seen.max(0) + MARGIN).all()
        # Bounds are at most 10 % larger.
        assert (upper[k] - lower[k] <= 1.1 * np.ptp(seen, axis=0) + 2 * MARGIN + 1.0).all()


def test_bounds_hold_shapes_around_and_beside_the_camera():
    on_device, points = placed(np.random.default_rng(2), 300, 2.0)
    view = scenes.view_from((0, 0, 0), (1, 0.2, 0.1), size=(640, 480), clipping_range=(0.01, 100))
    lower, upper = screen_bounds(on_device, view, 300)
    # Also points inside the triangles, because some corners lie behind the camera.
    rng = np.random.default_rng(3)
    numbers = [len(shape.triangles) for shape in SHAPES]
    mixed = [rng.dirichlet(np.full(3, 0.3), (number, max(2, 2000 // number))) for number in numbers]
    bounded = 0
    for k, shape in enumerate(points):
        corners = shape[SHAPES[k % 2].triangles]
        inside = (mixed[k % 2] @ corners).reshape(-1, 3)
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


def test_bounds_are_empty_outside_the_clipping_range():
    on_device, _ = placed(np.random.default_rng(3), 4, 0.1)
    for clipping in ((0.1, 5.0), (20.0, 100.0)):
        view = scenes.view_from((10, 0, 0), size=(64, 48), clipping_range=clipping)
        lower, upper = screen_bounds(on_device, view, 4)
        assert (lower > upper).all()
