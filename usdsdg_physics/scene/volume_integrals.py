"""Volumes and moments of boxes and round shapes in closed form."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from usdsdg_physics.scene.records import ShapeKind, Vec3


class VolumeIntegrals(NamedTuple):
    """Integrals over the volume of a solid, about the origin."""

    volume: float
    centroid: np.ndarray  # (3,)
    covariance: np.ndarray  # (3, 3) integral of p pᵀ

    def mapped(self, matrix: np.ndarray) -> VolumeIntegrals:
        """Return those of the solid after the row-vector 3x3 `matrix`."""
        scale = abs(float(np.linalg.det(matrix)))
        return VolumeIntegrals(self.volume * scale, self.centroid @ matrix, matrix.T @ self.covariance @ matrix * scale)


def of_primitive(kind: ShapeKind, size: Vec3) -> VolumeIntegrals:
    """Return the integrals of a primitive in its own frame; zeros of a plane. `size` is that of a `Shape`."""
    a, b, c = size
    if kind == "box":
        return _symmetric(8.0 * a * b * c, a * a / 3.0, b * b / 3.0, c * c / 3.0)
    if kind == "sphere":
        return _symmetric(4.0 / 3.0 * np.pi * a**3, a * a / 5.0, a * a / 5.0, a * a / 5.0)
    if kind == "cylinder":
        return _symmetric(2.0 * np.pi * a * a * b, a * a / 4.0, a * a / 4.0, b * b / 3.0)
    if kind == "capsule":
        barrel, caps = 2.0 * np.pi * a * a * b, 4.0 / 3.0 * np.pi * a**3
        across = barrel * a * a / 4.0 + caps * a * a / 5.0
        along = barrel * b * b / 3.0 + caps * (a * a / 5.0 + b * b + 0.75 * a * b)
        volume = barrel + caps
        return _symmetric(volume, across / volume, across / volume, along / volume)
    if kind == "cone":
        height = 2.0 * b
        volume = np.pi * a * a * height / 3.0
        center = np.array([0.0, 0.0, -height / 4.0])
        central = volume * np.diag([3.0 * a * a / 20.0, 3.0 * a * a / 20.0, 3.0 * height * height / 80.0])
        return VolumeIntegrals(volume, center, central + volume * np.outer(center, center))
    return VolumeIntegrals(0.0, np.zeros(3), np.zeros((3, 3)))


def _symmetric(volume: float, xx: float, yy: float, zz: float) -> VolumeIntegrals:
    return VolumeIntegrals(volume, np.zeros(3), volume * np.diag([xx, yy, zz]))
