"""Split the world matrix of a prim into the rigid frame that the solver moves and a constant remainder."""

from collections.abc import Sequence
from itertools import islice

import numpy as np
from numpy.typing import ArrayLike

from usdsdg.stage.poses.rotations import compose, decompose, quat_from_matrix

# Cosine between two axes above which a matrix shears.
_MAX_SHEAR = 1e-4
# Matrices that were split: a body and each of its colliders ask for it, and a body at rest again when it is re-read.
_MAX_KNOWN = 8192
_known: dict[tuple[bytes, float], tuple[np.ndarray, np.ndarray]] = {}


def rigid_pose(local_to_world: ArrayLike, meters_per_unit: float) -> np.ndarray:
    """Return the pose (7,) [m]: origin and rotation of a matrix (4, 4) [stage units], without scale and shear.

    The array is read-only.
    """
    return _split(np.asarray(local_to_world, np.float64).tobytes(), meters_per_unit)[0]


def pose_matrix(pose: ArrayLike, meters_per_unit: float = 1.0) -> np.ndarray:
    """Return row-vector matrices (..., 4, 4) of poses (..., 7) [m], their translation in stage units."""
    pose = np.asarray(pose, np.float64)
    return compose(pose[..., :3] / meters_per_unit, pose[..., 3:])


def body_from_prim(local_to_world: ArrayLike, meters_per_unit: float) -> np.ndarray:
    """Return the constant part of a prim's world matrix: from its local space [stage units] to its rigid frame [m].

    The array is read-only.
    """
    return _split(np.asarray(local_to_world, np.float64).tobytes(), meters_per_unit)[1]


def split_together(local_to_world: Sequence[ArrayLike], meters_per_unit: float) -> None:
    """Split matrices (N, 4, 4), of which others will ask next, in a fifteenth of the time of one after the other."""
    matrices = np.array(local_to_world, np.float64).reshape(-1, 4, 4)
    keys = [(matrix.tobytes(), meters_per_unit) for matrix in matrices]
    new = [row for row, key in enumerate(keys) if key not in _known and np.isfinite(matrices[row]).all()]
    if new:
        _known.update(zip((keys[row] for row in new), zip(*_computed(matrices[new], meters_per_unit))))
        forgotten = max(0, len(_known) - max(_MAX_KNOWN, len(keys)))
        for key in list(islice(_known, forgotten)):
            del _known[key]


def _split(matrix: bytes, meters_per_unit: float) -> tuple[np.ndarray, np.ndarray]:
    """Return rigid pose and constant part of a matrix."""
    key = matrix, meters_per_unit
    if key not in _known:
        if len(_known) >= _MAX_KNOWN:
            del _known[next(iter(_known))]
        _known[key] = _computed(np.frombuffer(matrix).reshape(4, 4), meters_per_unit)
    return _known[key]


def _computed(local_to_world: np.ndarray, meters_per_unit: float) -> tuple[np.ndarray, np.ndarray]:
    """Return rigid poses (..., 7) and constant parts (..., 4, 4) of matrices (..., 4, 4)."""
    parts = decompose(local_to_world)
    pose = np.concatenate([parts.translate * meters_per_unit, parts.rotation], axis=-1)
    local = local_to_world @ np.linalg.inv(pose_matrix(pose, meters_per_unit))
    local[..., :3, :3] *= meters_per_unit
    local[..., 3, :3] = 0.0
    for array in (pose, local):
        array.flags.writeable = False
    return pose, local


def split_scale(matrix: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Return scale (3,), rotation (3, 3) and translation (3,) of a matrix; None when it shears.

    Unlike `usdsdg.stage.poses.transforms.decompose` it puts a mirroring into the x scale alone, and refuses shear, so
    that such a shape becomes a hull.
    """
    m = np.asarray(matrix, np.float64)
    axes = m[:3, :3]
    scale = np.linalg.norm(axes, axis=1)
    if (scale < 1e-12).any():
        return None
    rotation = axes / scale[:, None]
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > _MAX_SHEAR:
        return None
    if np.linalg.det(rotation) < 0:
        scale[0], rotation[0] = -scale[0], -rotation[0]
    return scale, rotation, m[3, :3].copy()


def rotation_quat(rotation: ArrayLike) -> tuple[float, float, float, float]:
    """Return (x, y, z, w) of one row-vector rotation matrix."""
    x, y, z, w = (float(component) for component in quat_from_matrix(rotation))
    return x, y, z, w
