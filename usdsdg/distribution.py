"""Distributions: what a randomizer draws. One independent draw per prim and per component.

Mirrors `rep.distribution`. A distribution is a node that others hold as an input; it draws when its consumer runs.
"""

from __future__ import annotations

import abc
import copy
from collections.abc import Callable, Sequence
from dataclasses import replace
from numbers import Real
from statistics import NormalDist
from typing import Any, Self

import numpy as np

from usdsdg.errors import GraphError
from usdsdg.graph.node import Node, ReplicatorItem, plain, script_line
from usdsdg.graph.sampling import generator, get_global_seed, uniforms
from usdsdg.user_functions import enter

_GAUSS = NormalDist()


class Distribution(ReplicatorItem, abc.ABC):
    """A distribution's handle. `sample` returns one row per prim."""

    def __init__(self, kind: str, seed: int | None, name: str | None, **inputs: Any) -> None:
        given = {role: plain(value) for role, value in {**inputs, "seed": seed}.items() if value is not None}
        super().__init__(Node(kind=kind, inputs=given, name=name, line=script_line()))
        self._seed = seed

    def seed(self) -> int:
        return get_global_seed() if self._seed is None or self._seed < 0 else int(self._seed)

    def seeded(self, seed: int) -> Self:
        """This distribution, and those that it draws from, with `seed` instead of the global one.

        Raises:
            GraphError: it was made with another seed.
        """
        own = self._seed
        if own is not None and own >= 0 and own != seed:
            raise GraphError(f"{self.node.describe()} has seed={own}, its randomizer seed={seed}; give one of them")
        twin = copy.copy(self)
        twin._seed = seed
        twin.node = replace(self.node, inputs={**self.node.inputs, "seed": seed}, path=None)
        return twin

    def set_input(self, name: str, value: Any) -> None:
        """Draw with another bound, choice or seed from the next execution on.

        Raises:
            GraphError: the value does not go with the other inputs.
        """
        changed = from_inputs(self.node.kind, {**self.node.inputs, name: value}, self.node.name)
        super().set_input(name, value)
        self.__dict__.update({key: own for key, own in changed.__dict__.items() if key != "node"})

    @abc.abstractmethod
    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> np.ndarray | list[Any]:
        """Draw one value per prim for execution number `execution` of the node with key `consumer`."""


class _Numeric(Distribution):
    """Draws numbers: a scalar per prim, or a tuple where a bound is a tuple."""

    def _shape(self, first: Any, second: Any, names: tuple[str, str]) -> tuple[np.ndarray, np.ndarray, bool]:
        a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
        if a.ndim > 1 or b.ndim > 1 or (a.ndim and b.ndim and a.shape != b.shape):
            raise GraphError(f"{self.node.describe()}: {names[0]}={first!r} and {names[1]}={second!r} differ in length")
        scalar = a.ndim == 0 and b.ndim == 0
        a, b = np.broadcast_arrays(np.atleast_1d(a), np.atleast_1d(b))
        return a, b, scalar

    def _uniforms(self, consumer: str, execution: int, prims: Sequence[str], components: int) -> np.ndarray:
        return uniforms(self.seed(), consumer, execution, prims, components)


class Uniform(_Numeric):
    def __init__(self, lower: Any, upper: Any, seed: int | None, name: str | None) -> None:
        super().__init__("OgnSampleUniform", seed, name, lower=lower, upper=upper)
        self._lower, self._upper, self._scalar = self._shape(lower, upper, ("lower", "upper"))
        if np.any(self._lower > self._upper):
            raise GraphError(f"{self.node.describe()}: lower={lower!r} is above upper={upper!r}")

    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> np.ndarray:
        u = self._uniforms(consumer, execution, prims, len(self._lower))
        values = self._lower + u * (self._upper - self._lower)
        return values[:, 0] if self._scalar else values


class Normal(_Numeric):
    def __init__(self, mean: Any, std: Any, seed: int | None, name: str | None) -> None:
        super().__init__("OgnSampleNormal", seed, name, mean=mean, std=std)
        self._mean, self._std, self._scalar = self._shape(mean, std, ("mean", "std"))
        if np.any(self._std < 0):
            raise GraphError(f"{self.node.describe()}: std={std!r} is negative")

    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> np.ndarray:
        u = self._uniforms(consumer, execution, prims, len(self._mean))
        gauss = np.vectorize(_GAUSS.inv_cdf, otypes=[np.float64])(np.maximum(u, 2.0**-54))
        values = self._mean + self._std * gauss
        return values[:, 0] if self._scalar else values


