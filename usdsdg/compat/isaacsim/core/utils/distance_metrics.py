"""`isaacsim.core.utils.distance_metrics`: how far two translations, or two rotations, are apart.

Arrays multiply columns, as in robotics: the translation is the last column. Matrices of Gf multiply rows, and are
transposed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from pxr import Gf

Pose: TypeAlias = np.ndarray | Gf.Matrix4d | Sequence[Sequence[float]]
Rotation: TypeAlias = Pose | Gf.Matrix3d

_UNIFORM = np.eye(3)

__all__ = [
    "rotational_distance_angle", "rotational_distance_identity_matrix_deviation", "rotational_distance_single_axis",
    "weighted_translational_distance",
]  # fmt: skip


def weighted_translational_distance(
    t1: Pose | Sequence[float], t2: Pose | Sequence[float], weight_matrix: np.ndarray = _UNIFORM
) -> float:
    """Return √(dᵀ W d) for the difference d of two translations (3,), or of those of poses (4, 4).

    Raises:
        ValueError: one of the arguments has another shape.
    """
    offset, weights = _translation(t1) - _translation(t2), np.asarray(weight_matrix, np.float64)
    if weights.shape != (3, 3):
        raise ValueError(f"the weight matrix has the shape {weights.shape}; expected (3, 3)")
    return float(np.sqrt(offset @ weights @ offset))


def rotational_distance_angle(r1: Rotation, r2: Rotation) -> float:
    """Return the angle [rad] of the rotation from one to the other, rotations (3, 3) or poses (4, 4).

    Raises:
        ValueError: one of them has another shape.
    """
    between = _rotation(r1) @ _rotation(r2).T
    return float(np.arccos(np.clip((np.trace(between) - 1.0) / 2.0, -1.0, 1.0)))


def rotational_distance_identity_matrix_deviation(r1: Rotation, r2: Rotation) -> float:
    """Return the Frobenius norm of I - R₁R₂ᵀ, from 0 to √8, of rotations (3, 3) or poses (4, 4).

    Raises:
        ValueError: one of them has another shape.
    """
    return float(np.linalg.norm(np.eye(3) - _rotation(r1) @ _rotation(r2).T))


def rotational_distance_single_axis(r1: Rotation, r2: Rotation, axis: np.ndarray | Sequence[float]) -> float:
    """Return the angle [rad] between where rotations (3, 3) or poses (4, 4) turn `axis` (3,), of any length.

    Raises:
        ValueError: one of them has another shape, or the axis is zero.
    """
    vector = np.asarray(axis, np.float64)
    if vector.shape != (3,):
        raise ValueError(f"the axis has the shape {vector.shape}; expected (3,)")
    if not vector.any():
        raise ValueError("the axis is zero: give a direction")
    vector = vector / np.linalg.norm(vector)
    return float(np.arccos(np.clip((_rotation(r1) @ vector) @ (_rotation(r2) @ vector), -1.0, 1.0)))


def _columns(matrix: Rotation) -> np.ndarray:
    """Return a matrix that multiplies columns."""
    array = np.asarray(matrix, np.float64)
    return array.T if isinstance(matrix, (Gf.Matrix3d, Gf.Matrix4d)) else array


def _translation(value: Pose | Sequence[float]) -> np.ndarray:
    if np.shape(value) == (4, 4):
        return _columns(value)[:3, 3]  # pyright: ignore[reportArgumentType] - the shape is that of a pose
    if np.size(value) != 3:
        raise ValueError(f"a translation has the shape {np.shape(value)}; expected (3,), or a pose (4, 4)")
    return np.asarray(value, np.float64).reshape(3)


def _rotation(value: Rotation) -> np.ndarray:
    if np.shape(value) not in ((3, 3), (4, 4)):
        raise ValueError(f"a rotation has the shape {np.shape(value)}; expected (3, 3), or a pose (4, 4)")
    return _columns(value)[:3, :3]
