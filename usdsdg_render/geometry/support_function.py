"""Support functions of shapes, tabulated: tight bounds of a shape in any direction, for any rotation of it.

The support function of a shape, the largest p · d over its points p, is convex in the direction d. Interpolation
between tabulated directions is therefore never too small, and hardly too large on a grid that is fine enough.
"""

import numpy as np

# Cells along an edge of the cube map of directions.
CELLS = 4
SUPPORT_SHAPE = (6, CELLS + 1, CELLS + 1)  # of a table
_POINTS_AT_ONCE = 1 << 12  # fit into the CPU's cache


def _grid() -> np.ndarray:
    """(*SUPPORT_SHAPE, 3) directions of the grid nodes on each face of the cube: +x, -x, +y, …"""
    steps = np.linspace(-1.0, 1.0, CELLS + 1)
    faces = np.empty((*SUPPORT_SHAPE, 3))
    for face in range(6):
        axis = face // 2
        faces[face, ..., axis] = 1.0 if face % 2 == 0 else -1.0
        faces[face, ..., (axis + 1) % 3] = steps[:, None]
        faces[face, ..., (axis + 2) % 3] = steps
    return faces


# Opposite nodes share an axis, over which both extremes are found at once. Of each node: its axis, and whether it
# points along it.
_NODES = _grid().reshape(-1, 3)
_FORWARD = (_NODES @ (100.0, 10.0, 1.0)) > 0.0
_AXES, _AXIS = np.unique(np.where(_FORWARD[:, None], _NODES, -_NODES), axis=0, return_inverse=True)
# Rounding may make p · d too small by this fraction of the shape's size.
_ROUNDING = 1e-6


def support_table(points: np.ndarray) -> np.ndarray:
    """Tabulate the support function of (V, 3) points, V > 0: float64 of shape SUPPORT_SHAPE."""
    lower, upper = points.min(0).astype(np.float64), points.max(0).astype(np.float64)
    middle = (lower + upper) / 2
    a, b, c = _AXES.astype(np.float32).T[:, :, None]
    least, most = np.full(len(_AXES), np.inf), np.full(len(_AXES), -np.inf)
    for first in range(0, len(points), _POINTS_AT_ONCE):
        x, y, z = (points[first : first + _POINTS_AT_ONCE] - middle).astype(np.float32).T
        along = a * x + b * y + c * z  # not a matrix product: BLAS would wait for threads
        np.minimum(least, along.min(1), out=least)
        np.maximum(most, along.max(1), out=most)
    table = np.where(_FORWARD, most[_AXIS], -least[_AXIS]) + _NODES @ middle + _ROUNDING * (upper - lower).sum()
    return table.reshape(SUPPORT_SHAPE)
