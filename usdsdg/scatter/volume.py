"""Points in volumes, uniformly, by way of voxels."""

from collections.abc import Sequence

import numpy as np

from usdsdg.errors import ArgumentError
from usdsdg.scatter.bounds import Bounds

# Uniform numbers that a point takes.
COMPONENTS = 4
# Voxels along the longest side of the volumes' mean size.
RESOLUTION = 30
MAX_VOXELS = 20_000_000
# Points times triangles that are compared at once.
_CHUNK = 4_000_000


class Box:
    """All of a box, less what excluded volumes (T, 3, 3) take."""

    def __init__(self, bounds: Bounds, excluded: Sequence[np.ndarray] = ()) -> None:
        """Raises ArgumentError where the box is open on a side."""
        if not (np.isfinite(bounds.lower).all() and np.isfinite(bounds.upper).all()):
            raise ArgumentError(
                "without volume_prims the volume is the box from min_samp to max_samp; give all six numbers "
                f"(they say {bounds})"
            )
        self._bounds, self._excluded = bounds, excluded

    def points(self, u: np.ndarray) -> np.ndarray:
        """(..., 3) points of the world from uniform numbers (..., 4); NaN where an excluded volume is."""
        points = self._bounds.lower + u[..., 1:] * (self._bounds.upper - self._bounds.lower)
        return _without(points, np.ones(points.shape[:-1], bool), self._excluded)


class Volume:
    """Closed meshes in the world, as voxels that lie inside or on the surface of at least one of them."""

    def __init__(
        self,
        volumes: Sequence[np.ndarray],
        bounds: Bounds,
        *,
        excluded: Sequence[np.ndarray] = (),
        voxel_size: float = 0.0,
        resolution_scaling: float = 1.0,
        once: bool = True,
    ) -> None:
        """`volumes` and `excluded` are triangles (T, 3, 3) of one volume each.

        Voxels are cubes of `voxel_size` [stage units], by default the longest side of the volumes' mean size divided
        by 30 and `resolution_scaling`. Where volumes overlap, points are as dense as elsewhere if `once`, else as many
        times denser.

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
        self._bounds, self._volumes, self._excluded, self._once = bounds, volumes, excluded, once
        self._collect()

    def _collect(self) -> None:
        free = np.ones(self._shape, bool)
        for corners in self._excluded:
            inside, _ = self._voxels(corners)
            free &= ~inside
        own = [self._voxels(corners) for corners in self._volumes]
        if self._once:
            sure = np.any([inside for inside, _ in own], axis=0)
            own = [(sure, np.any([edge for _, edge in own], axis=0) & ~sure)]
        cells, owners, unsure = [], [], []
        for owner, (inside, edge) in enumerate(own):
            for voxels, doubtful in ((inside, False), (edge, True)):
                found = np.argwhere(voxels & free)
                cells.append(found)
                owners.append(np.full(len(found), owner))
                unsure.append(np.full(len(found), doubtful))
        self._cells, self._owners, self._unsure = np.concatenate(cells), np.concatenate(owners), np.concatenate(unsure)
        if not len(self._cells):
            raise ArgumentError(
                f"nothing is left to sample inside of the volume prims within {self._bounds}"
                + (" outside of volume_excl_prims" if self._excluded else "")
            )

    def points(self, u: np.ndarray) -> np.ndarray:
        """(..., 3) points of the world from uniform numbers (..., 4); NaN for those that are to be drawn again.

        A voxel at the surface may be inside in part: a point of it that lies outside is NaN.
        """
        cell = self._cell(u)
        points = self._lower + (self._cells[cell] + u[..., 1:]) * self.voxel_size
        kept = self._bounds.contain(points)
        doubtful = kept & self._unsure[cell]
        if doubtful.any():
            kept[doubtful] = self._is_inside(points[doubtful], self._owners[cell][doubtful])
        return _without(points, kept, self._excluded)

    def voxels(self, u: np.ndarray) -> np.ndarray:
        """(..., 3) middles of the voxels that `points` takes for these numbers."""
        return self._lower + (self._cells[self._cell(u)] + 0.5) * self.voxel_size

    def _cell(self, u: np.ndarray) -> np.ndarray:
        return np.minimum((u[..., 0] * len(self._cells)).astype(np.int64), len(self._cells) - 1)

    def _is_inside(self, points: np.ndarray, owners: np.ndarray) -> np.ndarray:
        if self._once:
            return np.any([inside(points, corners) for corners in self._volumes], axis=0)
        found = np.zeros(len(points), bool)
        for owner in np.unique(owners):
            found[owners == owner] = inside(points[owners == owner], self._volumes[owner])
        return found

    def _voxels(self, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Voxels wholly inside of a mesh, and those that its surface may pass through; two bool grids."""
        in_voxels = (corners - self._lower) / self.voxel_size
        edge = _touched(in_voxels, self._shape)
        return (_winding_of_middles(in_voxels, self._shape) != 0) & ~edge, edge


