"""The vertices of a convex hull that a smaller hull keeps, so that it lies close to the whole one on all sides."""

from itertools import product

import numpy as np
from scipy.spatial import ConvexHull

# Faces, edges and corners of a box: their support points keep the extents of the shape and its symmetry.
_DIRECTIONS = np.array([side for side in product((-1.0, 0.0, 1.0), repeat=3) if any(side)])
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)
# Relative to the largest extent: what lies closer to the smaller hull counts as on it.
_TOLERANCE = 1e-6


def spread_over(vertices: np.ndarray, most: int) -> np.ndarray:
    """Return at most `most` of the vertices (N, 3) of a convex hull: extremes first, then those farthest outside.

    A quarter as many as there are is added at a time, each the farthest vertex beyond a face of the hull so far.
    Qhull's own cap (`TA`) leaves a whole side without vertices: 8 % of its diameter is cut off a sphere, by this 4 %.

    Raises:
        scipy.spatial.QhullError: the extremes lie in one plane.
    """
    if len(vertices) <= most:
        return vertices
    tolerance = _TOLERANCE * float(np.ptp(vertices, axis=0).max())
    chosen = list(dict.fromkeys(_along(vertices, _DIRECTIONS).argmax(axis=0).tolist()))
    while len(chosen) < most:
        farthest = _outside(vertices, ConvexHull(vertices[chosen], qhull_options="Qt"), tolerance)
        if not farthest:
            break
        chosen += farthest[: min(max(1, len(chosen) // 4), most - len(chosen))]
    return vertices[chosen]


def _outside(vertices: np.ndarray, hull: ConvexHull, tolerance: float) -> list[int]:
    """Return the vertices that are the farthest beyond a face of the hull, farthest first."""
    beyond = _along(vertices, hull.equations[:, :3]) + hull.equations[:, 3]
    farthest = beyond.argmax(axis=0)
    distances = beyond[farthest, np.arange(len(farthest))]
    order = np.argsort(-distances, kind="stable")
    return list(dict.fromkeys(farthest[order[distances[order] > tolerance]].tolist()))


def _along(vertices: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return the coordinates (N, D) of vertices along directions; without BLAS, whose threads and bits vary."""
    x, y, z = directions.T
    return vertices[:, :1] * x + vertices[:, 1:2] * y + vertices[:, 2:] * z
