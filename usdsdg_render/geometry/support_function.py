"""How far shapes reach in any direction: tight boxes around them however they are turned.

The reach of a shape, the largest p · d of its points, is convex in d. So where d lies between directions whose reaches
are known, what is interpolated between them is never too small, and on a grid fine enough hardly too large.
"""

from __future__ import annotations

import numpy as np

# Cells along an edge of the cube of directions.
CELLS = 4
SUPPORT = (6, CELLS + 1, CELLS + 1)  # shape of a table of reaches
_POINTS_AT_ONCE = 1 << 12  # what stays in a cache


def _grid() -> np.ndarray:
    """(*SUPPORT, 3) directions to the nodes of the grid on each face of the cube: +x, -x, +y, …"""
    steps = np.linspace(-1.0, 1.0, CELLS + 1)
    faces = np.empty((*SUPPORT, 3))
    for face in range(6):
        axis = face // 2
        faces[face, ..., axis] = 1.0 if face % 2 == 0 else -1.0
        faces[face, ..., (axis + 1) % 3] = steps[:, None]
        faces[face, ..., (axis + 2) % 3] = steps
    return faces


# Opposite nodes share a line. Of each node: which line, and whether it looks along it.
_NODES = _grid().reshape(-1, 3)
_FORWARD = (_NODES @ (100.0, 10.0, 1.0)) > 0.0
_LINES, _LINE = np.unique(np.where(_FORWARD[:, None], _NODES, -_NODES), axis=0, return_inverse=True)
# A rounded p · d may be this share of the shape's size too small.
_ROUNDING = 1e-6


def support(points: np.ndarray) -> np.ndarray:
    """A table, float64 in the shape SUPPORT: the reaches of (V, 3) points toward the nodes of the grid, V > 0."""
    lower, upper = points.min(0).astype(np.float64), points.max(0).astype(np.float64)
    middle = (lower + upper) / 2
    a, b, c = _LINES.astype(np.float32).T[:, :, None]
    least, most = np.full(len(_LINES), np.inf), np.full(len(_LINES), -np.inf)
    for first in range(0, len(points), _POINTS_AT_ONCE):
        x, y, z = (points[first : first + _POINTS_AT_ONCE] - middle).astype(np.float32).T
        along = a * x + b * y + c * z  # a product of matrices would wait for threads
        np.minimum(least, along.min(1), out=least)
        np.maximum(most, along.max(1), out=most)
    reaches = np.where(_FORWARD, most[_LINE], -least[_LINE]) + _NODES @ middle + _ROUNDING * (upper - lower).sum()
    return reaches.reshape(SUPPORT)
