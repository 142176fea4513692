"""Boxes around turned shapes: never too small, and hardly too large."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp
from scipy.spatial.transform import Rotation

from tests.render import scenes
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.geometry.support_function import support_table
from usdsdg_render.kernels.scene.support_function import support

RNG = np.random.default_rng(4)
SHAPES = {
    "ball": scenes.sphere().points,
    "cube": scenes.cube().points,
    "sliver": RNG.normal(size=(40, 3)) * (1.0, 1e-4, 1e-6),
    "cloud": RNG.normal(size=(9000, 3)) * (3.0, 1.0, 0.2),
    "far from its origin": np.array((1e4, -3e4, 2e4)) + RNG.normal(size=(50, 3)),
    "point": np.array([[1.0, -2.0, 3.0]]),
}


@wp.kernel(enable_backward=False)
def _reaches(
    supports: wp.array2d(dtype=wp.float64),
    directions: wp.array(dtype=wp.vec3d),
    reaches: wp.array(dtype=wp.float64),
):
    i = wp.tid()
    reaches[i] = support(supports, 0, directions[i])


def reaches_along(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """How far a shape reaches along (N, 3) directions."""
    found = wp.zeros(len(directions), dtype=wp.float64, device="cpu")
    supports = wp.array(support_table(points).reshape(1, -1), dtype=wp.float64, device="cpu")
    inputs = [supports, wp.array(directions, dtype=wp.vec3d, device="cpu")]
    wp.launch(_reaches, dim=len(directions), inputs=inputs, outputs=[found], device="cpu")
    return found.numpy()


@pytest.mark.parametrize("name", SHAPES)
def test_no_point_is_beyond_the_reach(name):
    points = SHAPES[name].astype(np.float32)
    directions = RNG.normal(size=(3000, 3)) * 10.0 ** RNG.uniform(-6, 6, (3000, 1))
    directions[:100, RNG.integers(0, 3)] = 0.0
    directions[100:120, 1:] = RNG.choice([-1.0, 0.0, 1.0], (20, 2))
    reaches = reaches_along(points, directions)
    exact = (points.astype(np.float64) @ directions.T).max(0)
    length = np.linalg.norm(directions, axis=1)
    rounding = 1e-12 * np.abs(points).max() * length
    assert (reaches >= exact - rounding).all()
    assert (reaches - exact <= 0.08 * np.linalg.norm(np.ptp(points, axis=0)) * length + rounding).all()


def test_at_the_nodes_of_the_grid_it_is_exact():
    points = SHAPES["cloud"].astype(np.float32)
    for direction in ((1, 0, 0), (0, -1, 0), (-1, 0.5, -1), (0.5, -0.5, 1)):
        assert reaches_along(points, np.array([direction], np.float64))[0] == pytest.approx(
            (points @ np.array(direction)).max(), rel=2e-5
        )


def test_a_turned_ball_gets_the_box_of_a_ball():
    turned = Rotation.from_euler("xyz", (40, 30, 20), degrees=True).as_matrix()
    scene = scenes.scene_of([(scenes.sphere(), scenes.moved((5, 0, 0), rotation=turned), 0)])
    on_device = DeviceScene("cpu")
    on_device.sync(scene)
    np.testing.assert_allclose(on_device.placement.upper[0] - on_device.placement.lower[0], 2.0, rtol=0.03)
