"""Uniform sampling of points on surfaces."""

import numpy as np

from usdsdg.errors import ArgumentError
from usdsdg.scatter.bounds import Bounds

# Uniform numbers per point.
COMPONENTS = 3


class Surface:
    """World triangles, clipped to bounds."""

    def __init__(self, corners: np.ndarray, bounds: Bounds, *, offset: float = 0.0) -> None:
        """`corners` (T, 3, 3) are counter-clockwise from outside; points lie `offset` [stage units] above them.

        Raises:
            ArgumentError: no part of the surface is within the bounds.
        """
        self._corners = bounds.clip(corners)
        a, b, c = np.moveaxis(self._corners, 1, 0)
        area_vectors = np.cross(b - a, c - a)
        areas = np.linalg.norm(area_vectors, axis=1)
        if not areas.sum() > 0:
            raise ArgumentError(f"the surface prims have no surface within {bounds}")
        self._normals = area_vectors / np.maximum(areas, 1e-300)[:, None]
        self._cumulative_area = np.cumsum(areas) / areas.sum()
        self._offset = offset

    def points(self, u: np.ndarray) -> np.ndarray:
        """Map uniform numbers (..., 3) to world points (..., 3)."""
        found = np.searchsorted(self._cumulative_area, u[..., 0], side="right")
        triangle = np.minimum(found, len(self._cumulative_area) - 1)
        root = np.sqrt(u[..., 1])
        weights = np.stack([1 - root, root * (1 - u[..., 2]), root * u[..., 2]], axis=-1)
        points = np.einsum("...k,...kj->...j", weights, self._corners[triangle])
        return points + self._offset * self._normals[triangle]
