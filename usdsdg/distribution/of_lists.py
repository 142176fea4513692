"""Distributions of values that are listed: choices, and sequences."""

from collections.abc import Callable, Iterator, Sequence
from numbers import Integral
from typing import Any, Self

import numpy as np

from usdsdg.arguments.values import shown, whole_number
from usdsdg.distribution.base import Distribution, InputsDiffer, add_kind, all_seeded, as_columns
from usdsdg.distribution.drawn_prims import DrawnPrims
from usdsdg.errors import GraphError, counted, let_pass
from usdsdg.graph.evaluate import graph
from usdsdg.graph.live_prims import LivePrims
from usdsdg.graph.node import are_prims, plain
from usdsdg.graph.sampling import generator, uniforms


class _Listed(Distribution):
    """Draws from listed values."""

    _items: list[Any]
    _part_key: str  # of what distributions among the items draw for
    _target_count: Any = 1  # prims that are drawn for nodes to act on
    _targets: DrawnPrims | None = None

    @property
    def prims(self) -> tuple[str, ...]:
        """The prims that are drawn, where all items are prims: nodes act on others at each execution."""
        if self._targets is None:
            if not are_prims(self._items):
                return ()
            count = self._checked(lambda: whole_number("num_samples", self._target_count, least=1))
            self._targets = DrawnPrims(self, graph().next_key("|".join(["prims", *self._items])), count)
        return LivePrims([self._targets], self.node.state.get("targets", 0))

    def held(self) -> Sequence[Any]:
        return self._items

    def parts(self, consumer: str) -> Iterator[tuple[Distribution, str]]:
        for item in self._items:
            if isinstance(item, Distribution):
                yield item, f"{consumer}/{self._part_key}"

    def rename_held(self, renamed: Callable[[Any], Any]) -> None:
        self._items = [renamed(item) for item in self._items]

    def has_patterns(self, count: int) -> bool:
        return all(isinstance(item, (list, tuple)) and len(item) == count for item in self._items)

    def options(self) -> list[Any]:
        return [each for item in self._items for each in _options(item)]

    def _no_rows(self, prims: Sequence[str]) -> dict[str, list[Any]]:
        """Return for each name of a distribution among the values a row for each prim, None: it was not drawn."""
        inner = [name for item in self._items if isinstance(item, Distribution) for name in item.names()]
        return {name: [None] * len(prims) for name in inner}


