"""Distributions that randomizers sample, with one independent draw per prim and per component.

Mirrors `rep.distribution`. A distribution is a node that other nodes have as an input; it draws when its consumer runs.
"""

import abc
import copy
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from numbers import Integral, Real
from statistics import NormalDist
from typing import Any, Self

import numpy as np

from usdsdg.arguments.registry import near_misses, register_function
from usdsdg.arguments.values import shown
from usdsdg.errors import GraphError, let_pass
from usdsdg.graph.node import Node, ReplicatorItem, plain, script_line
from usdsdg.graph.sampling import generator, get_global_seed, own_seed, uniforms

_GAUSS = NormalDist()


class Distribution(ReplicatorItem, abc.ABC):
    """The item of a distribution; `sample` returns one row per prim."""

    def __init__(self, kind: str, seed: int | None, name: str | None, **inputs: Any) -> None:
        given = {role: plain(value) for role, value in {**inputs, "seed": seed}.items() if value is not None}
        super().__init__(Node(kind=kind, inputs=given, name=name, line=script_line()))
        self._seed = self._checked(lambda: own_seed(seed))

    def seed(self) -> int:
        return get_global_seed() if self._seed is None else self._seed

    def seeded(self, seed: int) -> Self:
        """Return a copy of this distribution, and of those that it draws from, with `seed` instead of the global one.

        Raises:
            GraphError: it was made with another seed.
        """
        own = self._seed
        if own is not None and own != seed:
            raise GraphError(f"{self.node.describe()} has seed={own}, its randomizer seed={seed}; give one of them")
        twin = copy.copy(self)
        twin._seed = seed
        twin.node = replace(self.node, inputs={**self.node.inputs, "seed": seed}, path=None)
        return twin

    def set_input(self, name: str, value: Any) -> None:
        """Set a bound, choice or seed from the next execution on.

        Raises:
            GraphError: there is no such input, or the value does not fit the other inputs.
        """
        name = name.removeprefix("inputs:")
        if name not in (known := INPUTS[self.node.kind]):
            near = near_misses(name, known)
            hint = f"did you mean {near[0]!r}?" if near else f"it has {', '.join(known)}"
            raise GraphError(f"{self.node.describe()} has no input {name!r}; {hint}")
        changed = from_inputs(self.node.kind, {**self.node.inputs, name: value}, self.node.name)
        super().set_input(name, value)
        self.__dict__.update({key: own for key, own in changed.__dict__.items() if key != "node"})

    def _checked(self, make: Callable[[], Any]) -> Any:
        """Return `make()`; errors name the distribution and its script line."""
        try:
            return make()
        except GraphError as error:
            raise GraphError(f"{self.node.describe()}: {error}") from None

    def has_patterns(self, count: int) -> bool:
        """Return whether each value that can be drawn is a list of `count` values, one for each prim of a group."""
        return False

    def options(self) -> list[Any]:
        """Return all values that can be drawn, where these are listed; none for distributions of numbers."""
        return []

    def _listed(self, name: str, given: Any) -> list[Any]:
        """Return the values of an argument that is a list; those of an item are its prims."""
        if isinstance(given, ReplicatorItem) and not isinstance(given, Distribution):
            given = given.prims
        # A string is iterable, but its characters are not the values.
        if isinstance(given, (str, bytes, Distribution)) or not isinstance(given, Iterable):
            raise GraphError(f"{self.node.describe()}: {name} is {shown(given)}; expected a list")
        if not (items := list(given)):
            raise GraphError(f"{self.node.describe()}: {name} is empty")
        return items

    @abc.abstractmethod
    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> np.ndarray | list[Any]:
        """Draw one value per prim for execution number `execution` of the node with key `consumer`."""


