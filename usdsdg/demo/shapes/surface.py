"""Polygon surfaces of one material: transform, merge, build from grids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Surface:
    """Polygons of one material, wound counter-clockwise seen from outside.

    points   (N, 3) float64, meters
    counts   (F,)   int, corners of each face
    indices  (K,)   int, point of each corner
    normals  (K, 3) float64, unit, one per corner
    st       (K, 2) float64, one per corner; t grows upwards in the texture
    material        name of a material of the asset
    """

    points: np.ndarray
    counts: np.ndarray
    indices: np.ndarray
    normals: np.ndarray
    st: np.ndarray
    material: str

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Surface:
        return replace(self, points=self.points + np.array([x, y, z]))

    def scaled(self, x: float = 1.0, y: float = 1.0, z: float = 1.0) -> Surface:
        """Scale along the axes; factors must be positive, so that the winding stays."""
        factors = np.array([x, y, z])
        return replace(self, points=self.points * factors, normals=unit(self.normals / factors))

    def rotated(self, axis: str, degrees: float) -> Surface:
        turn = rotation(axis, degrees)
        return replace(self, points=self.points @ turn.T, normals=self.normals @ turn.T)


def rotation(axis: str, degrees: float) -> np.ndarray:
    """(3, 3) matrix for column vectors, right-handed, about the axis "x", "y" or "z"."""
    angle = np.radians(degrees)
    cos, sin = np.cos(angle), np.sin(angle)
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[first, first] = matrix[second, second] = cos
    matrix[first, second], matrix[second, first] = -sin, sin
    return matrix


def unit(vectors: np.ndarray) -> np.ndarray:
    """Normalize vectors along the last axis; zero vectors stay zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)


def joined(surfaces: Sequence[Surface]) -> Surface:
    """Merge surfaces into one, with the material of the first."""
    offsets = np.cumsum([0] + [len(surface.points) for surface in surfaces[:-1]])
    return Surface(
        points=np.concatenate([surface.points for surface in surfaces]),
        counts=np.concatenate([surface.counts for surface in surfaces]),
        indices=np.concatenate([surface.indices + offset for surface, offset in zip(surfaces, offsets)]),
        normals=np.concatenate([surface.normals for surface in surfaces]),
        st=np.concatenate([surface.st for surface in surfaces]),
        material=surfaces[0].material,
    )


def from_grid(points: np.ndarray, normals: np.ndarray, st: np.ndarray, material: str) -> Surface:
    """Build quads over a (rows, columns) grid of points (…, 3), normals (…, 3) and st (…, 2).

    The outside is the direction of (next column) x (next row). Quads with two coincident corners, as at the
    pole of a lathe, become triangles.
    """
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], axis=-1).reshape(-1, 4)
    flat = points.reshape(-1, 3)
    corners = flat[quads]
    keep = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2) > 1e-9
    keep[keep.sum(axis=1) < 3] = False
    counts = keep.sum(axis=1)
    indices = quads[keep]
    return Surface(
        points=flat,
        counts=counts[counts > 0],
        indices=indices,
        normals=normals.reshape(-1, 3)[indices],
        st=st.reshape(-1, 2)[indices],
        material=material,
    )