class Choice(_Listed):
    _part_key = "choice"

    def __init__(
        self,
        choices: Any,
        weights: Any,
        with_replacements: bool,
        seed: int | None,
        name: str | None,
        *,
        target_count: Any = 1,
    ) -> None:
        super().__init__("OgnSampleChoice", seed, name, weights=weights, withReplacements=with_replacements)
        listed = [choices] if isinstance(choices, Distribution) else choices
        items = self._listed("choices", listed, groups_count_as_one=weights is not None)
        self._target_count = target_count
        self.node.inputs["choices"] = plain(items)
        self._items, self._with_replacements = items, with_replacements
        try:
            p = np.ones(len(items)) if weights is None else np.asarray(weights, dtype=np.float64)
        except (TypeError, ValueError):
            p = np.zeros(0)
        if p.shape != (len(items),) or not np.isfinite(p).all() or np.any(p < 0) or p.sum() <= 0:
            kind = GraphError if p.shape == (len(items),) else InputsDiffer
            let_pass(
                kind(
                    f"{self.node.describe()}: weights={weights!r} must be {counted(len(items), 'number')} >= 0, not "
                    "all 0"
                )
            )
            p = _mended(p, len(items))
        self._weights = p / p.sum()

    def seeded(self, seed: int) -> Self:
        twin = super().seeded(seed)
        twin._items = twin.node.inputs["choices"] = all_seeded(self._items, seed)
        return twin

    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> list[Any]:
        picked = self._picked(consumer, execution, prims)
        return [
            item.sample(f"{consumer}/{self._part_key}", execution, _seen_by(item, prims, row))[-1]
            if isinstance(item, Distribution)
            else item
            for row, item in enumerate(picked)
        ]

    def named_parts(self, consumer: str, execution: int, prims: Sequence[str]) -> dict[str, Any]:
        if not (found := self._no_rows(prims)):
            return {}
        for row, item in enumerate(self._picked(consumer, execution, prims)):
            if isinstance(item, Distribution):
                seen = _seen_by(item, prims, row)
                for name, rows in item.named_samples(f"{consumer}/{self._part_key}", execution, seen).items():
                    found[name][row] = rows[-1]
        return found

    def _picked(self, consumer: str, execution: int, prims: Sequence[str]) -> list[Any]:
        """Return the choice of each prim."""
        self._check_fit()
        if self._with_replacements:
            picks = self._picks(self._uniforms(consumer, execution, prims))
        else:
            if len(prims) > (available := int(np.count_nonzero(self._weights))):
                raise GraphError(f"{self.node.describe()}: {len(prims)} prims but only {counted(available, 'choice')}")
            rng = generator(self.seed(), self.key(consumer), execution)
            picks = rng.choice(len(self._items), size=len(prims), replace=False, p=self._weights)
        return [self._items[pick] for pick in picks]

    def sample_worlds(self, consumer: str, executions: np.ndarray, prims: Sequence[str]) -> np.ndarray:
        if not self._with_replacements or any(isinstance(item, Distribution) for item in self._items):
            return super().sample_worlds(consumer, executions, prims)
        self._check_fit()
        return as_columns([self._items])[0][self._picks(self._uniforms(consumer, executions, prims))]

    def _uniforms(self, consumer: str, execution: int | np.ndarray, prims: Sequence[str]) -> np.ndarray:
        return uniforms(self.seed(), self.key(consumer), execution, self.rows(consumer, prims), 1)[..., 0]

    def _picks(self, u: np.ndarray) -> np.ndarray:
        return np.minimum(np.searchsorted(np.cumsum(self._weights), u, side="right"), len(self._items) - 1)


class Sequence_(_Listed):
    _part_key = "sequence"

    def __init__(self, items: Any, ordered: bool, stride: int | None, seed: int | None, name: str | None) -> None:
        super().__init__("OgnSampleSequence", seed, name, ordered=ordered, stride=stride)
        self._items, self._ordered, self._stride = self._listed("items", items), ordered, stride
        self.node.inputs["items"] = plain(self._items)
        if stride is not None and not isinstance(stride, Integral):
            raise GraphError(f"{self.node.describe()}: stride is {shown(stride)}; expected a whole number")
        distributions = [isinstance(item, Distribution) for item in self._items]
        if any(distributions) and not all(distributions):
            other = self._items[distributions.index(False)]
            raise GraphError(f"{self.node.describe()}: items has distributions, and {shown(other)}, which is none")
        self._has_distributions = any(distributions)
        self._has_vectors = not any(distributions) and all(_is_vector(item) for item in self._items)

    def seeded(self, seed: int) -> Self:
        twin = super().seeded(seed)
        twin._items = twin.node.inputs["items"] = all_seeded(self._items, seed)
        return twin

    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> Any:
        if self._has_distributions:
            return self._taken(consumer, execution).sample(f"{consumer}/{self._part_key}", execution, prims)
        step = self._stride or (len(prims) if self._has_vectors else 1)
        # As many items as the stride are taken at once; prims beyond them begin again with the first of these.
        taken = [self._items[self._index(consumer, execution * step + i)] for i in range(min(len(prims), max(step, 1)))]
        return [taken[row % len(taken)] for row in range(len(prims))]

    def named_parts(self, consumer: str, execution: int, prims: Sequence[str]) -> dict[str, Any]:
        if not (found := self._no_rows(prims)):
            return {}
        return found | self._taken(consumer, execution).named_samples(f"{consumer}/{self._part_key}", execution, prims)

    def _taken(self, consumer: str, execution: int) -> Distribution:
        """Return the distribution of which all prims draw."""
        return self._items[self._index(consumer, execution * (self._stride or 1))]

    def _index(self, consumer: str, position: int) -> int:
        cycle, index = divmod(position, len(self._items))
        if self._ordered:
            return index
        return int(generator(self.seed(), self.key(consumer), cycle).permutation(len(self._items))[index])