class _Numeric(Distribution):
    """Draws numbers: a scalar per prim, or a tuple where a bound is a tuple."""

    def _shape(self, first: Any, second: Any, names: tuple[str, str]) -> tuple[np.ndarray, np.ndarray, bool]:
        a, b = self._numbers(names[0], first), self._numbers(names[1], second)
        if a.ndim > 1 or b.ndim > 1 or (a.ndim and b.ndim and a.shape != b.shape):
            raise GraphError(f"{self.node.describe()}: {names[0]}={first!r} and {names[1]}={second!r} differ in length")
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

    def _uniforms(self, consumer: str, execution: int, prims: Sequence[str], components: int) -> np.ndarray:
        return uniforms(self.seed(), consumer, execution, prims, components)


class Uniform(_Numeric):
    def __init__(self, lower: Any, upper: Any, seed: int | None, name: str | None) -> None:
        super().__init__("OgnSampleUniform", seed, name, lower=lower, upper=upper)
        self._lower, self._upper, self._scalar = self._shape(lower, upper, ("lower", "upper"))
        if np.any(self._lower > self._upper):
            let_pass(GraphError(f"{self.node.describe()}: lower={lower!r} is above upper={upper!r}"))

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
        super().__init__(lower, upper, seed, name)
        self.node.kind = "OgnSampleLogUniform"
        if np.any(self._lower <= 0):
            raise GraphError(f"{self.node.describe()}: lower={lower!r} must be above 0")
        self._lower, self._upper = np.log(self._lower), np.log(self._upper)

    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> np.ndarray:
        return np.exp(super().sample(consumer, execution, prims))


def _mended(weights: np.ndarray, count: int) -> np.ndarray:
    """Return `count` weights that can be drawn from: what is missing, not finite or below 0 is 0, all 0 are equal."""
    usable = np.nan_to_num(np.ravel(weights)[:count], nan=0.0, posinf=0.0, neginf=0.0).clip(0.0)
    usable = np.pad(usable, (0, count - len(usable)))
    return usable if usable.sum() > 0 else np.ones(count)


class Choice(Distribution):
    def __init__(self, choices: Any, weights: Any, with_replacements: bool, seed: int | None, name: str | None) -> None:
        super().__init__("OgnSampleChoice", seed, name, weights=weights, withReplacements=with_replacements)
        items = self._listed("choices", [choices] if isinstance(choices, Distribution) else choices)
        self.node.inputs["choices"] = plain(items)
        self._items, self._with_replacements = items, with_replacements
        try:
            p = np.ones(len(items)) if weights is None else np.asarray(weights, dtype=np.float64)
        except (TypeError, ValueError):
            p = np.zeros(0)
        if p.shape != (len(items),) or not np.isfinite(p).all() or np.any(p < 0) or p.sum() <= 0:
            let_pass(
                GraphError(f"{self.node.describe()}: weights={weights!r} must be {len(items)} numbers >= 0, not all 0")
            )
            p = _mended(p, len(items))
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
            if len(prims) > (available := np.count_nonzero(self._weights)):
                raise GraphError(f"{self.node.describe()}: {len(prims)} prims but only {available} choices")
            rng = generator(self.seed(), consumer, execution)
            picks = rng.choice(len(self._items), size=len(prims), replace=False, p=self._weights)
        return [self._resolved(self._items[pick], consumer, execution, prim) for pick, prim in zip(picks, prims)]

    def has_patterns(self, count: int) -> bool:
        return _are_lists(self._items, count)

    def options(self) -> list[Any]:
        return _flat_options(self._items)

    def _resolved(self, item: Any, consumer: str, execution: int, prim: str) -> Any:
        return item.sample(f"{consumer}/choice", execution, [prim])[0] if isinstance(item, Distribution) else item


