"""Rotations that make cameras, lights and other prims face a point, whole batches at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from usdsdg.errors import DegenerateFrame

# Sine of the angle between view and up below which the two count as parallel.
_PARALLEL = 1e-9


def facing(eyes: ArrayLike, targets: ArrayLike, up: ArrayLike, *, stage_up_axis: str = "Z") -> NDArray[np.float64]:
    """Rotation matrices (N, 3, 3), row vectors, that turn -Z towards the targets with +Y upwards.

    `eyes` and `targets` are (N, 3) points of one space and `up` is one direction of it, or one per eye. A view along
    `up` has no upright picture: as in Replicator the eye then counts as moved a hair along +X (Z-up stages) or +Z
    (Y-up stages), so that a camera above its target shows -X (Z-up) or -Z (Y-up) at the top.

    Raises:
        DegenerateFrame: an eye is at its target, or `up` is the zero vector.
    """
    eyes, targets = np.broadcast_arrays(np.asarray(eyes, np.float64), np.asarray(targets, np.float64))
    up = np.broadcast_to(np.asarray(up, np.float64), eyes.shape)
    back = eyes - targets
    distance, height = np.linalg.norm(back, axis=-1), np.linalg.norm(up, axis=-1)
    if not np.all(height > 0):
        raise DegenerateFrame("look_at_up_axis is the zero vector; give a direction such as (0, 0, 1)")
    same = ~(distance > 1e-12 * np.maximum(1.0, np.abs(eyes).max(-1)))
    if same.any():
        raise DegenerateFrame(
            f"a prim at {tuple(eyes[same][0].tolist())} cannot look at its own position; move it or the target"
        )
    back, up = back / distance[..., None], up / height[..., None]
    right = np.cross(up, back)
    for nudge in _nudges(stage_up_axis):
        parallel = np.linalg.norm(right, axis=-1) < _PARALLEL
        right[parallel] = np.cross(up[parallel], nudge)
    right /= np.linalg.norm(right, axis=-1, keepdims=True)
    return np.stack([right, np.cross(back, right), back], -2)


def _nudges(stage_up_axis: str) -> NDArray[np.float64]:
    """Directions to move an eye that looks along `up`; the second is for an `up` along the first."""
    x, z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    return np.array([z, x] if stage_up_axis == "Y" else [x, z])
