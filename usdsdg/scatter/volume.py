"""Uniform sampling of points in volumes, by voxelization."""

from collections.abc import Sequence

import numpy as np

from usdsdg.errors import ArgumentError
from usdsdg.scatter.bounds import Bounds

# Uniform numbers per point.
COMPONENTS = 4
# Voxels along the longest side of the volumes' mean size.
RESOLUTION = 30
MAX_VOXELS = 20_000_000
# Point-triangle pairs per batch.
_CHUNK = 4_000_000


class Box:
    """A box without the excluded volumes (T, 3, 3)."""

    def __init__(self, bounds: Bounds, excluded: Sequence[np.ndarray] = ()) -> None:
        """Raises ArgumentError if the bounds are open on any side."""
        if not (np.isfinite(bounds.lower).all() and np.isfinite(bounds.upper).all()):
            raise ArgumentError(
                "without volume_prims the volume is the box from min_samp to max_samp; give all six numbers "
                f"(they say {bounds})"
            )
        self._bounds, self._excluded = bounds, excluded

    def points(self, u: np.ndarray) -> np.ndarray:
        """Map uniform numbers (..., 4) to world points (..., 3); NaN for points in an excluded volume."""
        points = self._bounds.lower + u[..., 1:] * (self._bounds.upper - self._bounds.lower)
        return _without(points, np.ones(points.shape[:-1], bool), self._excluded)


