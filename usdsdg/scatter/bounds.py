"""A box of the world that may be open on any side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdsdg.arguments.values import shown
from usdsdg.errors import ArgumentError


@dataclass(frozen=True, eq=False)
class Bounds:
    """From `lower` to `upper`, (3,) each [stage units]; infinite where there is no bound."""

    lower: np.ndarray
    upper: np.ndarray

    @classmethod
    def given(cls, min_samp: Sequence[float | None] | None, max_samp: Sequence[float | None] | None) -> Bounds:
        """From Replicator's arguments, in which None stands for no bound.

        Raises:
            ArgumentError: not three numbers or None each, or a lower bound above its upper one.
        """
        bounds = cls(_side("min_samp", min_samp, -np.inf), _side("max_samp", max_samp, np.inf))
        if (bounds.lower > bounds.upper).any():
            raise ArgumentError(f"min_samp={shown(min_samp)} is above max_samp={shown(max_samp)}")
        return bounds

    def contain(self, points: np.ndarray) -> np.ndarray:
        """(...) whether points (..., 3) lie within."""
        return np.all((points >= self.lower) & (points <= self.upper), axis=-1)

    def cut(self, corners: np.ndarray) -> np.ndarray:
        """The parts of triangles (T, 3, 3) that lie within, as triangles of the same orientation."""
        for axis in range(3):
            for sign, limit in ((1.0, self.lower[axis]), (-1.0, -self.upper[axis])):
                if np.isfinite(limit):
                    corners = _cut(corners, sign * corners[:, :, axis] - limit)
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
    """(T,) False for what is a line or a point, as remains where a corner lies on a bound."""
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    longest = np.maximum((one**2).sum(1), (other**2).sum(1))
    return np.linalg.norm(np.cross(one, other), axis=1) > 1e-12 * longest


def _cut(corners: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Triangles where `height` (T, 3) of their corners is not negative."""
    above = height >= 0
    count = above.sum(1)
    whole = corners[count == 3]
    # One corner above: a smaller triangle. Two above: a quad, as two triangles.
    one, below = _alone_first(corners, height, count == 1, above), _alone_first(corners, height, count == 2, ~above)
    a, ab, ac = one
    b, ba, bc = below
    tips = np.stack([a[:, 0], ab, ac], axis=1)
    quads = [np.stack([ba, b[:, 1], b[:, 2]], axis=1), np.stack([ba, b[:, 2], bc], axis=1)]
    return np.concatenate([whole, tips, *quads])


def _alone_first(
    corners: np.ndarray, height: np.ndarray, chosen: np.ndarray, alone: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Chosen triangles turned so that the corner that is alone comes first, and where its two edges are cut."""
    turned, first = corners[chosen], np.argmax(alone[chosen], axis=1)
    rows, order = np.arange(len(turned))[:, None], (first[:, None] + np.arange(3)) % 3
    turned, level = turned[rows, order], height[chosen][rows, order]

    def at_zero(other: int) -> np.ndarray:
        share = level[:, 0] / (level[:, 0] - level[:, other])
        return turned[:, 0] + share[:, None] * (turned[:, other] - turned[:, 0])

    return turned, at_zero(1), at_zero(2)