class LogUniform(Uniform):
    def __init__(self, lower: Any, upper: Any, seed: int | None, name: str | None) -> None:
        if np.any(np.asarray(lower) <= 0):
            raise GraphError(f"log_uniform (made at {script_line()}): lower={lower!r} must be above 0")
        super().__init__(lower, upper, seed, name)
        self.node.kind = "OgnSampleLogUniform"
        self._lower, self._upper = np.log(self._lower), np.log(self._upper)

    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> np.ndarray:
        return np.exp(super().sample(consumer, execution, prims))


class Choice(Distribution):
    def __init__(self, choices: Any, weights: Any, with_replacements: bool, seed: int | None, name: str | None) -> None:
        items = list(choices.prims) if isinstance(choices, ReplicatorItem) else list(choices)
        inputs = dict(choices=items, weights=weights, withReplacements=with_replacements)
        super().__init__("OgnSampleChoice", seed, name, **inputs)
        if not items:
            raise GraphError(f"{self.node.describe()}: choices is empty")
        self._items, self._with_replacements = items, with_replacements
        p = np.ones(len(items)) if weights is None else np.asarray(weights, dtype=np.float64)
        if p.shape != (len(items),) or np.any(p < 0) or p.sum() <= 0:
            raise GraphError(
                f"{self.node.describe()}: weights={weights!r} must be {len(items)} numbers >= 0, not all 0"
            )
        self._weights = p / p.sum()

    def seeded(self, seed: int) -> Self:
        twin = super().seeded(seed)
        twin._items = twin.node.inputs["choices"] = _all_seeded(self._items, seed)
        return twin

    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> list[Any]:
        if self._with_replacements:
            u = uniforms(self.seed(), consumer, execution, prims, 1)[:, 0]
            picks = np.minimum(np.searchsorted(np.cumsum(self._weights), u, side="right"), len(self._items) - 1)
        else:
            if len(prims) > np.count_nonzero(self._weights):
                raise GraphError(f"{self.node.describe()}: {len(prims)} prims but only {len(self._items)} choices")
            rng = generator(self.seed(), consumer, execution)
            picks = rng.choice(len(self._items), size=len(prims), replace=False, p=self._weights)
        return [self._resolved(self._items[pick], consumer, execution, prim) for pick, prim in zip(picks, prims)]

    def _resolved(self, item: Any, consumer: str, execution: int, prim: str) -> Any:
        return item.sample(f"{consumer}/choice", execution, [prim])[0] if isinstance(item, Distribution) else item


class Sequence_(Distribution):
    def __init__(self, items: Any, ordered: bool, stride: int | None, seed: int | None, name: str | None) -> None:
        items = list(items.prims) if isinstance(items, ReplicatorItem) else list(items)
        super().__init__("OgnSampleSequence", seed, name, items=items, ordered=ordered, stride=stride)
        if not items:
            raise GraphError(f"{self.node.describe()}: items is empty")
        self._items, self._ordered, self._stride = items, ordered, stride

    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> list[Any]:
        first = execution * (len(prims) if self._stride is None else self._stride)
        positions = [first + i for i in range(len(prims))]
        return [self._items[self._index(consumer, position)] for position in positions]

    def _index(self, consumer: str, position: int) -> int:
        lap, place = divmod(position, len(self._items))
        if self._ordered:
            return place
        return int(generator(self.seed(), consumer, lap).permutation(len(self._items))[place])


class Combine(Distribution):
    def __init__(self, distributions: Sequence[Any], name: str | None) -> None:
        super().__init__("OgnCombine", None, name, distributions=list(distributions))
        self._parts = list(distributions)

    def seeded(self, seed: int) -> Self:
        twin = super().seeded(seed)
        twin._parts = twin.node.inputs["distributions"] = _all_seeded(self._parts, seed)
        return twin

    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> np.ndarray:
        columns = [
            np.asarray(part.sample(f"{consumer}/{axis}", execution, prims), dtype=np.float64)
            if isinstance(part, Distribution)
            else np.full(len(prims), float(part))
            for axis, part in enumerate(self._parts)
        ]
        return np.stack(columns, axis=1)


def _all_seeded(items: Sequence[Any], seed: int) -> list[Any]:
    return [item.seeded(seed) if isinstance(item, Distribution) else item for item in items]