class Volume:
    """The union of closed world meshes, as voxels inside or on the surface of at least one of them."""

    def __init__(
        self,
        volumes: Sequence[np.ndarray],
        bounds: Bounds,
        *,
        excluded: Sequence[np.ndarray] = (),
        voxel_size: float = 0.0,
        resolution_scaling: float = 1.0,
        prevent_overlap: bool = True,
    ) -> None:
        """`volumes` and `excluded` are triangles (T, 3, 3) of one volume each.

        Voxels are cubes of `voxel_size` [stage units], by default the longest side of the volumes' mean size divided
        by 30 and `resolution_scaling`. Where volumes overlap, the density of points is the same as elsewhere if
        `prevent_overlap`, else multiplied by the number of overlapping volumes.

        Raises:
            ArgumentError: nothing lies inside the volumes, within the bounds and outside the excluded volumes; or there
                would be more than MAX_VOXELS.
        """
        sizes = np.array([corners.max((0, 1)) - corners.min((0, 1)) for corners in volumes])
        self.voxel_size = voxel_size or float(sizes.mean(0).max()) / (RESOLUTION * resolution_scaling)
        lowest = np.min([corners.min((0, 1)) for corners in volumes], axis=0)
        highest = np.max([corners.max((0, 1)) for corners in volumes], axis=0)
        self._lower = np.maximum(lowest, bounds.lower)
        room = np.minimum(highest, bounds.upper) - self._lower
        if not ((room >= 0).all() and self.voxel_size > 0):
            raise ArgumentError(f"no volume lies within {bounds}")
        self._shape = np.maximum(np.ceil(room / self.voxel_size), 1).astype(np.int64)
        if self._shape.prod() > MAX_VOXELS:
            raise ArgumentError(
                f"voxels of {self.voxel_size:g} make {self._shape.prod():,} of them; use a larger voxel_size or a "
                "smaller resolution_scaling"
            )
        self._bounds, self._volumes, self._excluded, self._prevent_overlap = bounds, volumes, excluded, prevent_overlap
        self._collect()

    def _collect(self) -> None:
        free = np.ones(self._shape, bool)
        for corners in self._excluded:
            inside, _ = self._voxelize(corners)
            free &= ~inside
        grids = [self._voxelize(corners) for corners in self._volumes]
        if self._prevent_overlap:
            interior = np.any([inside for inside, _ in grids], axis=0)
            grids = [(interior, np.any([boundary for _, boundary in grids], axis=0) & ~interior)]
        cells, owners, on_boundary = [], [], []
        for owner, (inside, boundary) in enumerate(grids):
            for voxels, is_boundary in ((inside, False), (boundary, True)):
                found = np.argwhere(voxels & free)
                cells.append(found)
                owners.append(np.full(len(found), owner))
                on_boundary.append(np.full(len(found), is_boundary))
        self._cells, self._owners = np.concatenate(cells), np.concatenate(owners)
        self._on_boundary = np.concatenate(on_boundary)
        if not len(self._cells):
            raise ArgumentError(
                f"nothing is left to sample inside of the volume prims within {self._bounds}"
                + (" outside of volume_excl_prims" if self._excluded else "")
            )

    def points(self, u: np.ndarray) -> np.ndarray:
        """Map uniform numbers (..., 4) to world points (..., 3); NaN for rejected points, which must be drawn again.

        Points of boundary voxels are rejected if they lie outside the meshes.
        """
        cell = self._cell(u)
        points = self._lower + (self._cells[cell] + u[..., 1:]) * self.voxel_size
        kept = self._bounds.contains(points)
        uncertain = kept & self._on_boundary[cell]
        if uncertain.any():
            kept[uncertain] = self._is_inside(points[uncertain], self._owners[cell][uncertain])
        return _without(points, kept, self._excluded)

    def voxels(self, u: np.ndarray) -> np.ndarray:
        """Return the centers (..., 3) of the voxels from which `points` samples for these numbers."""
        return self._lower + (self._cells[self._cell(u)] + 0.5) * self.voxel_size

    def _cell(self, u: np.ndarray) -> np.ndarray:
        return np.minimum((u[..., 0] * len(self._cells)).astype(np.int64), len(self._cells) - 1)

    def _is_inside(self, points: np.ndarray, owners: np.ndarray) -> np.ndarray:
        if self._prevent_overlap:
            return np.any([inside(points, corners) for corners in self._volumes], axis=0)
        found = np.zeros(len(points), bool)
        for owner in np.unique(owners):
            found[owners == owner] = inside(points[owners == owner], self._volumes[owner])
        return found

    def _voxelize(self, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return two bool grids: voxels entirely inside a mesh, and boundary voxels that its surface may intersect."""
        in_voxels = (corners - self._lower) / self.voxel_size
        boundary = _boundary_voxels(in_voxels, self._shape)
        return (_winding_at_centers(in_voxels, self._shape) != 0) & ~boundary, boundary


def _without(points: np.ndarray, kept: np.ndarray, excluded: Sequence[np.ndarray]) -> np.ndarray:
    """Set points to NaN that are not kept or lie in an excluded volume."""
    for corners in excluded:
        rows = np.flatnonzero(kept)
        kept.flat[rows] = ~inside(points.reshape(-1, 3)[rows], corners)
    return np.where(kept[..., None], points, np.nan)


def inside(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Test whether points (N, 3) are inside a closed mesh (T, 3, 3) of either orientation; returns (N,) bool.

    The winding number is the signed count of intersections with a vertical ray from each point.
    """
    found = np.zeros(len(points), bool)
    lower, upper = corners.min(1), corners.max(1)
    step = max(1, _CHUNK // max(1, len(corners)))
    for start in range(0, len(points), step):
        part = points[start : start + step, None]
        over = ((part[..., :2] >= lower[:, :2]) & (part[..., :2] < upper[:, :2])).all(-1) & (part[..., 2] < upper[:, 2])
        row, triangle = np.nonzero(over)
        height, side = _height_over(corners[triangle], points[start + row, :2])
        above = height > points[start + row, 2]
        found[start : start + step] = np.bincount(row[above], side[above], minlength=len(part)) != 0
    return found


def _height_over(corners: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Intersect vertical lines at `columns` (N, 2) with triangles (N, 3, 3).

    Returns the heights, -inf for lines that miss, and the orientation (+1, -1) of the triangles seen from above.
    """
    a, b, c = np.moveaxis(corners[..., :2] - columns[:, None], 1, 0)
    wa, wb, wc = _cross(b, c), _cross(c, a), _cross(a, b)
    area = wa + wb + wc
    # A line through a shared edge has an exact weight of zero in both triangles and counts as a hit in each.
    hit = (area != 0) & (((wa >= 0) & (wb >= 0) & (wc >= 0)) | ((wa <= 0) & (wb <= 0) & (wc <= 0)))
    with np.errstate(divide="ignore", invalid="ignore"):
        height = (wa * corners[:, 0, 2] + wb * corners[:, 1, 2] + wc * corners[:, 2, 2]) / area
    return np.where(hit, height, -np.inf), np.sign(area)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _boundary_voxels(corners: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Return the voxels that the bounding boxes of triangles overlap, as a bool grid; corners in units of voxels."""
    # Slightly enlarged, so that a face between two voxels marks both as boundary.
    lower = np.floor(corners.min(1) - 1e-6).astype(np.int64)
    upper = np.floor(corners.max(1) + 1e-6).astype(np.int64) + 1
    within = ((upper > 0) & (lower < shape)).all(1)
    lower, upper = np.clip(lower[within], 0, shape), np.clip(upper[within], 0, shape)
    # Summed-volume table: differences at the eight corners of each box, accumulated once.
    counts = np.zeros(shape + 1, np.int64)
    for corner in range(8):
        chosen = [(upper if corner >> axis & 1 else lower)[:, axis] for axis in range(3)]
        np.add.at(counts, tuple(chosen), (-1) ** corner.bit_count())
    return counts.cumsum(0).cumsum(1).cumsum(2)[:-1, :-1, :-1] > 0


def _winding_at_centers(corners: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Compute the winding number of a mesh around the center of each voxel; corners in units of voxels."""
    # Columns are slightly off the centers, so that they do not pass through the edges of regular meshes.
    jitter = np.array([0.5 + 1.37e-7, 0.5 + 2.71e-7])
    lower = np.clip(np.ceil(corners[..., :2].min(1) - jitter), 0, shape[:2]).astype(np.int64)
    upper = np.clip(np.floor(corners[..., :2].max(1) - jitter) + 1, 0, shape[:2]).astype(np.int64)
    extent = np.maximum(upper - lower, 0)
    count = extent.prod(1)
    triangle = np.repeat(np.arange(len(corners)), count)
    step = np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count)
    width = np.maximum(extent[triangle, 1], 1)
    columns = lower[triangle] + np.stack([step // width, step % width], axis=1)
    height, side = _height_over(corners[triangle], columns + jitter)
    below = np.clip(np.ceil(np.where(np.isfinite(height), height, 0.0) - 0.5), 0, shape[2]).astype(np.int64)
    below[~np.isfinite(height)] = 0
    # An intersection adds to the winding number of every voxel below it.
    winding = np.zeros((*shape[:2], shape[2] + 1), np.int64)
    np.add.at(winding, (columns[:, 0], columns[:, 1], below), side.astype(np.int64))
    return winding[:, :, ::-1].cumsum(2)[:, :, ::-1][:, :, 1:]
