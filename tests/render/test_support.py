"""Boxes around turned shapes: never too small, and hardly too large."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.render import scenes
from usdsdg_render.device import DeviceScene
from usdsdg_render.support import SUPPORT, reach, support, world_boxes

RNG = np.random.default_rng(4)
SHAPES = {
    "ball": scenes.sphere().points,
    "cube": scenes.cube().points,
    "sliver": RNG.normal(size=(40, 3)) * (1.0, 1e-4, 1e-6),
    "cloud": RNG.normal(size=(9000, 3)) * (3.0, 1.0, 0.2),
    "far from its origin": np.array((1e4, -3e4, 2e4)) + RNG.normal(size=(50, 3)),
    "point": np.array([[1.0, -2.0, 3.0]]),
}


@pytest.mark.parametrize("name", SHAPES)
def test_no_point_is_beyond_the_reach(name):
    points = SHAPES[name].astype(np.float32)
    directions = RNG.normal(size=(3000, 3)) * 10.0 ** RNG.uniform(-6, 6, (3000, 1))
    directions[:100, RNG.integers(0, 3)] = 0.0
    directions[100:120, 1:] = RNG.choice([-1.0, 0.0, 1.0], (20, 2))
    reaches = reach(support(points)[None], np.zeros(3000, np.int64), directions)
    exact = (points.astype(np.float64) @ directions.T).max(0)
    length = np.linalg.norm(directions, axis=1)
    rounding = 1e-12 * np.abs(points).max() * length
    assert (reaches >= exact - rounding).all()
    assert (reaches - exact <= 0.08 * np.linalg.norm(np.ptp(points, axis=0)) * length + rounding).all()


def test_at_the_nodes_of_the_grid_it_is_exact():
    points = SHAPES["cloud"].astype(np.float32)
    for direction in ((1, 0, 0), (0, -1, 0), (-1, 0.5, -1), (0.5, -0.5, 1)):
        found = reach(support(points)[None], np.zeros(1, np.int64), np.array([direction], np.float64))
        assert found[0] == pytest.approx((points @ np.array(direction)).max(), rel=2e-5)


def test_boxes_in_the_world_hold_what_is_placed():
    shapes = [points.astype(np.float32) for points in SHAPES.values()]
    supports = np.stack([support(points) for points in shapes])
    assert supports.shape[1:] == SUPPORT
    which = RNG.integers(0, len(shapes), 200)
    matrices = np.stack([np.eye(4)] * 200)
    matrices[:, :3, :3] = Rotation.random(200, random_state=1).as_matrix() * RNG.uniform(-3, 3, (200, 1, 3))
    matrices[:, :3, :3] += RNG.normal(size=(200, 3, 3)) * 0.3  # sheared
    matrices[:, 3, :3] = RNG.normal(size=(200, 3)) * 50
    lower, upper = world_boxes(supports, which, matrices)
    for k, shape in enumerate(which):
        placed = shapes[shape].astype(np.float64) @ matrices[k, :3, :3] + matrices[k, 3, :3]
        slack = 1e-9 * np.abs(placed).max()
        assert (lower[k] <= placed.min(0) + slack).all()
        assert (upper[k] >= placed.max(0) - slack).all()


def test_a_turned_ball_gets_the_box_of_a_ball():
    turned = Rotation.from_euler("xyz", (40, 30, 20), degrees=True).as_matrix()
    scene = scenes.scene_of([(scenes.sphere(), scenes.moved((5, 0, 0), rotation=turned), 0)])
    on_device = DeviceScene("cpu")
    on_device.sync(scene)
    np.testing.assert_allclose(on_device.upper[0] - on_device.lower[0], 2.0, rtol=0.03)
