"""Points on surfaces, uniformly by area."""

import numpy as np

from usdsdg.errors import ArgumentError
from usdsdg.scatter.bounds import Bounds

# Uniform numbers that a point takes.
COMPONENTS = 3


class Surface:
    """Triangles in the world, cut to bounds."""

    def __init__(self, corners: np.ndarray, bounds: Bounds, *, offset: float = 0.0) -> None:
        """`corners` (T, 3, 3) counter-clockwise from outside; points lie `offset` [stage units] above them.

        Raises:
            ArgumentError: nothing of the surface lies within the bounds.
        """
        self._corners = bounds.cut(corners)
        a, b, c = np.moveaxis(self._corners, 1, 0)
        area_vectors = np.cross(b - a, c - a)
        areas = np.linalg.norm(area_vectors, axis=1)
        if not areas.sum() > 0:
            raise ArgumentError(f"the surface prims have no surface within {bounds}")
        self._normals = area_vectors / np.maximum(areas, 1e-300)[:, None]
        self._until = np.cumsum(areas) / areas.sum()
        self._offset = offset

    def points(self, u: np.ndarray) -> np.ndarray:
        """(..., 3) points of the world from uniform numbers (..., 3)."""
        triangle = np.minimum(np.searchsorted(self._until, u[..., 0], side="right"), len(self._until) - 1)
        root = np.sqrt(u[..., 1])
        weights = np.stack([1 - root, root * (1 - u[..., 2]), root * u[..., 2]], axis=-1)
        points = np.einsum("...k,...kj->...j", weights, self._corners[triangle])
        return points + self._offset * self._normals[triangle]
