"""Axis-aligned bounds that may be open on any side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdsdg.arguments.values import shown
from usdsdg.errors import ArgumentError


@dataclass(frozen=True, eq=False)
class Bounds:
    """An axis-aligned box from `lower` to `upper`, (3,) each [stage units]; infinite where there is no bound."""

    lower: np.ndarray
    upper: np.ndarray

    @classmethod
    def given(cls, min_samp: Sequence[float | None] | None, max_samp: Sequence[float | None] | None) -> Bounds:
        """Create bounds from Replicator's arguments, in which None means no bound.

        Raises:
            ArgumentError: not three numbers or None each, or a lower bound above its upper one.
        """
        bounds = cls(_side("min_samp", min_samp, -np.inf), _side("max_samp", max_samp, np.inf))
        if (bounds.lower > bounds.upper).any():
            raise ArgumentError(f"min_samp={shown(min_samp)} is above max_samp={shown(max_samp)}")
        return bounds

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Return (...) whether points (..., 3) lie within the bounds."""
        return np.all((points >= self.lower) & (points <= self.upper), axis=-1)

    def clip(self, corners: np.ndarray) -> np.ndarray:
        """Clip triangles (T, 3, 3) to the bounds; the result has triangles of the same orientation."""
        for axis in range(3):
            for sign, limit in ((1.0, self.lower[axis]), (-1.0, -self.upper[axis])):
                if np.isfinite(limit):
                    corners = _clip(corners, sign * corners[:, :, axis] - limit)
        return corners[_have_area(corners)]

    def __str__(self) -> str:
        if not (np.isfinite(self.lower).any() or np.isfinite(self.upper).any()):
            return "the world"
        return f"the bounds {self.lower.tolist()} to {self.upper.tolist()}"


def _side(name: str, given: Sequence[float | None] | None, otherwise: float) -> np.ndarray:
    values = [None] * 3 if given is None else list(given)
    try:
        side = np.array([otherwise if value is None else float(value) for value in values])
    except (TypeError, ValueError):
        side = np.zeros(0)
    if side.shape != (3,) or np.isnan(side).any():
        raise ArgumentError(f"{name} is {shown(given)}; expected three numbers, None where there is no bound")
    return side


def _have_area(corners: np.ndarray) -> np.ndarray:
    """Return (T,) False for degenerate triangles, which clipping leaves where a corner lies on a bound."""
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    longest = np.maximum((one**2).sum(1), (other**2).sum(1))
    return np.linalg.norm(np.cross(one, other), axis=1) > 1e-12 * longest


def _clip(corners: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Clip triangles to the half-space where `height`, the signed distance (T, 3) of their corners, is not negative."""
    above = height >= 0
    count = above.sum(1)
    whole = corners[count == 3]
    # One corner above: a smaller triangle. Two above: a quad, as two triangles.
    one = _single_corner_first(corners, height, count == 1, above)
    below = _single_corner_first(corners, height, count == 2, ~above)
    a, ab, ac = one
    b, ba, bc = below
    tips = np.stack([a[:, 0], ab, ac], axis=1)
    quads = [np.stack([ba, b[:, 1], b[:, 2]], axis=1), np.stack([ba, b[:, 2], bc], axis=1)]
    return np.concatenate([whole, tips, *quads])


def _single_corner_first(
    corners: np.ndarray, height: np.ndarray, chosen: np.ndarray, single: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cycle the corners of chosen triangles so that the single corner on its side of the plane comes first.

    Also returns the intersections of its two edges with the plane.
    """
    cycled, first = corners[chosen], np.argmax(single[chosen], axis=1)
    rows, order = np.arange(len(cycled))[:, None], (first[:, None] + np.arange(3)) % 3
    cycled, level = cycled[rows, order], height[chosen][rows, order]

    def intersection(other: int) -> np.ndarray:
        fraction = level[:, 0] / (level[:, 0] - level[:, other])
        return cycled[:, 0] + fraction[:, None] * (cycled[:, other] - cycled[:, 0])

    return cycled, intersection(1), intersection(2)
