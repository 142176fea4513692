"""Draws for the inputs of a node: from constants, lists with one value per prim, and distributions."""

from collections.abc import Sequence
from numbers import Real
from typing import Any

import numpy as np

from usdsdg.distribution.base import Distribution, as_columns
from usdsdg.distribution.of_lists import choice
from usdsdg.graph.node import Node
from usdsdg.graph.sampling import own_seed


def one_of(options: Any, seed: int | None) -> Distribution:
    """Return the distribution of a randomizer, from a distribution or a list, and its `seed` (None, < 0: global).

    Raises:
        GraphError: `options` is a distribution that was made with another seed.
    """
    drawn, own = options if isinstance(options, Distribution) else choice(options), own_seed(seed)
    return drawn if own is None else drawn.seeded(own)


def consumer_of(value: Distribution, node: Node, role: str) -> str:
    """Return what the draws for an input of a node are keyed by."""
    return f"{node.key}/{value.node.name or role}"


def draw(value: Any, node: Node, execution: int, role: str) -> list[Any]:
    """Return one value per prim of `node` for its input `role`: a constant, a list per prim, or a distribution."""
    return list(draw_column(value, node, execution, role))


def draw_column(value: Any, node: Node, execution: int, role: str) -> list[Any] | np.ndarray:
    """As `draw`, as an array with a row for each prim where a distribution draws numbers."""
    count = len(node.prims)
    if isinstance(value, Distribution):
        node.note_drawn(role)
        drawn = value.node.state["samples"] = value.sample(consumer_of(value, node, role), execution, node.prims)
        return drawn
    if isinstance(value, np.ndarray):
        value = list(value) if value.ndim else value.item()
    if isinstance(value, list) and len(value) == count and not is_vector(value):
        return value
    return [value] * count


def draw_worlds(value: Any, node: Node, executions: np.ndarray, role: str, *, patterns: bool = False) -> np.ndarray:
    """As `draw`, for many executions: (executions, prims, ...), objects where values are no numbers of one shape.

    patterns: as `draw_scalars`.
    """
    if not isinstance(value, Distribution):
        column = as_columns([(draw_scalars if patterns else draw)(value, node, 0, role)])
        return np.broadcast_to(column, (len(executions), *column.shape[1:]))
    consumer, together = consumer_of(value, node, role), patterns and value.has_patterns(len(node.prims))
    node.note_drawn(role, together=together)
    if together:
        return value.sample_worlds(consumer, executions, node.prims[:1])[:, 0]
    return value.sample_worlds(consumer, executions, node.prims)


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
        node.note_drawn(role, together=True)
        drawn = list(value.sample(consumer_of(value, node, role), execution, node.prims[:1])[0])
        value.node.state["samples"] = drawn
        return drawn
    return draw(value, node, execution, role)


def named_draws(value: Distribution, node: Node, role: str) -> dict[str, list[Any] | np.ndarray]:
    """Return what a node has drawn last of a distribution, if it has a name, and of those with a name inside of it.

    Draws depend only on their keys, so they are repeated instead of being stored.
    """
    last, (prims, together) = node.executions - 1, node.drawn_for(role)
    consumer, found = consumer_of(value, node, role), {}
    if value.node.name:
        found[value.node.name] = (
            list(value.sample(consumer, last, prims[:1])[0]) if together else value.sample(consumer, last, prims)
        )
    return found | value.named_parts(consumer, last, prims)


def is_vector(value: Sequence[Any]) -> bool:
    """Return whether a sequence is one vector of numbers, not a list of values."""
    return len(value) > 0 and all(isinstance(v, Real) and not isinstance(v, bool) for v in value)