def _without(points: np.ndarray, kept: np.ndarray, excluded: Sequence[np.ndarray]) -> np.ndarray:
    """Points with NaN for those not kept and those in an excluded volume."""
    for corners in excluded:
        asked = np.flatnonzero(kept)
        kept.flat[asked] = ~inside(points.reshape(-1, 3)[asked], corners)
    return np.where(kept[..., None], points, np.nan)


def inside(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(N,) whether a closed mesh (T, 3, 3), its faces outwards or inwards, winds around points (N, 3).

    Counts the triangles above each point, up or down by the side that they show.
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


def _height_over(corners: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where vertical lines at `places` (N, 2) meet triangles (N, 3, 3), -inf where they do not, and the side (+1, -1)
    that a triangle shows from above."""
    a, b, c = np.moveaxis(corners[..., :2] - places[:, None], 1, 0)
    wa, wb, wc = _cross(b, c), _cross(c, a), _cross(a, b)
    area = wa + wb + wc
    # Lines through an edge belong to one of its two triangles: the side with a weight of exactly zero counts once.
    hit = (area != 0) & (((wa >= 0) & (wb >= 0) & (wc >= 0)) | ((wa <= 0) & (wb <= 0) & (wc <= 0)))
    with np.errstate(divide="ignore", invalid="ignore"):
        height = (wa * corners[:, 0, 2] + wb * corners[:, 1, 2] + wc * corners[:, 2, 2]) / area
    return np.where(hit, height, -np.inf), np.sign(area)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _touched(corners: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Voxels that the boxes around triangles overlap; corners in units of voxels."""
    # A hair wider, so that a face between two voxels makes both doubtful.
    lower = np.floor(corners.min(1) - 1e-6).astype(np.int64)
    upper = np.floor(corners.max(1) + 1e-6).astype(np.int64) + 1
    within = ((upper > 0) & (lower < shape)).all(1)
    lower, upper = np.clip(lower[within], 0, shape), np.clip(upper[within], 0, shape)
    # Counted as differences at the eight corners of each box and summed up once.
    counts = np.zeros(shape + 1, np.int64)
    for corner in range(8):
        chosen = [(upper if corner >> axis & 1 else lower)[:, axis] for axis in range(3)]
        np.add.at(counts, tuple(chosen), (-1) ** corner.bit_count())
    return counts.cumsum(0).cumsum(1).cumsum(2)[:-1, :-1, :-1] > 0


def _winding_of_middles(corners: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """How often a mesh winds around the middle of each voxel; corners in units of voxels."""
    # Columns pass a hair beside the middles, so that they do not run through the edges of regular meshes.
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
    # A crossing winds around every voxel below it.
    winding = np.zeros((*shape[:2], shape[2] + 1), np.int64)
    np.add.at(winding, (columns[:, 0], columns[:, 1], below), side.astype(np.int64))
    return winding[:, :, ::-1].cumsum(2)[:, :, ::-1][:, :, 1:]
