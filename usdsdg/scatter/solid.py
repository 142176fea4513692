"""Collision bodies: triangles around an origin, with k-DOP bounds and a two-level tree of boxes."""

import hashlib
from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np

from usdsdg.stage.geometry.triangles import TriangleInstance, Triangles

# Slab normals of the 26-DOP that bounds a body: the axes, then the diagonals of the cube and of its faces. It rejects
# most of the pairs whose boxes overlap.
DIRECTIONS = np.array(
    [
        (1, 0, 0), (0, 1, 0), (0, 0, 1),
        (1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1),
        (1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1),
    ],
    np.float64,
)  # fmt: skip
# Triangles per block of the two-level tree.
BLOCK = 16


class Shape:
    """Triangles in their own space, sorted along a Morton curve."""

    def __init__(self, triangles: Triangles) -> None:
        self.points = triangles.points[np.unique(triangles.faces)]
        corners = triangles.corners()
        self.corners = corners[_morton_order(corners.mean(1))]


class Solid:
    """A collision body with its world rotation and scale, relative to its origin; positions are translations of it."""

    def __init__(self, parts: Sequence[tuple[Shape, np.ndarray]]) -> None:
        """`parts` are shapes with their matrices (4, 4) into the world's axes around the body's origin."""
        self._parts = parts
        spans = [np.concatenate([s.points @ m[:3, :3] + m[3, :3]]) @ DIRECTIONS.T for s, m in parts]
        # (13,) extent along DIRECTIONS; a body without triangles collides with nothing.
        self.lower = np.min([span.min(0) for span in spans], axis=0) if spans else np.full(len(DIRECTIONS), np.inf)
        self.upper = np.max([span.max(0) for span in spans], axis=0) if spans else np.full(len(DIRECTIONS), -np.inf)

    @cached_property
    def corners(self) -> np.ndarray:
        """All triangles (B * BLOCK, 3, 3); the last block of each part is padded with NaN."""
        return np.concatenate([_padded(_transformed(shape, matrix)) for shape, matrix in self._parts])

    @cached_property
    def boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper bounds (B, 3) of the blocks."""
        lower, upper = self.triangle_boxes
        # np.fmin ignores the NaN padding.
        return np.fmin.reduce(lower.reshape(-1, BLOCK, 3), axis=1), np.fmax.reduce(upper.reshape(-1, BLOCK, 3), axis=1)

    @cached_property
    def triangle_boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper bounds (B * BLOCK, 3) of the triangles."""
        return self.corners.min(1), self.corners.max(1)

    @cached_property
    def interior_points(self) -> np.ndarray:
        """One point (parts, 3) of each part: inside it if its surface is closed, else on the surface."""
        return np.array([_interior_point(_transformed(shape, matrix)) for shape, matrix in self._parts])


class Solids:
    """Factory of solids; bodies of the same shape, rotation and scale are one shared object."""

    def __init__(self, shapes: dict[bytes, Shape] | None = None) -> None:
        """`shapes` is a cache that callers keep if they scatter the same objects repeatedly."""
        self._shapes = {} if shapes is None else shapes
        self._solids: dict[bytes, Solid] = {}

    def around(self, origin: np.ndarray, gprims: Iterable[TriangleInstance]) -> Solid:
        """Return the body of all `gprims`, relative to `origin` (3,) in the world."""
        keys, parts = [], []
        for placed in gprims:
            key, shape = self._shape(placed.triangles)
            matrix = placed.to_world.copy()
            matrix[3, :3] -= origin
            keys.append(key + np.round(matrix, 9).tobytes())
            parts.append((shape, matrix))
        whole = b"".join(keys)
        if whole not in self._solids:
            self._solids[whole] = Solid(parts)
        return self._solids[whole]

    def _shape(self, triangles: Triangles) -> tuple[bytes, Shape]:
        digest = hashlib.blake2b(triangles.points.tobytes(), digest_size=16)
        digest.update(triangles.faces.tobytes())
        key = digest.digest()
        if key not in self._shapes:
            self._shapes[key] = Shape(triangles)
        return key, self._shapes[key]


def _transformed(shape: Shape, matrix: np.ndarray) -> np.ndarray:
    corners = shape.corners @ matrix[:3, :3] + matrix[3, :3]
    return corners[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else corners


def _padded(corners: np.ndarray) -> np.ndarray:
    missing = -len(corners) % BLOCK
    return np.concatenate([corners, np.full((missing, 3, 3), np.nan)])


def _morton_order(points: np.ndarray) -> np.ndarray:
    """Return the order of points along a Morton curve."""
    lower, upper = points.min(0), points.max(0)
    cells = ((points - lower) / np.maximum(upper - lower, 1e-300) * 1023).astype(np.uint64)
    code = np.zeros(len(points), np.uint64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cells[:, axis] >> np.uint64(bit)) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return np.argsort(code, kind="stable")


def _interior_point(corners: np.ndarray) -> np.ndarray:
    """Return the midpoint between the largest triangle's center and the next surface behind it.

    Without a surface behind it, the center itself.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    largest = int(np.argmax(areas))
    start, inwards = corners[largest].mean(0), -normals[largest] / max(areas[largest], 1e-300)
    # Möller-Trumbore ray test against all triangles.
    edge_1, edge_2, from_a = b - a, c - a, start - a
    p = np.cross(inwards, edge_2)
    determinant = (edge_1 * p).sum(1)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (from_a * p).sum(1) / determinant
        q = np.cross(from_a, edge_1)
        v = (q @ inwards) / determinant
        distance = (edge_2 * q).sum(1) / determinant
        hit = np.isfinite(distance) & (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 1e-9 * np.sqrt(areas[largest]))
    hit[largest] = False
    return start + inwards * distance[hit].min() / 2 if hit.any() else start
