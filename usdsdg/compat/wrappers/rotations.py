"""Rotations as Isaac Sim's helpers have them: matrices for column vectors, quaternions (w, x, y, z), Euler angles.

Angles are about x, y and z: extrinsic ones turn about the fixed axes x, y, z in this order, R = Rz Ry Rx; intrinsic
ones about the moving axes, R = Rx Ry Rz.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from usdsdg.compat.wrappers.poses import wxyz, xyzw
from usdsdg.stage.poses.rotations import matrix_from_euler, matrix_from_quat, quat_from_matrix

_ORDERS = {True: "XYZ", False: "ZYX"}


def matrix_of_euler(angles: ArrayLike, *, degrees: bool, extrinsic: bool) -> np.ndarray:
    """Return matrices (..., 3, 3) of angles (..., 3)."""
    given = np.asarray(angles, np.float64)
    # USD's matrices are for row vectors.
    return matrix_from_euler(given if degrees else np.degrees(given), _ORDERS[extrinsic]).swapaxes(-1, -2)


def euler_of_matrix(matrix: ArrayLike, *, degrees: bool, extrinsic: bool, zero: str = "x") -> np.ndarray:
    """Return the angles (..., 3) of matrices (..., 3, 3); where y is ±90° the angle about `zero`, "x" or "z", is 0."""
    m = np.asarray(matrix, np.float64)
    if extrinsic:
        sine, level = -m[..., 2, 0], np.hypot(m[..., 0, 0], m[..., 1, 0])
        roll = np.arctan2(m[..., 2, 1], m[..., 2, 2])
        yaw = np.arctan2(m[..., 1, 0], m[..., 0, 0])
        other = np.arctan2(-m[..., 0, 1], m[..., 1, 1])
        locked = (0.0, other) if zero == "x" else (-np.sign(sine) * other, 0.0)
    else:
        sine, level = m[..., 0, 2], np.hypot(m[..., 0, 0], m[..., 0, 1])
        roll = np.arctan2(-m[..., 1, 2], m[..., 2, 2])
        yaw = np.arctan2(-m[..., 0, 1], m[..., 0, 0])
        locked = (
            (0.0, np.arctan2(m[..., 1, 0], m[..., 1, 1]))
            if zero == "x"
            else (np.arctan2(m[..., 2, 1], m[..., 1, 1]), 0.0)
        )
    upright = level < 1e-6
    pitch = np.arctan2(sine, level)
    angles = np.stack([np.where(upright, locked[0], roll), pitch, np.where(upright, locked[1], yaw)], -1)
    return np.degrees(angles) if degrees else angles


def quat_of_matrix(matrix: ArrayLike) -> np.ndarray:
    """Return unit quaternions (..., 4), w >= 0, of matrices (..., 3, 3)."""
    return wxyz(quat_from_matrix(np.asarray(matrix, np.float64)[..., :3, :3].swapaxes(-1, -2)))


def matrix_of_quat(quat: ArrayLike) -> np.ndarray:
    """Return matrices (..., 3, 3) of quaternions (..., 4) of any length but 0."""
    return matrix_from_quat(xyzw(np.asarray(quat, np.float64))).swapaxes(-1, -2)


def multiplied(first: ArrayLike, second: ArrayLike) -> np.ndarray:
    """Return the products (..., 4) of quaternions: the rotation `second`, then `first`."""
    (w, x, y, z), (p, q, r, s) = (np.moveaxis(np.asarray(each, np.float64), -1, 0) for each in (first, second))
    product = (w * p - x * q - y * r - z * s, w * q + x * p + y * s - z * r,
               w * r - x * s + y * p + z * q, w * s + x * r - y * q + z * p)  # fmt: skip
    return np.stack(product, -1)
