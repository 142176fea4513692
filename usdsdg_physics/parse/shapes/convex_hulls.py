"""Convex hulls of meshes: at most 64 vertices, cached by content, never without volume."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from usdsdg.errors import warn_once
from usdsdg_physics.parse.shapes.convex_decomposition import Splitting, convex_parts
from usdsdg_physics.parse.shapes.mesh_triangles import TrianglesCache, digest
from usdsdg_physics.scene.records import Solid

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull

SPLITTING_LABEL = "splitting meshes into convex parts"
# Newton's own limit; its narrow phase visits every vertex of a hull in each support query.
MAX_HULL_VERTICES = 64
# Relative to the largest extent. A flatter hull has no mass to speak of and a contact normal of noise.
MIN_THICKNESS = 1e-3
# Part of the volume of its hull that a mesh may leave empty without a word.
_EMPTY = 0.01
# Hulls that a process keeps, about 4 kB each: the next stage mostly has the same assets.
_MOST_KNOWN = 4096


class _Hull(NamedTuple):
    solid: Solid
    volume: float  # with all vertices; zero of flat points
    is_flat: bool


_known: dict[bytes, _Hull] = {}  # by the `digest` of their points


class HullCache:
    """Convex hulls and meshes by the content of their points: a thousand references to one asset make one hull."""

    def __init__(self, *, progress: Callable[[str, int, int | None], None] | None = None) -> None:
        """`progress` is called with a label and a number before each mesh that is split, which takes seconds."""
        self._progress, self._split = progress, 0
        self._parts: dict[tuple[bytes, Splitting], list[np.ndarray]] = {}
        self._hulls: dict[bytes, _Hull] = {}
        self._fills: dict[bytes, bool] = {}  # whether the hull of a mesh fills hollows
        self._filled: list[str] = []
        self._meshes: dict[bytes, Solid] = {}
        self.triangles = TrianglesCache()

    def hull(self, points: np.ndarray, *, prim_path: str = "", key: bytes | None = None) -> Solid:
        """Return the convex hull (at most 64 vertices) of points (N, 3).

        Flat, straight or single points are thickened to a thousandth of their extent, with a warning that names
        `prim_path`. `key` is the `digest` of the points, float32; None: not known.

        Raises:
            ValueError: there are no finite points.
        """
        return self._hull(points, prim_path, key).solid

    def note_filled(self, points: np.ndarray, triangles: np.ndarray, prim_path: str) -> None:
        """Note that a mesh collides as its hull, unless the two are the same but for a hundredth of the volume.

        A mesh that is not closed is not known to be the same; one that is flat has a warning of its own.
        """
        key = digest(points, triangles)
        if key not in self._fills:
            volume = self._hull(points, prim_path).volume
            self._fills[key] = abs(abs(solid(points, triangles).volume) - volume) > _EMPTY * volume > 0.0
        if self._fills[key]:
            self._filled.append(prim_path)

    def take_filled(self) -> list[str]:
        """Return the paths that `note_filled` has noted since the last call."""
        found, self._filled = list(dict.fromkeys(self._filled)), []
        return found

    def _hull(self, points: np.ndarray, prim_path: str, key: bytes | None = None) -> _Hull:
        points = np.ascontiguousarray(points, np.float32).reshape(-1, 3)
        key = key or digest(points)
        if key not in self._hulls:
            hull = self._hulls[key] = _known_hull(points, key)
            if hull.is_flat:
                warn_once(
                    f"{prim_path or 'a mesh'} is flat, so its convex hull has no volume; the collider is made "
                    f"{MIN_THICKNESS:.1%} of its size thick. Model it with a thickness to choose another.",
                    key=f"flat hull {prim_path}",
                )
        return self._hulls[key]

    def parts(
        self, points: np.ndarray, triangles: np.ndarray, splitting: Splitting, *, prim_path: str = ""
    ) -> list[Solid]:
        """Return the hulls of the convex parts of a mesh; none where it cannot be split."""
        points = np.ascontiguousarray(points, np.float32).reshape(-1, 3)
        triangles = np.ascontiguousarray(triangles, np.int32).reshape(-1, 3)
        key = digest(points, triangles), splitting
        if key not in self._parts:
            self._parts[key] = convex_parts(points, triangles, splitting, prim_path=prim_path, on_split=self._tell)
        return [self.hull(part, prim_path=prim_path) for part in self._parts[key]]

    def _tell(self) -> None:
        """Report that one more mesh is being split."""
        self._split += 1
        if self._progress:
            self._progress(SPLITTING_LABEL, self._split, None)

    def mesh(self, points: np.ndarray, triangles: np.ndarray) -> Solid:
        """Return the triangles themselves, for colliders that keep them."""
        points = np.ascontiguousarray(points, np.float32).reshape(-1, 3)
        triangles = np.ascontiguousarray(triangles, np.int32).reshape(-1, 3)
        key = digest(points, triangles)
        if key not in self._meshes:
            self._meshes[key] = solid(points, triangles)
        return self._meshes[key]


def is_flat(points: np.ndarray) -> bool:
    """Return whether points have nearly no extent in a direction of their own."""
    points = np.asarray(points, np.float64)
    return _thickened(points) is not points


def solid(vertices: np.ndarray, triangles: np.ndarray) -> Solid:
    """Return a `Solid` with the volume integrals of its triangles (exact for closed, outward-oriented surfaces)."""
    vertices = np.ascontiguousarray(vertices, np.float32)
    triangles = np.ascontiguousarray(triangles, np.int32)
    # Tetrahedra from a point near the middle keep the sums well conditioned far from the origin.
    middle = vertices.mean(axis=0, dtype=np.float64)
    a, b, c = (vertices[triangles[:, corner]].astype(np.float64) - middle for corner in range(3))
    sixth = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    total = a + b + c
    volume = float(sixth.sum())
    first = np.einsum("i,ij->j", sixth, total) / 4.0
    second = sum(np.einsum("i,ij,ik->jk", sixth, corner, corner) for corner in (a, b, c, total)) / 20.0
    centroid = first / volume if abs(volume) > 0.0 else np.zeros(3)
    # Move the second moment from the middle to the origin.
    covariance = second + np.outer(first, middle) + np.outer(middle, first) + volume * np.outer(middle, middle)
    key = digest(vertices, triangles).hex()
    return Solid(key, vertices, triangles, volume, centroid + middle, covariance)


def inertia_from_covariance(covariance: np.ndarray) -> np.ndarray:
    """Return the inertia tensor of unit density from the integral of p pᵀ."""
    return np.trace(covariance) * np.eye(3) - covariance


def _known_hull(points: np.ndarray, key: bytes) -> _Hull:
    """Return the hull of points, found once in a process."""
    if key not in _known:
        if len(_known) >= _MOST_KNOWN:
            del _known[next(iter(_known))]
        _known[key] = _hull(points)
    return _known[key]


def _hull(points: np.ndarray) -> _Hull:
    points = np.unique(points[np.isfinite(points).all(axis=1)], axis=0).astype(np.float64)
    if not len(points):
        raise ValueError("no finite points")
    thick = _thickened(points)
    is_flat = thick is not points
    thick, hull, volume = _capped(thick)
    triangles = hull.simplices.copy()
    a, b, c = (thick[triangles[:, corner]] for corner in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    used, renumbered = np.unique(triangles, return_inverse=True)
    return _Hull(solid(thick[used], renumbered.reshape(triangles.shape)), 0.0 if is_flat else volume, is_flat)


def _capped(points: np.ndarray) -> tuple[np.ndarray, ConvexHull, float]:
    """Return points, their hull with at most `MAX_HULL_VERTICES` vertices, and the volume of that of all points."""
    from scipy.spatial import ConvexHull, QhullError

    from usdsdg_physics.parse.shapes.hull_vertices import spread_over

    try:
        whole = ConvexHull(points, qhull_options="Qt")
        kept = spread_over(points[whole.vertices], MAX_HULL_VERTICES)
        return kept, ConvexHull(kept, qhull_options="Qt"), float(whole.volume)
    except QhullError:  # nearly flat in a direction of its own
        # TA counts the points added to the first tetrahedron; QJ moves points a little.
        hull = ConvexHull(points, qhull_options=f"Qt TA{MAX_HULL_VERTICES - 4} QJ")
        return points, hull, float(hull.volume)


def _thickened(points: np.ndarray) -> np.ndarray:
    """Return the points, or copies of them moved both ways along every direction in which they have no extent."""
    centered = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centered.T @ centered)
    spread = centered @ axes
    extent = spread.max(axis=0) - spread.min(axis=0)
    largest = float(extent.max()) or 1e-3
    for axis, size in zip(axes.T, extent):
        if size < MIN_THICKNESS * largest:
            offset = axis * (MIN_THICKNESS * largest - size) / 2.0
            points = np.concatenate([points - offset, points + offset])
    return points
