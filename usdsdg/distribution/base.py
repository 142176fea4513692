"""What a distribution is: a node with inputs that draws one value per prim, and the kinds of them by type of node."""

import abc
import copy
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from usdsdg.arguments.registry import near_misses
from usdsdg.arguments.values import shown
from usdsdg.distribution.shared_draws import SharedDraws
from usdsdg.errors import GraphError, UnknownInput
from usdsdg.graph.node import Node, ReplicatorItem, item_of, plain, script_line
from usdsdg.graph.sampling import get_global_seed, own_seed

# Input of a node: its seed is that of the randomizer that it is for.
OF_RANDOMIZER = "seedOfRandomizer"


class InputsDiffer(GraphError):
    """Inputs of a distribution do not fit each other; another `set_input` may change that."""


class Distribution(ReplicatorItem, abc.ABC):
    """The item of a distribution; `sample` returns one row per prim."""

    _misfit: InputsDiffer | None = None  # what draws raise until inputs that were set fit each other

    def __init__(self, kind: str, seed: int | None, name: str | None, **inputs: Any) -> None:
        given = {role: plain(value) for role, value in {**inputs, "seed": seed}.items() if value is not None}
        super().__init__(Node(kind=kind, inputs=given, name=name, line=script_line()))
        self._seed = self._checked(lambda: own_seed(seed))
        # Draws with one seed go together in Replicator, whichever nodes they are for: scripts move several cameras so.
        self.goes_by_seed = self._seed is not None
        self._shared = SharedDraws()

    def get_outputs(self) -> dict[str, Any]:
        """Return the outputs of the node, with the values drawn last, one per prim: [] before the first execution."""
        return {**super().get_outputs(), "samples": list(self.node.state.get("samples", ()))}

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
        twin._seed, twin._shared = seed, SharedDraws()
        inputs = {**self.node.inputs, "seed": seed} | ({} if self.goes_by_seed else {OF_RANDOMIZER: True})
        twin.node = replace(self.node, inputs=inputs, path=None)
        return twin

    def key(self, consumer: str) -> str:
        """Return what the draws for the node with key `consumer` are keyed by, next to the seed."""
        return "" if self.goes_by_seed else self._shared.key(consumer)

    def rows(self, consumer: str, prims: Sequence[str]) -> Sequence[str]:
        """Return what the rows of draws are keyed by: their prims, or their places where the seed is the script's."""
        if self.goes_by_seed:
            return [str(place) for place in range(len(prims))]
        return self._shared.rows(consumer, prims)

    def note_use(self, consumer: str, node: Node, trigger: Hashable) -> None:
        self._shared.note(consumer, node, trigger)
        for part, its_consumer in self.parts(consumer):
            part.note_use(its_consumer, node, trigger)

    def parts(self, consumer: str) -> Iterator[tuple["Distribution", str]]:
        """Yield the distributions that it draws from, each with the key by which it draws for `consumer`."""
        yield from ()

    def set_input(self, name: str, value: Any) -> None:
        """Set a bound, choice or seed from the next execution on.

        Inputs are set one after the other: where they do not fit each other, the next draw raises the GraphError.

        Raises:
            UnknownInput: (a GraphError) there is no such input; the message names a near miss.
            GraphError: the value is not possible.
        """
        name = name.removeprefix("inputs:")
        if name not in (known := _KINDS[self.node.kind].inputs):
            near = near_misses(name, known)
            hint = f"did you mean {near[0]!r}?" if near else f"it has {', '.join(known)}"
            raise UnknownInput(f"{self.node.describe()} has no input {name!r}; {hint}")
        try:
            changed = from_inputs(self.node.kind, {**self.node.inputs, name: value}, self.node.name)
        except InputsDiffer as error:
            super().set_input(name, value)
            self._misfit = error
            return
        super().set_input(name, value)
        self._misfit = None
        self.__dict__.update({key: own for key, own in changed.__dict__.items() if key not in ("node", "_shared")})

    def _check_fit(self) -> None:
        """Raise what keeps the inputs that were set last from being drawn from."""
        if self._misfit is not None:
            raise self._misfit

    def _known_inputs(self) -> list[str]:
        return list(_KINDS[self.node.kind].inputs)

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

    def named_samples(self, consumer: str, execution: int, prims: Sequence[str]) -> dict[str, Any]:
        """Return the draw of this distribution, if it has a name, and those of `named_parts`, by name."""
        own = {self.node.name: self.sample(consumer, execution, prims)} if self.node.name else {}
        return own | self.named_parts(consumer, execution, prims)

    def held(self) -> Sequence[Any]:
        """Return the values that it draws from, of which some may be distributions."""
        return ()

    def names(self) -> list[str]:
        """Return the names of this distribution and of those that it holds, at any depth."""
        inner = [name for each in self.held() if isinstance(each, Distribution) for name in each.names()]
        return [*filter(None, [self.node.name]), *inner]

    def _listed(self, name: str, given: Any, *, groups_count_as_one: bool = False) -> list[Any]:
        """Return the values of an argument that is a list, prims as their paths; those of items are their prims.

        groups_count_as_one: items in the list stay items, as where there is a weight for each.
        """
        if isinstance(given, ReplicatorItem) and not isinstance(given, Distribution):
            given = given.prims
        # A string is iterable, but its characters are not the values.
        if isinstance(given, (str, bytes, Distribution)) or not isinstance(given, Iterable):
            raise GraphError(f"{self.node.describe()}: {name} is {shown(given)}; expected a list")
        if isinstance(given, (set, frozenset)):
            if groups_count_as_one:
                raise GraphError(
                    f"{self.node.describe()}: {name} is a set, whose values have no order in which they could have "
                    "weights; give a list"
                )
            # Python orders texts in sets anew in every process, and runs repeat.
            given = sorted(given, key=lambda value: (type(value).__name__, str(value)))
        if not groups_count_as_one:
            given = [each for value in given for each in (_prims_of(value) or [value])]
        if not (items := [str(item.GetPath()) if hasattr(item, "GetPath") else item for item in given]):
            raise GraphError(f"{self.node.describe()}: {name} is empty; give at least one")
        for index, item in enumerate(items):
            if isinstance(item, (list, tuple)) and (inner := next(_distributions_in(item), None)) is not None:
                raise GraphError(
                    f"{self.node.describe()}: {name}[{index}] is a list with {inner.node.describe()} in it; nothing "
                    "would draw that. List the values that are drawn, or give distributions in place of lists."
                )
        return items

    @abc.abstractmethod
    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> np.ndarray | list[Any]:
        """Draw one value per prim for execution number `execution` of the node with key `consumer`."""

    def sample_worlds(self, consumer: str, executions: np.ndarray, prims: Sequence[str]) -> np.ndarray:
        """Draw for many executions: (executions, prims, ...), objects where values are no numbers of one shape."""
        return as_columns([list(self.sample(consumer, int(each), prims)) for each in executions])


