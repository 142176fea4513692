"""The radial part of lens models: one growing function of one number, and its inverse.

What the number t and the value are depends on the lens (see `lenses.Lens`): an angle from the axis, its tangent, a
distance from the center.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

ODD, POWER, RATIONAL, SINE, HALF_SINE = "odd", "power", "rational", "sine", "half_sine"
# A rational curve without an end of its own ends here: the tangent of 89.9 degrees.
STEEPEST = 500.0
# More than any angle, tangent or number of pixels that a lens has to do with.
_FARTHEST = 1e4
_STEPS = 100


@dataclass(frozen=True)
class Curve:
    """A function that is 0 or small at 0 and grows up to `limit`, where it is cut.

    - odd: t (1 + k0 t^2 + k1 t^4 + … + k5 t^12)
    - power: k0 + k1 t + … + k5 t^5
    - rational: t (1 + k0 t^2 + k1 t^4 + k2 t^6) / (1 + k3 t^2 + k4 t^4 + k5 t^6)
    - sine: sin t, half_sine: 2 sin(t / 2)
    """

    kind: str
    k: tuple[float, ...] = (0.0,) * 6
    limit: float = np.inf

    def at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Value and slope."""
        t = np.asarray(t, np.float64)
        if self.kind == SINE:
            return np.sin(t), np.cos(t)
        if self.kind == HALF_SINE:
            return 2.0 * np.sin(t / 2.0), np.cos(t / 2.0)
        above, below = _fraction(self.kind, self.k)
        divisor = below(t)
        value = above(t) / divisor
        return value, (above.deriv()(t) - value * below.deriv()(t)) / divisor

    @property
    def last(self) -> float:
        """The value at the limit."""
        return float(self.at(np.array(self.limit))[0])

    def solve(self, values: np.ndarray) -> np.ndarray:
        """The t in [0, limit] of each value; the nearer end where there is none."""
        values = np.asarray(values, np.float64)
        low, high = np.zeros_like(values), np.full_like(values, self.limit)
        t = np.clip(values / max(self.last, 1e-300), 0.0, 1.0) * self.limit
        for _ in range(_STEPS):
            value, slope = self.at(t)
            error = value - values
            low, high = np.where(error <= 0, t, low), np.where(error >= 0, t, high)
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = t - error / slope
            inside = (newton > low) & (newton < high)
            after = np.where(inside, newton, (low + high) / 2.0)
            if np.all(np.abs(after - t) <= 1e-14 * np.maximum(np.abs(t), 1e-3)):
                return after
            t = after
        return t


def cut(kind: str, k: tuple[float, ...] = (0.0,) * 6, *, t_most: float = np.inf, value_most: float = np.inf) -> Curve:
    """The curve up to where it stops growing, and no farther than `t_most` and `value_most`."""
    limit = min(t_most, _FARTHEST, {SINE: np.pi / 2, HALF_SINE: np.pi, RATIONAL: STEEPEST}.get(kind, np.inf))
    if kind not in (SINE, HALF_SINE):
        above, below = _fraction(kind, k)
        turns = above.deriv() * below - above * below.deriv()
        # At a pole the value has no end.
        limit = min(limit, _first_root(turns), 0.999 * _first_root(below)) if turns(0.0) > 0.0 else 0.0
        if np.isfinite(value_most):
            limit = min(limit, _first_root(above - value_most * below))
    return Curve(kind, tuple(k), float(limit))


def _fraction(kind: str, k: tuple[float, ...]) -> tuple[Polynomial, Polynomial]:
    """Numerator and denominator."""
    if kind == POWER:
        return Polynomial(k), Polynomial([1.0])
    if kind == ODD:
        return _odd(k), Polynomial([1.0])
    return _odd(k[:3]), Polynomial([1.0, 0.0, k[3], 0.0, k[4], 0.0, k[5]])


def _odd(k: tuple[float, ...]) -> Polynomial:
    return Polynomial([0.0, 1.0, *(value for each in k for value in (0.0, each))])


def _first_root(polynomial: Polynomial) -> float:
    """The smallest positive root; infinity where there is none below `_FARTHEST`."""
    scaled = polynomial.coef * _FARTHEST ** np.arange(len(polynomial.coef), dtype=np.float64)
    # High powers that change nothing up to there would only spoil the search.
    counted = np.flatnonzero(np.abs(scaled) > 1e-14 * np.abs(scaled).max(initial=0.0))
    if not len(counted) or counted[-1] == 0:
        return np.inf
    roots = Polynomial(scaled[: counted[-1] + 1]).roots() * _FARTHEST
    real = roots.real[np.abs(roots.imag) <= 1e-7 * np.abs(roots.real)]
    positive = real[real > 1e-9]
    return float(positive.min()) if len(positive) else np.inf
