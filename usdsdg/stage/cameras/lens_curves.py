"""The radial part of lens models: a monotonic function of one variable, and its inverse.

The meaning of the variable t and of the value depends on the lens (see `lens.Lens`): an angle from the axis, its
tangent, or a distance from the center.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

ODD, POWER, RATIONAL, SINE, HALF_SINE = "odd", "power", "rational", "sine", "half_sine"
# Limit of a rational curve that increases without end: the tangent of 89.9 degrees.
MAX_TANGENT = 500.0
# Upper bound of all angles, tangents and distances in pixels.
_MAX_T = 1e4
_NEWTON_STEPS = 100


@dataclass(frozen=True)
class Curve:
    """A function that is 0 or small at 0 and increases up to `limit`, the end of its domain.

    - odd: t (1 + k0 t^2 + k1 t^4 + … + k5 t^12)
    - power: k0 + k1 t + … + k5 t^5
    - rational: t (1 + k0 t^2 + k1 t^4 + k2 t^6) / (1 + k3 t^2 + k4 t^4 + k5 t^6)
    - sine: sin t, half_sine: 2 sin(t / 2)
    """

    kind: str
    k: tuple[float, ...] = (0.0,) * 6
    limit: float = np.inf

    def evaluate(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return value and derivative."""
        t = np.asarray(t, np.float64)
        if self.kind == SINE:
            return np.sin(t), np.cos(t)
        if self.kind == HALF_SINE:
            return 2.0 * np.sin(t / 2.0), np.cos(t / 2.0)
        numerator, denominator = _fraction(self.kind, self.k)
        divisor = denominator(t)
        value = numerator(t) / divisor
        return value, (numerator.deriv()(t) - value * denominator.deriv()(t)) / divisor

    @property
    def limit_value(self) -> float:
        """Value at the limit."""
        return float(self.evaluate(np.array(self.limit))[0])

    def solve(self, values: np.ndarray) -> np.ndarray:
        """Invert the curve: t in [0, limit] of each value; the nearer end for values out of range."""
        values = np.asarray(values, np.float64)
        low, high = np.zeros_like(values), np.full_like(values, self.limit)
        t = np.clip(values / max(self.limit_value, 1e-300), 0.0, 1.0) * self.limit
        for _ in range(_NEWTON_STEPS):
            value, slope = self.evaluate(t)
            error = value - values
            low, high = np.where(error <= 0, t, low), np.where(error >= 0, t, high)
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = t - error / slope
            inside = (newton > low) & (newton < high)
            following = np.where(inside, newton, (low + high) / 2.0)
            if np.all(np.abs(following - t) <= 1e-14 * np.maximum(np.abs(t), 1e-3)):
                return following
            t = following
        return t


def monotonic_curve(
    kind: str, k: tuple[float, ...] = (0.0,) * 6, *, max_t: float = np.inf, max_value: float = np.inf
) -> Curve:
    """Make the curve, limited to where it stops increasing, to `max_t` and to the value `max_value`."""
    limit = min(max_t, _MAX_T, {SINE: np.pi / 2, HALF_SINE: np.pi, RATIONAL: MAX_TANGENT}.get(kind, np.inf))
    if kind not in (SINE, HALF_SINE):
        numerator, denominator = _fraction(kind, k)
        derivative = numerator.deriv() * denominator - numerator * denominator.deriv()
        # At a pole the value is infinite.
        limit = min(limit, _first_root(derivative), 0.999 * _first_root(denominator)) if derivative(0.0) > 0.0 else 0.0
        if np.isfinite(max_value):
            limit = min(limit, _first_root(numerator - max_value * denominator))
    return Curve(kind, tuple(k), float(limit))


def _fraction(kind: str, k: tuple[float, ...]) -> tuple[Polynomial, Polynomial]:
    """Return numerator and denominator."""
    if kind == POWER:
        return Polynomial(k), Polynomial([1.0])
    if kind == ODD:
        return _odd(k), Polynomial([1.0])
    return _odd(k[:3]), Polynomial([1.0, 0.0, k[3], 0.0, k[4], 0.0, k[5]])


def _odd(k: tuple[float, ...]) -> Polynomial:
    return Polynomial([0.0, 1.0, *(value for each in k for value in (0.0, each))])


def _first_root(polynomial: Polynomial) -> float:
    """Return the smallest positive root; infinity where there is none below `_MAX_T`."""
    scaled = np.asarray(polynomial.coef, np.float64) * _MAX_T ** np.arange(len(polynomial.coef), dtype=np.float64)
    # High powers that are negligible up to there make the root search inaccurate.
    significant = np.flatnonzero(np.abs(scaled) > 1e-14 * np.abs(scaled).max(initial=0.0))
    if not len(significant) or significant[-1] == 0:
        return np.inf
    roots = np.multiply(Polynomial(scaled[: significant[-1] + 1]).roots(), _MAX_T)
    real = roots.real[np.abs(roots.imag) <= 1e-7 * np.abs(roots.real)]
    positive = real[real > 1e-9]
    return float(positive.min()) if len(positive) else np.inf