class Sequence_(Distribution):
    def __init__(self, items: Any, ordered: bool, stride: int | None, seed: int | None, name: str | None) -> None:
        super().__init__("OgnSampleSequence", seed, name, ordered=ordered, stride=stride)
        self._items, self._ordered, self._stride = self._listed("items", items), ordered, stride
        self.node.inputs["items"] = plain(self._items)
        if stride is not None and not isinstance(stride, Integral):
            raise GraphError(f"{self.node.describe()}: stride is {shown(stride)}; expected a whole number")

    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> list[Any]:
        first = execution * (len(prims) if self._stride is None else self._stride)
        positions = [first + i for i in range(len(prims))]
        return [self._items[self._index(consumer, position)] for position in positions]

    def has_patterns(self, count: int) -> bool:
        return _are_lists(self._items, count)

    def options(self) -> list[Any]:
        return _flat_options(self._items)

    def _index(self, consumer: str, position: int) -> int:
        cycle, index = divmod(position, len(self._items))
        if self._ordered:
            return index
        return int(generator(self.seed(), consumer, cycle).permutation(len(self._items))[index])


class Combine(Distribution):
    def __init__(self, distributions: Sequence[Any], name: str | None) -> None:
        super().__init__("OgnCombine", None, name)
        self._parts = self._listed("distributions", distributions)
        self.node.inputs["distributions"] = plain(self._parts)
        for part in self._parts:
            if not isinstance(part, (Distribution, Real)):
                raise GraphError(f"{self.node.describe()}: {shown(part)} is neither a number nor a distribution")

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
        if wide := [axis for axis, column in enumerate(columns) if column.ndim != 1]:
            raise GraphError(
                f"{self.node.describe()}: distribution {wide[0]} draws several numbers; give one for each axis"
            )
        return np.stack(columns, axis=1)


# The inputs of each type of node, as a saved graph and `set_input` name them.
INPUTS = {
    "OgnSampleUniform": ("lower", "upper", "seed"),
    "OgnSampleNormal": ("mean", "std", "seed"),
    "OgnSampleLogUniform": ("lower", "upper", "seed"),
    "OgnSampleChoice": ("choices", "weights", "withReplacements", "seed"),
    "OgnSampleSequence": ("items", "ordered", "stride", "seed"),
    "OgnCombine": ("distributions",),
}


def _all_seeded(items: Sequence[Any], seed: int) -> list[Any]:
    return [item.seeded(seed) if isinstance(item, Distribution) else item for item in items]


def _flat_options(items: Sequence[Any]) -> list[Any]:
    return [each for item in items for each in (item.options() if isinstance(item, Distribution) else [item])]


def _are_lists(items: Sequence[Any], count: int) -> bool:
    return all(isinstance(item, (list, tuple)) and len(item) == count for item in items)


def uniform(lower: Any, upper: Any, num_samples: int = 1, seed: int | None = None, name: str | None = None):
    """Sample uniformly from `lower` to `upper`: numbers, or tuples of equal length; a number is broadcast to a tuple.

    Draws are floats, also between integers: scripts write colors as (0, 0, 0) to (1, 1, 1). Written to an integer
    attribute they are rounded down, so `upper` itself is not drawn. `num_samples` is ignored: there is one draw for
    each prim. `seed` replaces the global seed. Draws with a `name` are in the payload of writers.

    Raises:
        GraphError: a bound is not a number, `lower` is above `upper`, or they differ in length; the seed is not an
            integer.
    """
    return Uniform(lower, upper, seed, name)


def normal(mean: Any, std: Any, num_samples: int = 1, seed: int | None = None, name: str | None = None):
    """Sample a Gaussian with `mean` and standard deviation `std` >= 0; `num_samples` and the rest as in `uniform`."""
    return Normal(mean, std, seed, name)


def log_uniform(lower: Any, upper: Any, num_samples: int = 1, seed: int | None = None, name: str | None = None):
    """Sample uniformly in the logarithm, from `lower` > 0 to `upper`; `num_samples` and the rest as in `uniform`."""
    return LogUniform(lower, upper, seed, name)


