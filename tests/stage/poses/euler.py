"""Matrices of Euler angles, which tests compare poses with."""

import numpy as np
from numpy.typing import ArrayLike

from usdsdg.stage.poses.rotations import Array, compose, matrix_from_euler


def compose_euler(
    translate: ArrayLike = (0.0, 0.0, 0.0), degrees: ArrayLike = (0.0, 0.0, 0.0), scale: ArrayLike = (1.0, 1.0, 1.0)
) -> Array:
    """Return matrices (..., 4, 4) of the ops translate, rotateXYZ, scale; arguments broadcast."""
    rotation = np.zeros((*np.shape(degrees)[:-1], 4, 4))
    rotation[..., :3, :3] = matrix_from_euler(degrees)
    rotation[..., 3, 3] = 1.0
    return compose(scale=scale) @ rotation @ compose(translate)
