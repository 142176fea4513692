"""Lenses that a picture of directions describes: from its texels to directions by bilinear lookup, and exactly back.

`usdsdg_render/kernels/cameras/lens_table.py` has the same for kernels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

# Width and height of the map of directions that says where the search for a direction's texel begins.
START_SIZE = 128
# How many texels, about, are told apart there: the search begins a few texels off.
_KNOWN = 1 << 14
# How much of a lookup may come from texels that let no light in, and how far off the picture it may lie.
DARK = 1e-3
_STEPS = 40
# Texels: a step as short is the last.
_STILL = 1e-10
# How many texels around the lit ones have directions as well, for searches to walk through.
RINGS = 4


@dataclass(frozen=True, eq=False)
class LensTable:
    """Directions in the camera's frame at the middles of texels: places (0, 0) to (width - 1, height - 1).

    texels: (height, width, 4) float32, at least 2 x 2: direction, and 1 where light comes in. Where none does, the last
        is 0, and the direction that to which those beside it go on, or 0.
    """

    texels: np.ndarray

    @classmethod
    def of(cls, directions: np.ndarray, lit: np.ndarray) -> LensTable:
        """The table of unit directions (height, width, 3) where (height, width) `lit` is true."""
        texels = np.zeros((*lit.shape, 4), np.float32)
        texels[lit, :3], texels[lit, 3] = directions[lit], 1.0
        known = lit.copy()
        for _ in range(RINGS):
            _grow(texels[..., :3], known)
        return cls(texels)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [texels]."""
        return self.texels.shape[1], self.texels.shape[0]

    def to_directions(self, places: np.ndarray) -> np.ndarray:
        """Unit directions (N, 3) at places (N, 2); NaN where no light comes in.

        Half a texel around the middles of the outermost ones the directions go on as they change there.
        """
        seen = self._look_up(places)[0]
        directions = seen[:, :3] / np.maximum(np.linalg.norm(seen[:, :3], axis=1, keepdims=True), 1e-30)
        return np.where(self._is_lit(places, seen)[:, None], directions, np.nan)

    def to_places(self, directions: np.ndarray, *, beyond: bool = False) -> np.ndarray:
        """Places (N, 2) whose direction is that of (N, 3), of any length.

        Where there is none it is NaN; with `beyond`, it is one out of what is lit, on the side of the direction.
        """
        length = np.linalg.norm(directions, axis=1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            targets = directions / length
        known = np.flatnonzero(np.isfinite(targets).all(axis=1))
        places = np.full((len(directions), 2), np.nan)
        places[known] = self._search(targets[known])
        if beyond:
            missing = known[np.isnan(places[known, 0])]
            places[missing] = self._beyond(targets[missing])
        return places

    @cached_property
    def starts(self) -> np.ndarray:
        """(START_SIZE, START_SIZE, 2) float32: a lit place whose direction is close to that of an octahedral map."""
        # Imported where it is needed: it takes long, and few scenes have such a lens.
        from scipy.spatial import cKDTree

        lit = self.texels[..., 3] > 0
        step = max(1, int(np.sqrt(lit.sum() / _KNOWN)))
        rows, columns = np.nonzero(lit[::step, ::step])
        if not len(rows):  # so few are lit that steps miss them
            step, (rows, columns) = 1, np.nonzero(lit)
        rows, columns = rows * step, columns * step
        middles = (np.arange(START_SIZE) + 0.5) / START_SIZE * 2.0 - 1.0
        x, y = np.meshgrid(middles, middles)
        _, nearest = cKDTree(self.texels[rows, columns, :3]).query(unfolded(np.stack([x, y], axis=-1).reshape(-1, 2)))
        places = np.stack([columns, rows], axis=1)[nearest].astype(np.float32)
        return places.reshape(START_SIZE, START_SIZE, 2)

    def _start(self, targets: np.ndarray) -> np.ndarray:
        cells = np.clip((folded(targets) * 0.5 + 0.5) * START_SIZE, 0, START_SIZE - 1).astype(np.int64)
        return self.starts[cells[:, 1], cells[:, 0]].astype(np.float64)

    def _beyond(self, targets: np.ndarray) -> np.ndarray:
        """From the closest place that is lit, outwards by the angle that is missing."""
        places = self._start(targets)
        missing = np.arccos(np.clip(np.einsum("ij,ij->i", self.to_directions(places), targets), -1.0, 1.0))
        outwards = places - (np.array(self.size) - 1) / 2.0
        outwards /= np.maximum(np.linalg.norm(outwards, axis=1, keepdims=True), 1e-9)
        return places + outwards * (1.0 + missing[:, None] / np.pi) * max(self.size)

    def _search(self, targets: np.ndarray) -> np.ndarray:
        """Newton's steps from the starts; on their way they may leave what is lit."""
        places = self._start(targets)
        # Two axes across each target, along which the miss is measured.
        other = np.where(np.abs(targets[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
        first = np.cross(targets, other)
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        axes = np.stack([first, np.cross(targets, first)], axis=1)
        result, going = np.full(places.shape, np.nan), np.arange(len(targets))
        most = np.array(self.size) - 1.0 + RINGS
        for _ in range(_STEPS):
            step = self._step(places, axes[going])
            places = np.clip(places - step, -RINGS, most)
            size = np.abs(step).max(axis=1, initial=0.0)
            done = np.flatnonzero(size < _STILL)
            seen = self._look_up(places[done])[0]
            ahead = np.einsum("ij,ij->i", seen[:, :3], targets[going[done]]) > 0
            found = done[ahead & self._is_lit(places[done], seen)]
            result[going[found]] = places[found]
            going, places = going[size >= _STILL], places[size >= _STILL]
            if not len(going):
                break
        return result

    def _step(self, places: np.ndarray, axes: np.ndarray) -> np.ndarray:
        """How far (N, 2) places (N, 2) are off, of directions with `axes` (N, 2, 3) across; NaN where they tell
        nothing."""
        seen, across, down = self._look_up(places)
        miss = np.einsum("ikj,ij->ki", axes, seen[:, :3])
        (a, c), (b, d) = (np.einsum("ikj,ij->ki", axes, slope[:, :3]) for slope in (across, down))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.stack([d * miss[0] - b * miss[1], a * miss[1] - c * miss[0]], axis=1) / (a * d - b * c)[:, None]

    def _look_up(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Texels (N, 4) between texels, and their slopes along rows and along columns."""
        with np.errstate(invalid="ignore"):
            corner = np.floor(np.nan_to_num(places))
        x, y = np.clip(corner, 0, np.array(self.size) - 2).astype(np.int64).T
        u, v = (places - np.stack([x, y], axis=1)).T[..., None]
        a, b, c, d = (self.texels[y + j, x + i].astype(np.float64) for j in (0, 1) for i in (0, 1))
        above, below = a + (b - a) * u, c + (d - c) * u
        return above + (below - above) * v, (b - a) + ((d - c) - (b - a)) * v, below - above

    def _is_lit(self, places: np.ndarray, seen: np.ndarray) -> np.ndarray:
        with np.errstate(invalid="ignore"):
            inside = ((places > -0.5 - DARK) & (places < np.array(self.size) - 0.5 + DARK)).all(axis=1)
            return inside & (np.abs(seen[:, 3] - 1.0) < DARK)


def _grow(directions: np.ndarray, known: np.ndarray) -> None:
    """Let directions (height, width, 3) go on, in straight lines, to the texels beside those that are `known`."""
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


def folded(directions: np.ndarray) -> np.ndarray:
    """Octahedral coordinates (N, 2), from -1 to 1, of directions (N, 3): straight ahead, -Z, is in the middle."""
    flat = directions[:, :2] / np.abs(directions).sum(axis=1, keepdims=True)
    signs = np.where(flat >= 0, 1.0, -1.0)
    return np.where(directions[:, 2:] > 0, (1.0 - np.abs(flat[:, ::-1])) * signs, flat)


def unfolded(flat: np.ndarray) -> np.ndarray:
    """Unit directions (N, 3) of octahedral coordinates (N, 2)."""
    ahead = 1.0 - np.abs(flat).sum(axis=1)
    signs = np.where(flat >= 0, 1.0, -1.0)
    across = np.where(ahead[:, None] < 0, (1.0 - np.abs(flat[:, ::-1])) * signs, flat)
    directions = np.concatenate([across, -ahead[:, None]], axis=1)
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)
