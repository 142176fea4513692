"""Lenses described by a texture of directions: bilinear lookup, and its exact inverse.

`usdsdg_render/kernels/cameras/lens_table.py` has the same for kernels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

# Width and height of the octahedral map of start positions for the inverse search.
START_SIZE = 128
# Approximate number of texels that the map distinguishes: the search starts within a few texels of the solution.
_CANDIDATES = 1 << 14
# Largest weight of dark texels in a lookup, and largest distance [texels] of a lookup from the image.
DARK_TOLERANCE = 1e-3
_NEWTON_STEPS = 40
_CONVERGED = 1e-10  # length of a step [texels]
# Width [texels] of the border around lit texels that has extrapolated directions, so that searches can cross it.
EXTRAPOLATED_RINGS = 4


@dataclass(frozen=True, eq=False)
class LensTable:
    """Directions in the camera's frame at texel centers, which have the coordinates (0, 0) to (width - 1, height - 1).

    texels: (height, width, 4) float32, at least 2 x 2: direction, and 1 where light enters. Dark texels have 0 there,
        and a direction that is extrapolated from their neighbors, or 0.
    """

    texels: np.ndarray

    @classmethod
    def of(cls, directions: np.ndarray, lit: np.ndarray) -> LensTable:
        """Make a table of unit directions (height, width, 3), valid where `lit` (height, width) is true."""
        texels = np.zeros((*lit.shape, 4), np.float32)
        texels[lit, :3], texels[lit, 3] = directions[lit], 1.0
        known = lit.copy()
        for _ in range(EXTRAPOLATED_RINGS):
            _extrapolate(texels[..., :3], known)
        return cls(texels)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [texels]."""
        return self.texels.shape[1], self.texels.shape[0]

    def to_directions(self, positions: np.ndarray) -> np.ndarray:
        """Return the unit directions (N, 3) at texel coordinates (N, 2); NaN where no light enters.

        In the outer half of the outermost texels directions are extrapolated.
        """
        seen = self._look_up(positions)[0]
        directions = seen[:, :3] / np.maximum(np.linalg.norm(seen[:, :3], axis=1, keepdims=True), 1e-30)
        return np.where(self._is_lit(positions, seen)[:, None], directions, np.nan)

    def to_texels(self, directions: np.ndarray, *, extrapolate: bool = False) -> np.ndarray:
        """Return the texel coordinates (N, 2) of directions (N, 3), of any length.

        Directions outside of the field of view are NaN; with `extrapolate` they get coordinates outside of the lit
        area, on the side of the direction.
        """
        length = np.linalg.norm(directions, axis=1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            targets = directions / length
        known = np.flatnonzero(np.isfinite(targets).all(axis=1))
        positions = np.full((len(directions), 2), np.nan)
        positions[known] = self._search(targets[known])
        if extrapolate:
            missing = known[np.isnan(positions[known, 0])]
            positions[missing] = self._outside(targets[missing])
        return positions

    @cached_property
    def start_map(self) -> np.ndarray:
        """(START_SIZE, START_SIZE, 2) float32 octahedral map: coordinates of a lit texel of a similar direction."""
        # Imported here because it is slow to import, and few scenes have such a lens.
        from scipy.spatial import cKDTree

        lit = self.texels[..., 3] > 0
        step = max(1, int(np.sqrt(lit.sum() / _CANDIDATES)))
        rows, columns = np.nonzero(lit[::step, ::step])
        if not len(rows):  # the stride misses all of a few lit texels
            step, (rows, columns) = 1, np.nonzero(lit)
        rows, columns = rows * step, columns * step
        middles = (np.arange(START_SIZE) + 0.5) / START_SIZE * 2.0 - 1.0
        x, y = np.meshgrid(middles, middles)
        _, nearest = cKDTree(self.texels[rows, columns, :3]).query(
            from_octahedral(np.stack([x, y], axis=-1).reshape(-1, 2))
        )
        positions = np.stack([columns, rows], axis=1)[nearest].astype(np.float32)
        return positions.reshape(START_SIZE, START_SIZE, 2)

    def _start(self, targets: np.ndarray) -> np.ndarray:
        cells = np.clip((to_octahedral(targets) * 0.5 + 0.5) * START_SIZE, 0, START_SIZE - 1).astype(np.int64)
        return self.start_map[cells[:, 1], cells[:, 0]].astype(np.float64)

    def _outside(self, targets: np.ndarray) -> np.ndarray:
        """Move outwards from the closest lit texel, in proportion to the angle between its direction and the target."""
        positions = self._start(targets)
        missing = np.arccos(np.clip(np.einsum("ij,ij->i", self.to_directions(positions), targets), -1.0, 1.0))
        outwards = positions - (np.array(self.size) - 1) / 2.0
        outwards /= np.maximum(np.linalg.norm(outwards, axis=1, keepdims=True), 1e-9)
        return positions + outwards * (1.0 + missing[:, None] / np.pi) * max(self.size)

    def _search(self, targets: np.ndarray) -> np.ndarray:
        """Invert the lookup by Newton's method; the steps may cross dark texels."""
        positions = self._start(targets)
        # Two axes perpendicular to each target, along which the residual is measured.
        helper = np.where(np.abs(targets[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
        first = np.cross(targets, helper)
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        axes = np.stack([first, np.cross(targets, first)], axis=1)
        result, active = np.full(positions.shape, np.nan), np.arange(len(targets))
        upper = np.array(self.size) - 1.0 + EXTRAPOLATED_RINGS
        for _ in range(_NEWTON_STEPS):
            step = self._step(positions, axes[active])
            positions = np.clip(positions - step, -EXTRAPOLATED_RINGS, upper)
            size = np.abs(step).max(axis=1, initial=0.0)
            done = np.flatnonzero(size < _CONVERGED)
            seen = self._look_up(positions[done])[0]
            ahead = np.einsum("ij,ij->i", seen[:, :3], targets[active[done]]) > 0
            found = done[ahead & self._is_lit(positions[done], seen)]
            result[active[found]] = positions[found]
            active, positions = active[size >= _CONVERGED], positions[size >= _CONVERGED]
            if not len(active):
                break
        return result

    def _step(self, positions: np.ndarray, axes: np.ndarray) -> np.ndarray:
        """Return the Newton step (N, 2) at coordinates (N, 2), for residuals along `axes` (N, 2, 3); may be NaN."""
        seen, across, down = self._look_up(positions)
        residual = np.einsum("ikj,ij->ki", axes, seen[:, :3])
        (a, c), (b, d) = (np.einsum("ikj,ij->ki", axes, slope[:, :3]) for slope in (across, down))
        with np.errstate(divide="ignore", invalid="ignore"):
            return (
                np.stack([d * residual[0] - b * residual[1], a * residual[1] - c * residual[0]], axis=1)
                / (a * d - b * c)[:, None]
            )

    def _look_up(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Interpolate texels (N, 4), with their derivatives along rows and along columns."""
        with np.errstate(invalid="ignore"):
            corner = np.floor(np.nan_to_num(positions))
        x, y = np.clip(corner, 0, np.array(self.size) - 2).astype(np.int64).T
        u, v = (positions - np.stack([x, y], axis=1)).T[..., None]
        a, b, c, d = (self.texels[y + j, x + i].astype(np.float64) for j in (0, 1) for i in (0, 1))
        above, below = a + (b - a) * u, c + (d - c) * u
        return above + (below - above) * v, (b - a) + ((d - c) - (b - a)) * v, below - above

    def _is_lit(self, positions: np.ndarray, seen: np.ndarray) -> np.ndarray:
        with np.errstate(invalid="ignore"):
            inside = (
                (positions > -0.5 - DARK_TOLERANCE) & (positions < np.array(self.size) - 0.5 + DARK_TOLERANCE)
            ).all(axis=1)
            return inside & (np.abs(seen[:, 3] - 1.0) < DARK_TOLERANCE)


def _extrapolate(directions: np.ndarray, known: np.ndarray) -> None:
    """Extrapolate directions (height, width, 3) linearly, in place, to the neighbors of `known` texels."""
    height, width = known.shape
    beside = np.zeros_like(known)
    beside[1:] |= known[:-1]
    beside[:-1] |= known[1:]
    beside[:, 1:] |= known[:, :-1]
    beside[:, :-1] |= known[:, 1:]
    y, x = np.nonzero(beside & ~known)
    total, count = np.zeros((len(y), 3)), np.zeros((len(y), 1))
    for down, across in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        near = np.clip(y + down, 0, height - 1), np.clip(x + across, 0, width - 1)
        far = np.clip(y + 2 * down, 0, height - 1), np.clip(x + 2 * across, 0, width - 1)
        line = known[near] & known[far]
        total[line] += 2.0 * directions[near][line] - directions[far][line]
        count[line] += 1.0
    there = count[:, 0] > 0
    directions[y[there], x[there]] = total[there] / count[there]
    known[y[there], x[there]] = True


def to_octahedral(directions: np.ndarray) -> np.ndarray:
    """Return the octahedral coordinates (N, 2), from -1 to 1, of directions (N, 3); -Z, the view axis, is at (0, 0)."""
    flat = directions[:, :2] / np.abs(directions).sum(axis=1, keepdims=True)
    signs = np.where(flat >= 0, 1.0, -1.0)
    return np.where(directions[:, 2:] > 0, (1.0 - np.abs(flat[:, ::-1])) * signs, flat)


def from_octahedral(flat: np.ndarray) -> np.ndarray:
    """Return the unit directions (N, 3) of octahedral coordinates (N, 2)."""
    ahead = 1.0 - np.abs(flat).sum(axis=1)
    signs = np.where(flat >= 0, 1.0, -1.0)
    across = np.where(ahead[:, None] < 0, (1.0 - np.abs(flat[:, ::-1])) * signs, flat)
    directions = np.concatenate([across, -ahead[:, None]], axis=1)
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)
