"""Equirectangular panoramas, from one point or for one eye of omni-directional stereo.

In omni-directional stereo the rays of each column start at an eye that looks along the column's direction, half of the
distance between the eyes beside the camera's position: the eye positions form a circle.
`usdsdg_render/kernels/cameras/lens.py` has the same for kernels.
"""

import numpy as np


def image_fractions(points: np.ndarray, eye_offset: float, *, extrapolate: bool = False) -> np.ndarray:
    """Project points (N, 3) in the camera's frame to fractions (N, 2) of the image's width and height.

    Args:
        eye_offset: offset of the eye to the right of the forward direction [stage units].
        extrapolate: project points inside of the circle of eye positions, which no ray reaches, as if they were on the
            circle; otherwise they are NaN.
    """
    level = np.hypot(points[:, 0], points[:, 2])
    # Distance from the eye: the ray is tangent to the circle.
    with np.errstate(invalid="ignore"):
        distance = np.sqrt(np.maximum(level**2 - eye_offset**2, 0.0 if extrapolate else -np.inf))
    angle = np.arctan2(points[:, 0], -points[:, 2]) - np.arctan2(eye_offset, distance)
    # Wrapped to [-pi, pi]; angles within that range keep their bits.
    longitude = np.where(angle < -np.pi, angle + 2 * np.pi, np.where(angle > np.pi, angle - 2 * np.pi, angle))
    return np.stack([longitude / (2 * np.pi) + 0.5, 0.5 - np.arctan2(points[:, 1], distance) / np.pi], axis=1)


def directions(fractions: np.ndarray) -> np.ndarray:
    """Return the unit directions (N, 3) at fractions (N, 2) of the width and height."""
    longitude, latitude = (fractions[:, 0] - 0.5) * 2 * np.pi, (0.5 - fractions[:, 1]) * np.pi
    level = np.cos(latitude)
    return np.stack([level * np.sin(longitude), np.sin(latitude), -level * np.cos(longitude)], axis=1)


def origins(fractions: np.ndarray, eye_offset: float) -> np.ndarray:
    """Return the ray origins (N, 3), in the camera's frame, at fractions (N, 2) of the width and height."""
    longitude = (fractions[:, 0] - 0.5) * 2 * np.pi
    return eye_offset * np.stack([np.cos(longitude), 0.0 * longitude, np.sin(longitude)], axis=1)