def choice(
    choices: Any,
    weights: Any = None,
    num_samples: int = 1,
    seed: int | None = -1,
    with_replacements: bool = True,
    name: str | None = None,
):
    """Sample one of `choices` per prim: values, paths, prims, a group, distributions, or the draws of one distribution.

    Args:
        weights: Relative probabilities, numbers >= 0 with any sum; by default equal.
        with_replacements: False draws no choice twice in one execution.
        seed: As in `uniform`, as are `num_samples` and `name`.

    Raises:
        GraphError: there are no choices, or the weights do not fit them. At execution, without replacements: there are
            more prims than choices.
    """
    return Choice(choices, weights, with_replacements, seed, name)


def sequence(
    items: Any, ordered: bool = True, seed: int | None = -1, name: str | None = None, stride: int | None = None
):
    """Cycle through `items`, one for each prim, advancing by `stride` at each execution.

    Args:
        items: Values, or an item, whose prims are the values.
        ordered: False shuffles each cycle.
        stride: By default the number of prims.
        seed: Seed of the shuffle, as in `uniform`, as is `name`.

    Raises:
        GraphError: there are no items, or the stride is not an integer.
    """
    return Sequence_(items, ordered, stride, seed, name)


def combine(distributions: Sequence[Any], name: str | None = None):
    """Combine distributions or numbers, one per axis, into vectors; `name` as in `uniform`.

    Raises:
        GraphError: one of them is neither. At execution: one draws several numbers.
    """
    return Combine(distributions, name)


def from_inputs(kind: str, inputs: dict[str, Any], name: str | None) -> Distribution:
    """Return the distribution that a node of a saved graph describes.

    Raises:
        GraphError: the type of the node is not a distribution.
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
        raise GraphError(f"a node of type {kind} is not a distribution; known: {', '.join(makers)}")
    return makers[kind]()


def one_of(options: Any, seed: int | None) -> Distribution:
    """Return the distribution of a randomizer, from a distribution or a list, and its `seed` (None, < 0: global).

    Raises:
        GraphError: `options` is a distribution that was made with another seed.
    """
    drawn, own = options if isinstance(options, Distribution) else choice(options), own_seed(seed)
    return drawn if own is None else drawn.seeded(own)


def draw(value: Any, node: Node, execution: int, role: str) -> list[Any]:
    """Return one value per prim of `node` for its input `role`: a constant, a list per prim, or a distribution."""
    count = len(node.prims)
    if isinstance(value, Distribution):
        consumer = f"{node.key}/{value.node.name or role}"
        return list(value.sample(consumer, execution, node.prims))
    if isinstance(value, np.ndarray):
        value = list(value) if value.ndim else value.item()
    if isinstance(value, list) and len(value) == count and not is_vector(value):
        return value
    return [value] * count


def options_of(value: Any) -> list[Any]:
    """Return all values of a role that can be drawn: of a distribution, a list of values, or one value."""
    if isinstance(value, Distribution):
        return value.options()
    return list(value) if isinstance(value, (list, tuple)) else [value]


def draw_scalars(value: Any, node: Node, execution: int, role: str) -> list[Any]:
    """As `draw`, for an input whose values are no lists: a list that is drawn is a pattern over the prims of `node`.

    Of choices or items with one value for each prim, one is drawn per execution, for all prims together.
    """
    if isinstance(value, Distribution) and value.has_patterns(len(node.prims)):
        consumer = f"{node.key}/{value.node.name or role}"
        return list(value.sample(consumer, execution, node.prims[:1])[0])
    return draw(value, node, execution, role)


def is_vector(value: Sequence[Any]) -> bool:
    """Return whether a sequence is one vector of numbers, not a list of values."""
    return len(value) > 0 and all(isinstance(v, Real) and not isinstance(v, bool) for v in value)


def register(fn: Callable[..., Any], override: bool = True, fn_name: str | None = None) -> None:
    """Make `rep.distribution.<name>` call `fn`.

    Raises:
        ValueError: the name is not an identifier, or is taken and `override` is False.
    """
    register_function(globals(), "distribution", fn, override, fn_name)
