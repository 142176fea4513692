"""Distributions of numbers: uniform, normal, uniform in the logarithm."""

import abc
from collections.abc import Sequence
from statistics import NormalDist
from typing import Any

import numpy as np

from usdsdg.arguments.values import shown
from usdsdg.distribution.base import Distribution, InputsDiffer, add_kind
from usdsdg.errors import GraphError, let_pass
from usdsdg.graph.sampling import uniforms

_GAUSS = NormalDist()


class _Numeric(Distribution):
    """Draws numbers: a scalar per prim, or a tuple where a bound is a tuple."""

    def _shape(self, first: Any, second: Any, names: tuple[str, str]) -> tuple[np.ndarray, np.ndarray, bool]:
        a, b = self._numbers(names[0], first), self._numbers(names[1], second)
        if a.ndim > 1 or b.ndim > 1 or (a.ndim and b.ndim and a.shape != b.shape):
            raise InputsDiffer(
                f"{self.node.describe()}: {names[0]}={first!r} and {names[1]}={second!r} differ in length"
            )
        scalar = a.ndim == 0 and b.ndim == 0
        a, b = np.broadcast_arrays(np.atleast_1d(a), np.atleast_1d(b))
        return a, b, scalar

    def _numbers(self, name: str, value: Any) -> np.ndarray:
        try:
            numbers = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            numbers = np.full(1, np.nan)
        if numbers.size == 0 or not np.isfinite(numbers).all():
            raise GraphError(f"{self.node.describe()}: {name} is {shown(value)}; expected a number, or some numbers")
        return numbers

    def sample_worlds(self, consumer: str, executions: np.ndarray, prims: Sequence[str]) -> np.ndarray:
        return self.sample(consumer, executions, prims)

    @abc.abstractmethod
    def sample(self, consumer: str, execution: int | np.ndarray, prims: Sequence[str]) -> np.ndarray:
        """As in `Distribution`; with a leading axis for an array of executions."""

    def _uniforms(
        self, consumer: str, execution: int | np.ndarray, prims: Sequence[str], components: int
    ) -> np.ndarray:
        return uniforms(self.seed(), self.key(consumer), execution, self.rows(consumer, prims), components)


class Uniform(_Numeric):
    def __init__(self, lower: Any, upper: Any, seed: int | None, name: str | None) -> None:
        super().__init__("OgnSampleUniform", seed, name, lower=lower, upper=upper)
        self._lower, self._upper, self._scalar = self._shape(lower, upper, ("lower", "upper"))
        if np.any(self._lower > self._upper):
            let_pass(InputsDiffer(f"{self.node.describe()}: lower={lower!r} is above upper={upper!r}"))

    def sample(self, consumer: str, execution: int | np.ndarray, prims: Sequence[str]) -> np.ndarray:
        self._check_fit()
        u = self._uniforms(consumer, execution, prims, len(self._lower))
        values = self._lower + u * (self._upper - self._lower)
        return values[..., 0] if self._scalar else values


class Normal(_Numeric):
    def __init__(self, mean: Any, std: Any, seed: int | None, name: str | None) -> None:
        super().__init__("OgnSampleNormal", seed, name, mean=mean, std=std)
        self._mean, self._std, self._scalar = self._shape(mean, std, ("mean", "std"))
        if np.any(self._std < 0):
            raise GraphError(f"{self.node.describe()}: std={std!r} is negative")

    def sample(self, consumer: str, execution: int | np.ndarray, prims: Sequence[str]) -> np.ndarray:
        self._check_fit()
        u = self._uniforms(consumer, execution, prims, len(self._mean))
        gauss = np.vectorize(_GAUSS.inv_cdf, otypes=[np.float64])(np.maximum(u, 2.0**-54))
        values = self._mean + self._std * gauss
        return values[..., 0] if self._scalar else values


class LogUniform(Uniform):
    def __init__(self, lower: Any, upper: Any, seed: int | None, name: str | None) -> None:
        super().__init__(lower, upper, seed, name)
        self.node.kind = "OgnSampleLogUniform"
        if np.any(self._lower <= 0):
            raise GraphError(f"{self.node.describe()}: lower={lower!r} must be above 0")
        self._lower, self._upper = np.log(self._lower), np.log(self._upper)

    def sample(self, consumer: str, execution: int | np.ndarray, prims: Sequence[str]) -> np.ndarray:
        return np.exp(super().sample(consumer, execution, prims))


for _type, _class, _bounds in (
    ("OgnSampleUniform", Uniform, ("lower", "upper")),
    ("OgnSampleNormal", Normal, ("mean", "std")),
    ("OgnSampleLogUniform", LogUniform, ("lower", "upper")),
):
    add_kind(
        _type,
        (*_bounds, "seed"),
        lambda inputs, name, kind=_class, bounds=_bounds: kind(
            inputs[bounds[0]], inputs[bounds[1]], inputs.get("seed"), name
        ),
    )


def uniform(
    lower: Any, upper: Any, num_samples: int = 1, seed: int | None = None, name: str | None = None
) -> Distribution:
    """Sample uniformly from `lower` to `upper`: numbers, or tuples of equal length; a number is broadcast to a tuple.

    Draws are floats, also between integers: scripts write colors as (0, 0, 0) to (1, 1, 1). Written to an integer
    attribute they are rounded down, so `upper` itself is not drawn. `num_samples` is ignored: there is one draw for
    each prim. `seed` replaces the global seed; distributions with the same one draw alike for whatever prims they are
    for. Draws with a `name` are in the payload of writers.

    Raises:
        GraphError: a bound is not a number, `lower` is above `upper`, or they differ in length; the seed is not an
            integer.
    """
    return Uniform(lower, upper, seed, name)


def normal(mean: Any, std: Any, num_samples: int = 1, seed: int | None = None, name: str | None = None) -> Distribution:
    """Sample a Gaussian with `mean` and standard deviation `std` >= 0; `num_samples` and the rest as in `uniform`."""
    return Normal(mean, std, seed, name)


def log_uniform(
    lower: Any, upper: Any, num_samples: int = 1, seed: int | None = None, name: str | None = None
) -> Distribution:
    """Sample uniformly in the logarithm, from `lower` > 0 to `upper`; `num_samples` and the rest as in `uniform`."""
    return LogUniform(lower, upper, seed, name)
