"""Collision test of two bodies: bounding volumes, then triangle pairs, then containment."""

import numpy as np

from usdsdg.scatter.solid import BLOCK, Solid

# Block pairs per batch: small at first, since for overlapping bodies almost any pair shows the collision.
_FIRST_BATCH, _GROWTH, _MAX_BATCH = 8, 4, 256
# Pairs of blocks whose boxes are compared at once.
_BLOCK_PAIRS = 1 << 15
# Penetration, as a fraction of the triangles' size, up to which bodies are in mere contact and do not collide.
_CONTACT_TOLERANCE = 1e-9
# Fraction of its size by which the first body is shrunk.
_SHRINK = 1e-6
# Length of a cross product, as a fraction of the triangles' squared size, below which two edges are parallel.
_PARALLEL_TOLERANCE = 1e-12


def collide(a: Solid, b: Solid, offset: np.ndarray) -> bool:
    """Whether `a` at the origin and `b` at `offset` (3,) overlap: surfaces intersect, or one lies inside the other.

    Inside means a positive winding number: a room whose faces are oriented inwards is empty.
    """
    return (
        _surfaces_cross(a, b, offset)
        or _inside(b.interior_points + offset, a)
        or _inside(a.interior_points - offset, b)
    )


def _surfaces_cross(a: Solid, b: Solid, offset: np.ndarray) -> bool:
    lower = np.maximum(a.lower[:3], b.lower[:3] + offset)
    upper = np.minimum(a.upper[:3], b.upper[:3] + offset)
    of_a = _blocks_in(a, lower, upper)
    of_b = _blocks_in(b, lower - offset, upper - offset)
    # In parts, each from everywhere in `a`: of bodies that overlap the first part shows it.
    parts = -(-len(of_a) * len(of_b) // _BLOCK_PAIRS)
    return any(_blocks_of_parts_cross(a, b, offset, of_a[part::parts], of_b) for part in range(parts))


def _blocks_of_parts_cross(a: Solid, b: Solid, offset: np.ndarray, of_a: np.ndarray, of_b: np.ndarray) -> bool:
    """Whether triangles of the blocks `of_a` and `of_b` intersect."""
    low_a, high_a = (side[of_a] for side in a.boxes)
    low_b, high_b = (side[of_b] + offset for side in b.boxes)
    first, second = np.nonzero(_overlapping(low_a[:, None], high_a[:, None], low_b[None], high_b[None]))
    first, second = of_a[first], of_b[second]
    start, count = 0, _FIRST_BATCH
    while start < len(first):
        if _blocks_cross(a, b, offset, first[start : start + count], second[start : start + count]):
            return True
        start, count = start + count, min(count * _GROWTH, _MAX_BATCH)
    return False


def _blocks_in(solid: Solid, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    low, high = solid.boxes
    return np.flatnonzero(_overlapping(low, high, lower, upper))


def _overlapping(low_a: np.ndarray, high_a: np.ndarray, low_b: np.ndarray, high_b: np.ndarray) -> np.ndarray:
    """Whether boxes (..., 3) overlap; the loop over axes is faster than a NumPy reduction over three elements."""
    found = (low_a[..., 0] <= high_b[..., 0]) & (low_b[..., 0] <= high_a[..., 0])
    for axis in (1, 2):
        found &= (low_a[..., axis] <= high_b[..., axis]) & (low_b[..., axis] <= high_a[..., axis])
    return found


def _blocks_cross(a: Solid, b: Solid, offset: np.ndarray, first: np.ndarray, second: np.ndarray) -> bool:
    rows = first[:, None] * BLOCK + np.arange(BLOCK)
    columns = second[:, None] * BLOCK + np.arange(BLOCK)
    # Comparisons with the NaN padding are false.
    low_a, high_a = (side[rows][:, :, None] for side in a.triangle_boxes)
    low_b, high_b = ((side[columns] + offset)[:, None] for side in b.triangle_boxes)
    pair, i, j = np.nonzero(_overlapping(low_a, high_a, low_b, high_b))
    if not len(pair):
        return False
    # Coplanar faces, as of equal boxes on a floor, do not count as intersecting; slightly shrunk, one lies inside.
    center = (a.lower[:3] + a.upper[:3]) / 2
    smaller = center + (a.corners[rows[pair, i]] - center) * (1 - _SHRINK)
    return bool(triangles_cross(smaller, b.corners[columns[pair, j]] + offset).any())


def triangles_cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Test triangle pairs `a` and `b`, (N, 3, 3) each, for intersection by separating axes; returns (N,) bool.

    Mere contact, and coplanar triangles, do not count.
    """
    crossing = np.zeros(len(a), bool)
    candidates = np.arange(len(a))
    center = a.mean(1, keepdims=True)
    a, b = a - center, b - center
    for axes in (_normals_of_first, _normals_of_second, _edge_products):
        kept = ~_separated(a, b, axes(a, b))
        candidates, a, b = candidates[kept], a[kept], b[kept]
        if not len(candidates):
            return crossing
    crossing[candidates] = True
    return crossing


def _normals_of_first(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return _cross(a[:, 1] - a[:, 0], a[:, 2] - a[:, 0])[:, None]


def _normals_of_second(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return _cross(b[:, 1] - b[:, 0], b[:, 2] - b[:, 0])[:, None]


def _edge_products(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return (N, 9, 3) cross products of each edge of one triangle with each edge of the other."""
    edges_a, edges_b = a[:, [1, 2, 0]] - a, b[:, [1, 2, 0]] - b
    return _cross(edges_a[:, :, None], edges_b[:, None]).reshape(len(a), 9, 3)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Compute np.cross over the last axis, without its checks."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def _separated(a: np.ndarray, b: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return (N,) whether one of the axes (N, K, 3) separates the triangles."""
    size = np.maximum(np.abs(a).max((1, 2)), np.abs(b).max((1, 2)))[:, None]
    length = np.sqrt((axes * axes).sum(-1))
    on_a, on_b = axes @ a.transpose(0, 2, 1), axes @ b.transpose(0, 2, 1)
    gap = np.maximum(on_b.min(-1) - on_a.max(-1), on_a.min(-1) - on_b.max(-1))
    return ((gap >= -_CONTACT_TOLERANCE * size * length) & (length > _PARALLEL_TOLERANCE * size * size)).any(1)


def _inside(points: np.ndarray, solid: Solid) -> bool:
    near = ((points > solid.lower[:3]) & (points < solid.upper[:3])).all(1)
    return bool(near.any()) and bool((winding(points[near], solid.corners) > 0.5).any())


def winding(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Compute the winding number of a surface (T, 3, 3) around each point (N, 3).

    1 inside a closed surface, 0 outside, -1 inside a surface whose faces are oriented inwards. Sum of the triangles'
    solid angles (Van Oosterom and Strackee, 1983); NaN triangles are ignored.
    """
    found = np.zeros(len(points))
    for index, point in enumerate(points):
        a, b, c = np.moveaxis(corners - point, 1, 0)
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        volume = (a * np.cross(b, c)).sum(1)
        divisor = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        found[index] = np.nansum(np.arctan2(volume, divisor)) / (2 * np.pi)
    return found
