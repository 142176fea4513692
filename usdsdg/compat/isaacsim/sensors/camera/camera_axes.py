"""Orientations of cameras in three conventions: "usd" (looks along -Z, +Y up), "ros" (+Z ahead, -Y up) and "world"
(+X ahead, +Z up).
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from usdsdg.errors import ArgumentError

Quaternions = NDArray[np.float64]

# Rotation (w, x, y, z) from each convention's axes to USD's.
_TO_USD = {"usd": (1.0, 0.0, 0.0, 0.0), "ros": (0.0, 1.0, 0.0, 0.0), "world": (0.5, -0.5, 0.5, 0.5)}

# Matrices (4, 4) for column vectors between the camera axes of ROS (R), USD (U) and the world (W), under Isaac Sim's
# names: U_R_TRANSFORM takes a point given along the axes of ROS to those of USD.
U_R_TRANSFORM = np.diag([1, -1, -1, 1])
R_U_TRANSFORM = U_R_TRANSFORM.T
U_W_TRANSFORM = np.array([[0, -1, 0, 0], [0, 0, 1, 0], [-1, 0, 0, 0], [0, 0, 0, 1]])
W_U_TRANSFORM = U_W_TRANSFORM.T


def from_usd(orientations: ArrayLike, axes: str, *, left: bool = False) -> Quaternions:
    """Return orientations (N, 4), w first, of USD cameras in the convention `axes`.

    left: multiply from the left, as Isaac Sim's CameraView does: the result is then turned about the axes of the world
        (or parent) and not about those of the camera.

    Raises:
        ArgumentError: there is no such convention.
    """
    return _multiplied(orientations, _turn(axes), left=left)


def to_usd(orientations: ArrayLike, axes: str, *, left: bool = False) -> Quaternions:
    """Undo `from_usd`, except with `left`: then the conventions are multiplied from the left again, as there.

    Raises:
        ArgumentError: there is no such convention.
    """
    return _multiplied(orientations, _turn(axes) * (1.0, -1.0, -1.0, -1.0), left=left)


def _turn(axes: str) -> Quaternions:
    if axes not in _TO_USD:
        raise ArgumentError(f"camera_axes is {axes!r}; expected {', '.join(sorted(_TO_USD))}")
    return np.array(_TO_USD[axes])


def _multiplied(orientations: ArrayLike, turn: Quaternions, *, left: bool) -> Quaternions:
    given = np.asarray(orientations, np.float64).reshape(-1, 4)
    a, b = (turn[None], given) if left else (given, turn[None])
    w = a[:, 0] * b[:, 0] - (a[:, 1:] * b[:, 1:]).sum(axis=1)
    xyz = a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + np.cross(a[:, 1:], b[:, 1:])
    product = np.concatenate([w[:, None], xyz], axis=1)
    # Of the two quaternions of a rotation, the one whose largest number is positive.
    largest = np.take_along_axis(product, np.abs(product).argmax(axis=1)[:, None], axis=1)
    return product * np.where(largest < 0, -1.0, 1.0)
