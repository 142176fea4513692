"""`isaacsim.core.utils.numpy.transformations`: many poses at once, as float32 NumPy arrays.

Quaternions are (w, x, y, z), matrices of poses are for column vectors, those of parents for row vectors as in USD.
`device` is ignored: there is only the CPU.
"""

import numpy as np
from numpy.typing import ArrayLike

from usdsdg.compat.isaacsim.core.utils.numpy.rotations import wxyz2xyzw
from usdsdg.compat.isaacsim.core.utils.transformations import tf_matrices_from_poses as _matrices
from usdsdg.compat.wrappers.poses import wxyz
from usdsdg.stage.poses.rotations import decompose

__all__ = ["assign_pose", "get_local_from_world", "get_pose", "get_world_from_local", "tf_matrices_from_poses"]


def tf_matrices_from_poses(translations: ArrayLike, orientations: ArrayLike, device: object = None) -> np.ndarray:
    """Return the matrices (N, 4, 4) of positions (N, 3) and quaternions (N, 4)."""
    return _matrices(np.asarray(translations), np.asarray(orientations))


def get_local_from_world(
    parent_transforms: ArrayLike, positions: ArrayLike, orientations: ArrayLike, device: object = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return translations (N, 3) and quaternions (N, 4) in the spaces of parents (N, 4, 4) of poses in the world."""
    to_world = _transposed(parent_transforms)
    return _poses(np.linalg.inv(to_world) @ tf_matrices_from_poses(positions, orientations))


def get_world_from_local(
    parent_transforms: ArrayLike, translations: ArrayLike, orientations: ArrayLike, device: object = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (N, 3) and quaternions (N, 4) in the world of poses in the spaces of parents (N, 4, 4)."""
    return _poses(_transposed(parent_transforms) @ tf_matrices_from_poses(translations, orientations))


def get_pose(positions: ArrayLike, orientations: ArrayLike, device: object = None) -> np.ndarray:
    """Return poses (N, 7): positions, and quaternions in the order in which they are given."""
    return np.concatenate([np.asarray(positions), np.asarray(orientations)], axis=-1)


def assign_pose(
    current_positions: ArrayLike,
    current_orientations: ArrayLike,
    positions: ArrayLike | None,
    orientations: ArrayLike | None,
    indices: ArrayLike,
    device: object = None,
    pose: object = None,
) -> np.ndarray:
    """Return the poses (N, 7) of current ones, with others at some indices; quaternions as (x, y, z, w) in the result.

    positions, orientations: of the indices; None: as they are. pose: not read.
    """
    poses, rows = get_pose(current_positions, wxyz2xyzw(current_orientations)), np.asarray(indices)
    if positions is not None:
        poses[rows, :3] = positions
    if orientations is not None:
        poses[rows, 3:] = wxyz2xyzw(orientations)
    return poses


def _transposed(matrices: ArrayLike) -> np.ndarray:
    return np.asarray(matrices, np.float64).swapaxes(-1, -2)


def _poses(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    pose = decompose(matrices.swapaxes(-1, -2))
    return pose.translate.astype(np.float32), wxyz(pose.rotation).astype(np.float32)