def _prims_of(value: Any) -> Sequence[str]:
    """Return the prims of an item that is no distribution; none of other values."""
    value = item_of(value)
    return value.prims if isinstance(value, ReplicatorItem) and not isinstance(value, Distribution) else ()


def _distributions_in(values: Iterable[Any]) -> Iterator[Distribution]:
    """Yield the distributions in lists in lists."""
    for value in values:
        if isinstance(value, Distribution):
            yield value
        elif isinstance(value, (list, tuple)):
            yield from _distributions_in(value)


@dataclass(frozen=True)
class _Kind:
    """A type of node: its inputs as a saved graph and `set_input` name them, and what makes a distribution of them."""

    inputs: tuple[str, ...]
    make: Callable[[Mapping[str, Any], str | None], Distribution]


_KINDS: dict[str, _Kind] = {}


def add_kind(
    node_type: str, inputs: tuple[str, ...], make: Callable[[Mapping[str, Any], str | None], Distribution]
) -> None:
    """Add a type of node; `make` gets the inputs of a saved node, and its name."""
    _KINDS[node_type] = _Kind(inputs, make)


def from_inputs(kind: str, inputs: Mapping[str, Any], name: str | None) -> Distribution:
    """Return the distribution that a node of a saved graph describes.

    Raises:
        GraphError: the type of the node is not a distribution.
    """
    if kind not in _KINDS:
        raise GraphError(f"a node of type {kind} is not a distribution; known: {', '.join(_KINDS)}")
    item = _KINDS[kind].make(inputs, name)
    if inputs.get(OF_RANDOMIZER):
        item.node.inputs[OF_RANDOMIZER], item.goes_by_seed = True, False
    return item


def as_columns(values: list[list[Any]]) -> np.ndarray:
    """Return lists of one length of values as an array (lists, values, ...): numbers, or objects (lists, values)."""
    try:
        array = np.asarray(values)
        if array.dtype.kind in "fiub":
            return array
    except ValueError:  # of several lengths
        pass
    array = np.empty((len(values), len(values[0]) if values else 0), object)
    for row, own in zip(array, values):
        row[:] = own
    return array


def all_seeded(items: Sequence[Any], seed: int) -> list[Any]:
    """Return items, of which those that are distributions have a seed of their own."""
    return [item.seeded(seed) if isinstance(item, Distribution) else item for item in items]
