"""Find the connected pieces of a mesh that are convex as they are, such as the boards of a crate."""

from __future__ import annotations

import numpy as np

from usdsdg_physics.scene.triangles import is_closed

# Part of the volume of its hull that a piece may leave empty: rounding of its points.
_EMPTY = 1e-3


def convex_pieces(
    points: np.ndarray, triangles: np.ndarray, most: int, most_corners: int
) -> tuple[list[np.ndarray], np.ndarray]:
    """Return the pieces of a mesh that are closed and convex, and the triangles of all others.

    Triangles are connected by the points that they share, and then, in what is left, also by points at one place.

    Args:
        points: (N, 3) float32.
        triangles: (F, 3) int32.
        most: where there are more pieces than this, there are none; nor where faces of some look inward, as in hollows.
        most_corners: pieces whose hull has more corners are left with the others.

    Returns:
        Of each piece the corners of its hull, (V, 3) float32; and (G, 3) int32.
    """
    places, place_of = np.unique(points, axis=0, return_inverse=True)
    found, rest, inward = [], triangles, set()
    for where, number_of in ((points, np.arange(len(points))), (places, place_of.reshape(-1))):
        numbers, piece_of = _connected(number_of[rest], len(where))
        if len(found) + len(numbers) > most:
            continue
        left = np.ones(len(rest), bool)
        for number in numbers:
            own = piece_of == number
            corners = number_of[rest[own]]
            if not is_closed(corners):
                continue
            volume, part = _solid(where.astype(np.float64), corners)
            inward.add(volume < 0.0)
            if part is not None and len(part) <= most_corners:
                found.append(part)
                left &= ~own
        rest = rest[left]
    return (found, rest) if len(inward) < 2 else ([], triangles)


def _connected(triangles: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of the pieces, and that of each triangle."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    edges = triangles[:, [0, 1, 1, 2]].reshape(-1, 2)
    graph = coo_matrix((np.ones(len(edges), bool), edges.T), shape=(count, count))
    piece_of = connected_components(graph, directed=False)[1][triangles[:, 0]]
    return np.unique(piece_of), piece_of


def _solid(points: np.ndarray, triangles: np.ndarray) -> tuple[float, np.ndarray | None]:
    """Return the volume of a closed piece, below zero where its faces look inward, and the corners of its hull.

    These are None unless it fills its hull.
    """
    from scipy.spatial import ConvexHull, QhullError

    own = points[np.unique(triangles)]
    a, b, c = (points[triangles[:, k]] - own[0] for k in range(3))
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0
    try:
        hull = ConvexHull(own)
    except (QhullError, ValueError):  # flat
        return volume, None
    if abs(hull.volume - abs(volume)) > _EMPTY * hull.volume:
        return volume, None
    return volume, own[hull.vertices].astype(np.float32)
