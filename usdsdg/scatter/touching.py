"""Whether two bodies share a point: bounding volumes, then triangles against triangles, then one inside the other."""

from __future__ import annotations

import numpy as np

from usdsdg.scatter.solid import BLOCK, Solid

# Block pairs whose triangles are compared at once.
_CHUNK = 128
# Bodies that only touch do not collide; share of the triangles' size that counts as touching.
_TOUCH = 1e-9
# How much smaller the first body is made, as a share of its size.
_SHRUNK = 1e-6
# Below this share of the triangles' size squared a direction is none: two edges are parallel.
_PARALLEL = 1e-12


def collide(a: Solid, b: Solid, offset: np.ndarray) -> bool:
    """Whether `a` at the origin and `b` at `offset` (3,) overlap: surfaces cross, or one lies inside the other.

    Inside is where a closed surface with its outside outwards winds around: a room with its faces inwards is empty.
    """
    return _surfaces_cross(a, b, offset) or _inside(b.anchors + offset, a) or _inside(a.anchors - offset, b)


def _surfaces_cross(a: Solid, b: Solid, offset: np.ndarray) -> bool:
    lower = np.maximum(a.lower[:3], b.lower[:3] + offset)
    upper = np.minimum(a.upper[:3], b.upper[:3] + offset)
    of_a = _blocks_in(a, lower, upper)
    of_b = _blocks_in(b, lower - offset, upper - offset)
    first, second = np.nonzero(
        (a.boxes[0][of_a][:, None] <= b.boxes[1][of_b] + offset).all(-1)
        & (b.boxes[0][of_b] + offset <= a.boxes[1][of_a][:, None]).all(-1)
    )
    first, second = of_a[first], of_b[second]
    return any(
        _blocks_cross(a, b, offset, first[start : start + _CHUNK], second[start : start + _CHUNK])
        for start in range(0, len(first), _CHUNK)
    )


def _blocks_in(solid: Solid, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    low, high = solid.boxes
    return np.flatnonzero((low <= upper).all(1) & (high >= lower).all(1))


def _blocks_cross(a: Solid, b: Solid, offset: np.ndarray, first: np.ndarray, second: np.ndarray) -> bool:
    rows = first[:, None] * BLOCK + np.arange(BLOCK)
    columns = second[:, None] * BLOCK + np.arange(BLOCK)
    # Comparisons with the NaN that fill up a block are false.
    near = (a.triangle_boxes[0][rows][:, :, None] <= (b.triangle_boxes[1][columns] + offset)[:, None]).all(-1)
    near &= ((b.triangle_boxes[0][columns] + offset)[:, None] <= a.triangle_boxes[1][rows][:, :, None]).all(-1)
    pair, i, j = np.nonzero(near)
    # Faces that lie in one plane, as those of equal boxes on a floor, only touch; a hair smaller, one lies inside.
    middle = (a.lower[:3] + a.upper[:3]) / 2
    smaller = middle + (a.corners[rows[pair, i]] - middle) * (1 - _SHRUNK)
    return bool(triangles_cross(smaller, b.corners[columns[pair, j]] + offset).any())


def triangles_cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(N,) whether triangles `a` and `b`, (N, 3, 3) each, share more than a touch, by separating axes.

    Triangles in one plane only touch.
    """
    crossing = np.ones(len(a), bool)
    if not len(a):
        return crossing
    middle = a.mean(1, keepdims=True)
    a, b = a - middle, b - middle
    size = np.maximum(np.abs(a).max((1, 2)), np.abs(b).max((1, 2)))
    edges_a, edges_b = np.roll(a, -1, axis=1) - a, np.roll(b, -1, axis=1) - b
    normal_a = np.cross(edges_a[:, 0], edges_a[:, 1])
    normal_b = np.cross(edges_b[:, 0], edges_b[:, 1])

    def separate(axes: np.ndarray) -> None:
        left = np.flatnonzero(crossing)
        crossing[left] = ~_separated(a[left], b[left], axes[left], size[left])

    separate(normal_a)
    separate(normal_b)
    for i in range(3):
        for j in range(3):
            separate(np.cross(edges_a[:, i], edges_b[:, j]))
    return crossing


def _separated(a: np.ndarray, b: np.ndarray, axes: np.ndarray, size: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(axes, axis=1)
    on_a, on_b = np.einsum("nij,nj->ni", a, axes), np.einsum("nij,nj->ni", b, axes)
    gap = np.maximum(on_b.min(1) - on_a.max(1), on_a.min(1) - on_b.max(1))
    return (gap >= -_TOUCH * size * length) & (length > _PARALLEL * size * size)


def _inside(points: np.ndarray, solid: Solid) -> bool:
    near = ((points > solid.lower[:3]) & (points < solid.upper[:3])).all(1)
    return bool(near.any()) and bool((winding(points[near], solid.corners) > 0.5).any())


def winding(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """How often a surface (T, 3, 3) winds around each point (N, 3): 1 inside a closed one, 0 outside, -1 in a room.

    Sum of the triangles' solid angles (Van Oosterom and Strackee, 1983); triangles of NaN do not count.
    """
    found = np.zeros(len(points))
    for index, point in enumerate(points):
        a, b, c = np.moveaxis(corners - point, 1, 0)
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        volume = (a * np.cross(b, c)).sum(1)
        divisor = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        found[index] = np.nansum(np.arctan2(volume, divisor)) / (2 * np.pi)
    return found
