"""Panoramas: longitude by latitude, all around, seen from one point or from an eye that goes round a circle.

The second is omni-directional stereo: each column is seen by an eye that looks straight at it, half the eyes' distance
beside the middle of the head. `usdsdg_render/kernels/cameras/lens.py` has the same for kernels.
"""

from __future__ import annotations

import numpy as np


def places(points: np.ndarray, eye: float, *, beyond: bool = False) -> np.ndarray:
    """Shares (N, 2) of the width and height at which points (N, 3) in the camera's frame are seen.

    Args:
        eye: how far right of the middle the eye is, as it looks ahead [stage units].
        beyond: points inside of the eye's circle, which it never sees, are NaN without it, and otherwise seen as if
            they were on the circle.
    """
    level = np.hypot(points[:, 0], points[:, 2])
    # From the eye, where the ray touches the circle.
    with np.errstate(invalid="ignore"):
        reach = np.sqrt(np.maximum(level**2 - eye**2, 0.0 if beyond else -np.inf))
    turned = np.arctan2(points[:, 0], -points[:, 2]) - np.arctan2(eye, reach)
    # Back to -half a turn … half a turn, and unchanged without an eye.
    longitude = np.where(turned < -np.pi, turned + 2 * np.pi, np.where(turned > np.pi, turned - 2 * np.pi, turned))
    return np.stack([longitude / (2 * np.pi) + 0.5, 0.5 - np.arctan2(points[:, 1], reach) / np.pi], axis=1)


def directions(shares: np.ndarray) -> np.ndarray:
    """Unit directions (N, 3) at shares (N, 2) of the width and height."""
    longitude, latitude = (shares[:, 0] - 0.5) * 2 * np.pi, (0.5 - shares[:, 1]) * np.pi
    level = np.cos(latitude)
    return np.stack([level * np.sin(longitude), np.sin(latitude), -level * np.cos(longitude)], axis=1)


def origins(shares: np.ndarray, eye: float) -> np.ndarray:
    """Where (N, 3) in the camera's frame the eye is that looks at shares (N, 2) of the picture."""
    longitude = (shares[:, 0] - 0.5) * 2 * np.pi
    return eye * np.stack([np.cos(longitude), 0.0 * longitude, np.sin(longitude)], axis=1)