def _seen_by(item: Distribution, prims: Sequence[str], row: int) -> Sequence[str]:
    """Return the prims for which a choice of a row draws; the last of its draws is that of the row."""
    # One that goes by its own seed has the row's place as its key, and so needs those before it.
    return prims[: row + 1] if item.goes_by_seed and not isinstance(item, Sequence_) else [prims[row]]


def _is_vector(item: Any) -> bool:
    """Return whether an item is numbers, such as a position: neither a single value nor truth values or labels."""
    if isinstance(item, str):
        return False
    values = np.asarray(item)
    return values.ndim == 1 and values.dtype.kind in "iuf" and values.size > 1


def _mended(weights: np.ndarray, count: int) -> np.ndarray:
    """Return `count` weights that can be drawn from: what is missing, not finite or below 0 is 0, all 0 are equal."""
    usable = np.nan_to_num(np.ravel(weights)[:count], nan=0.0, posinf=0.0, neginf=0.0).clip(0.0)
    usable = np.pad(usable, (0, count - len(usable)))
    return usable if usable.sum() > 0 else np.ones(count)


def _options(item: Any) -> list[Any]:
    return item.options() if isinstance(item, Distribution) else [item]


add_kind(
    "OgnSampleChoice",
    ("choices", "weights", "withReplacements", "seed"),
    lambda inputs, name: Choice(
        inputs["choices"], inputs.get("weights"), inputs.get("withReplacements", True), inputs.get("seed"), name
    ),
)
add_kind(
    "OgnSampleSequence",
    ("items", "ordered", "stride", "seed"),
    lambda inputs, name: Sequence_(
        inputs["items"], inputs.get("ordered", True), inputs.get("stride"), inputs.get("seed"), name
    ),
)


def choice(
    choices: Any,
    weights: Any = None,
    num_samples: int = 1,
    seed: int | None = -1,
    with_replacements: bool = True,
    name: str | None = None,
) -> Distribution:
    """Sample one of `choices` per prim: values, paths, prims, a group, distributions, or the draws of one distribution.

    Of prims it is an item of those that are drawn: `with` it, or with it as `input_prims`, nodes act at each execution
    on `num_samples` prims.

    Args:
        weights: Relative probabilities, numbers >= 0 with any sum; by default equal.
        with_replacements: False draws no choice twice in one execution.
        seed: As in `uniform`, as are `name` and, for values, `num_samples`.

    Raises:
        GraphError: there are no choices, or the weights do not fit them. At execution, without replacements: there are
            more prims than choices.
    """
    return Choice(choices, weights, with_replacements, seed, name, target_count=num_samples)


def sequence(
    items: Any, ordered: bool = True, seed: int | None = -1, name: str | None = None, stride: int | None = None
) -> Distribution:
    """Cycle through `items`: each execution takes the next one, for all prims, or the next `stride`, one for each prim.

    Vectors, such as positions and colors, are taken one for each prim where no stride is given.

    Args:
        items: Values, or an item, whose prims are the values. Of distributions, each execution takes one, from which
            the values of all prims are drawn.
        ordered: False shuffles each cycle.
        stride: How many items an execution takes; None, 0: one, of vectors one for each prim. Lists of truth values,
            one for each prim, are one item.
        seed: Seed of the shuffle, as in `uniform`, as is `name`.

    Raises:
        GraphError: there are no items, only some are distributions, or the stride is not an integer.
    """
    return Sequence_(items, ordered, stride, seed, name)
