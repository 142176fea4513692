"""`isaacsim.core.utils.random`: poses in view of a camera, drawn with Python's `random` as in Isaac Sim.

`random.seed` makes them repeat; the global seed of Replicator does not.
"""

from __future__ import annotations

import math
import random

import numpy as np
from numpy.typing import ArrayLike
from pxr import Usd

from usdsdg.compat.isaacsim.core.utils.rotations import euler_angles_to_quat
from usdsdg.compat.isaacsim.core.utils.transformations import (
    get_translation_from_target,
    get_world_pose_from_relative,
)

__all__ = ["get_random_translation_from_camera", "get_random_values_in_range", "get_random_world_pose_in_view"]


def get_random_values_in_range(min_range: ArrayLike, max_range: ArrayLike) -> np.ndarray:
    """Return a number between each two limits (N,)."""
    limits = zip(np.asarray(min_range), np.asarray(max_range))
    return np.array([random.uniform(low, high) for low, high in limits])


def get_random_translation_from_camera(
    min_distance: float, max_distance: float, fov_x: float, fov_y: float, fraction_to_screen_edge: float
) -> np.ndarray:
    """Return a point (3,) in view of a camera, in its frame: +x right, +y up, -z ahead.

    Args:
        min_distance: least distance along the optical axis [stage units].
        max_distance: greatest distance.
        fov_x: horizontal field of view [rad].
        fov_y: vertical field of view [rad].
        fraction_to_screen_edge: fraction of the angle to the edge that is drawn from; 0 is the optical axis.
    """
    distance = random.uniform(min_distance, max_distance)
    wide, high = (distance * math.tan(fraction_to_screen_edge * angle / 2.0) for angle in (fov_x, fov_y))
    return np.array([random.uniform(-wide, wide), random.uniform(-high, high), -distance])


def get_random_world_pose_in_view(
    camera_prim: Usd.Prim, min_distance: float, max_distance: float, fov_x: float, fov_y: float,
    fraction_to_screen_edge: float, coord_prim: Usd.Prim, min_rotation_range: ArrayLike,
    max_rotation_range: ArrayLike,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return a position (3,) in view of a camera and an orientation (4,), w, x, y, z, both in the world.

    Args:
        camera_prim: the camera; distances and fields of view are as for `get_random_translation_from_camera`.
        coord_prim: prim in whose frame the orientation is drawn.
        min_rotation_range: least Euler angles about its fixed axes x, y, z (3,) [degrees].
        max_rotation_range: greatest ones.
    """
    in_camera = get_random_translation_from_camera(min_distance, max_distance, fov_x, fov_y, fraction_to_screen_edge)
    translation = get_translation_from_target(in_camera, camera_prim, coord_prim)
    angles = get_random_values_in_range(min_rotation_range, max_rotation_range)
    return get_world_pose_from_relative(coord_prim, translation, euler_angles_to_quat(angles, degrees=True))