def uniform(lower: Any, upper: Any, num_samples: int = 1, seed: int | None = None, name: str | None = None):
    """Uniform between `lower` and `upper`, scalars or tuples.

    Draws are floats, also between whole numbers: scripts write colours as (0, 0, 0) to (1, 1, 1). Written to an
    attribute of whole numbers they are rounded down, so `upper` itself is not drawn. `num_samples` changes nothing:
    there is one draw for each prim.
    """
    return Uniform(lower, upper, seed, name)


def normal(mean: Any, std: Any, num_samples: int = 1, seed: int | None = None, name: str | None = None):
    """Gaussian with `mean` and standard deviation `std`, scalars or tuples; `num_samples` as in `uniform`."""
    return Normal(mean, std, seed, name)


def log_uniform(lower: Any, upper: Any, num_samples: int = 1, seed: int | None = None, name: str | None = None):
    """Uniform in the logarithm, between `lower` > 0 and `upper`; `num_samples` as in `uniform`."""
    return LogUniform(lower, upper, seed, name)


def choice(
    choices: Any,
    weights: Any = None,
    num_samples: int = 1,
    seed: int | None = -1,
    with_replacements: bool = True,
    name: str | None = None,
):
    """One of `choices` per prim: values, paths, prims, a group, or other distributions.

    `num_samples` is as in `uniform`.
    """
    return Choice(choices, weights, with_replacements, seed, name)


def sequence(
    items: Any, ordered: bool = True, seed: int | None = -1, name: str | None = None, stride: int | None = None
):
    """Step through `items`, `stride` (default: the number of prims) further at each execution."""
    return Sequence_(items, ordered, stride, seed, name)


def combine(distributions: Sequence[Any], name: str | None = None):
    """One vector from one distribution (or number) per axis."""
    return Combine(distributions, name)


def from_inputs(kind: str, inputs: dict[str, Any], name: str | None) -> Distribution:
    """The distribution that a node of a saved graph describes.

    Raises:
        GraphError: the type is none of ours.
    """
    seed = inputs.get("seed")
    makers: dict[str, Callable[[], Distribution]] = {
        "OgnSampleUniform": lambda: Uniform(inputs["lower"], inputs["upper"], seed, name),
        "OgnSampleNormal": lambda: Normal(inputs["mean"], inputs["std"], seed, name),
        "OgnSampleLogUniform": lambda: LogUniform(inputs["lower"], inputs["upper"], seed, name),
        "OgnSampleChoice": lambda: Choice(
            inputs["choices"], inputs.get("weights"), inputs.get("withReplacements", True), seed, name
        ),
        "OgnSampleSequence": lambda: Sequence_(
            inputs["items"], inputs.get("ordered", True), inputs.get("stride"), seed, name
        ),
        "OgnCombine": lambda: Combine(inputs["distributions"], name),
    }
    if kind not in makers:
        raise GraphError(f"a node of type {kind} is no distribution; known: {', '.join(makers)}")
    return makers[kind]()


def one_of(options: Any, seed: int | None) -> Distribution:
    """What a randomizer draws from, given a distribution or a list, and its `seed` (None or negative: the global one).

    Raises:
        GraphError: `options` is a distribution that was made with another seed.
    """
    drawn = options if isinstance(options, Distribution) else choice(options)
    return drawn if seed is None or seed < 0 else drawn.seeded(seed)


def draw(value: Any, node: Node, execution: int, role: str) -> list[Any]:
    """One value per prim of `node` for its input `role`: a constant, a list of one per prim, or a distribution."""
    count = len(node.prims)
    if isinstance(value, Distribution):
        consumer = f"{node.key}/{value.node.name or role}"
        return list(value.sample(consumer, execution, node.prims))
    if isinstance(value, np.ndarray):
        value = list(value) if value.ndim else value.item()
    if isinstance(value, list) and len(value) == count and not is_vector(value):
        return value
    return [value] * count


def is_vector(value: Sequence[Any]) -> bool:
    """Whether a sequence is one value of several numbers, not several values."""
    return len(value) > 0 and all(isinstance(v, Real) and not isinstance(v, bool) for v in value)


def register(fn: Callable[..., Any], override: bool = True, fn_name: str | None = None) -> None:
    """Make `rep.distribution.<name>` call `fn`.

    Raises:
        ValueError: the name is no identifier, or taken while `override` is False.
    """
    enter(globals(), "distribution", fn, override, fn_name)
