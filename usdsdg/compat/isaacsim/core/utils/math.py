"""`isaacsim.core.utils.math`: vectors and angles."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["cross", "normalize", "normalized", "radians_to_degrees"]


def radians_to_degrees(rad_angles: np.ndarray) -> np.ndarray:
    return np.rad2deg(rad_angles)


def cross(a: ArrayLike, b: ArrayLike) -> np.ndarray:
    """Return the cross product of two vectors (3,)."""
    return np.cross(np.asarray(a), np.asarray(b))


def normalize(v: np.ndarray) -> np.ndarray:
    """Give a vector the length 1 in place, and return it; one of zeros stays."""
    length = np.linalg.norm(v)
    if length:
        v /= length
    return v


def normalized(v: np.ndarray | None) -> np.ndarray | None:
    """Return a copy of a vector with the length 1; None of None."""
    return None if v is None else normalize(v.copy())
