"""Transforms of instances on the device: records, world bounding boxes and TLAS, updated in place."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.render import scenes
from usdsdg_render.device.device_scene import DeviceScene

SHAPES = [scenes.sphere(), scenes.cube()]


def turned(count: int, seed: int) -> np.ndarray:
    """Random (count, 4, 4) matrices with rotation, reflection, scale and shear."""
    rng = np.random.default_rng(seed)
    matrices = np.stack([np.eye(4)] * count)
    matrices[:, :3, :3] = Rotation.random(count, random_state=seed).as_matrix() * rng.uniform(-3, 3, (count, 1, 3))
    matrices[:, :3, :3] += rng.normal(size=(count, 3, 3)) * 0.3
    matrices[:, 3, :3] = rng.normal(size=(count, 3)) * 50
    return matrices


def synced(matrices: np.ndarray) -> tuple[DeviceScene, scenes.Scene]:
    scene = scenes.scene_of([(SHAPES[k % 2], matrix, 0) for k, matrix in enumerate(matrices)])
    on_device = DeviceScene("cpu")
    on_device.sync(scene)
    return on_device, scene


def test_records_hold_the_matrices_and_their_inverses():
    matrices = turned(100, 1)
    on_device, _ = synced(matrices)
    rows = on_device.tables.tlas.instances.numpy()
    linear = matrices[:, :3, :3].transpose(0, 2, 1)
    np.testing.assert_array_equal(rows["local_to_world"], linear.astype(np.float32))
    np.testing.assert_array_equal(rows["world_origin"], matrices[:, 3, :3].astype(np.float32))
    inverse = np.linalg.inv(linear)
    tolerance = 2e-7 * np.abs(inverse).max((1, 2), keepdims=True)  # of single precision, for the largest entry
    assert (np.abs(rows["world_to_local"] - inverse) <= tolerance).all()


def test_world_boxes_hold_their_instances():
    matrices = turned(200, 2)
    on_device, _ = synced(matrices)
    placement = on_device.placement
    assert placement.placed.all()
    for k, matrix in enumerate(matrices):
        points = SHAPES[k % 2].points.astype(np.float64) @ matrix[:3, :3] + matrix[3, :3]
        assert (placement.lower[k] <= points.min(0)).all()
        assert (placement.upper[k] >= points.max(0)).all()
        size = np.ptp(points, axis=0)
        assert (placement.upper[k] - placement.lower[k] <= size + 0.1 * size.max() + 1e-3).all()


@pytest.mark.parametrize("wrong", ["nan", "infinite", "flat", "nothing", "huge"])
def test_instances_with_singular_transforms_are_skipped_with_a_warning(wrong):
    matrices = turned(5, 3)
    matrices[2] = {
        "nan": np.where(np.arange(16).reshape(4, 4) == 5, np.nan, np.eye(4)),
        "infinite": np.where(np.arange(16).reshape(4, 4) == 12, np.inf, np.eye(4)),
        "flat": np.diag([1.0, 1.0, 0.0, 1.0]),
        "nothing": np.diag([1e-11, 1e-11, 1e-11, 1.0]),
        "huge": np.diag([1e200, 1e200, 1e200, 1.0]),
    }[wrong]
    with pytest.warns(UserWarning, match="/object_2 is not rendered"):
        on_device, _ = synced(matrices)
    np.testing.assert_array_equal(on_device.placement.placed, [True, True, False, True, True])
    assert on_device.tables.tlas.instance_count == 4
    assert np.isfinite(on_device.placement.lower).all()


@pytest.mark.filterwarnings("ignore:.*is not rendered")
def test_updated_transforms_equal_those_of_a_new_renderer():
    on_device, scene = synced(turned(60, 4))
    for seed, hidden in ((5, 0), (6, 20), (7, 59), (8, 60), (9, 3), (10, 0)):
        matrices = turned(60, seed)
        matrices[:hidden, :3, 2] = 0.0
        scene.instances.local_to_world = matrices
        scene.touch("transforms")
        on_device.sync(scene)
        expected, _ = synced(matrices)
        assert on_device.tables.tlas.instance_count == 60 - hidden
        for name in ("lower", "upper", "placed"):
            updated, new = getattr(on_device.placement, name), getattr(expected.placement, name)
            np.testing.assert_array_equal(updated, new)
        for name in ("world_to_local", "local_to_world", "world_origin"):
            updated, new = (each.tables.tlas.instances.numpy()[name] for each in (on_device, expected))
            np.testing.assert_array_equal(updated, new)
