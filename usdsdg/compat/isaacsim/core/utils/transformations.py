"""`isaacsim.core.utils.transformations`: poses and matrices (4, 4) for column vectors, quaternions (w, x, y, z)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from pxr import Usd

from usdsdg.compat.isaacsim.core.experimental.utils.xform import get_relative_transform
from usdsdg.compat.wrappers.poses import wxyz, xyzw
from usdsdg.stage.poses.rotations import compose, decompose
from usdsdg.stage.poses.transforms import as_array, local_to_world

__all__ = [
    "get_relative_transform", "get_transform_with_normalized_rotation", "get_translation_from_target",
    "get_world_pose_from_relative", "pose_from_tf_matrix", "tf_matrices_from_poses", "tf_matrix_from_pose",
]  # fmt: skip


def tf_matrix_from_pose(translation: ArrayLike, orientation: ArrayLike) -> np.ndarray:
    """Return the matrix (4, 4) of a position (3,) and a quaternion (4,)."""
    return compose(np.asarray(translation), xyzw(np.asarray(orientation))).T


def tf_matrices_from_poses(translations: np.ndarray, orientations: np.ndarray) -> np.ndarray:
    """Return the matrices (N, 4, 4), float32, of positions (N, 3) and quaternions (N, 4)."""
    matrices = compose(np.asarray(translations), xyzw(np.asarray(orientations)))
    return matrices.swapaxes(-1, -2).astype(np.float32)


def pose_from_tf_matrix(transformation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return position (3,) and quaternion (4,) of a matrix (4, 4), without its scale."""
    pose = decompose(np.asarray(transformation, np.float64).T)
    return pose.translate, wxyz(pose.rotation)


def get_translation_from_target(
    translation_from_source: np.ndarray, source_prim: Usd.Prim, target_prim: Usd.Prim
) -> np.ndarray:
    """Return a point (3,) of the source's space in the target's space."""
    point = get_relative_transform(source_prim, target_prim) @ np.append(translation_from_source, 1.0)
    return point[:3]


def get_world_pose_from_relative(
    coord_prim: Usd.Prim, relative_translation: np.ndarray, relative_orientation: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return position (3,) and quaternion (4,) in the world of a pose in a prim's space."""
    to_world = as_array(local_to_world(coord_prim)).T
    return pose_from_tf_matrix(to_world @ tf_matrix_from_pose(relative_translation, relative_orientation))


def get_transform_with_normalized_rotation(transform: np.ndarray) -> np.ndarray:
    """Return the matrix (4, 4) with columns of the rotation part of length 1; columns of zeros stay."""
    result = np.array(transform, np.float64)
    lengths = np.linalg.norm(result[:3, :3], axis=0)
    result[:3, :3] /= np.where(lengths == 0.0, 1.0, lengths)
    return result
