"""How many objects a population shows: a number, or a distribution of which one value is drawn per execution."""

from dataclasses import replace
from typing import Any

from usdsdg.arguments.values import count_of, shown
from usdsdg.distribution import Choice, Distribution, Sequence_, Uniform, draw, one_of
from usdsdg.errors import ArgumentError
from usdsdg.graph.node import Node


def checked_size(size: Any, seed: int | None) -> Any:
    """Return the `size` of a population; a distribution has the population's seed where that has one.

    Raises:
        ArgumentError: a size is not a whole number or negative, or the distribution has no largest value.
    """
    if not isinstance(size, Distribution):
        return count_of(size)
    largest_size(size)
    return one_of(size, seed)


def largest_size(size: Any) -> int:
    """Return how many objects a population can show at most.

    Raises:
        ArgumentError: as `checked_size`.
    """
    if isinstance(size, (Choice, Sequence_)):
        return max(count_of(option) for option in size.options())
    if isinstance(size, Uniform):
        bounds = [size.node.inputs[name] for name in ("lower", "upper")]
        if all(isinstance(bound, (int, float)) for bound in bounds) and bounds[0] >= 0:
            return count_of(int(bounds[1]))
    if isinstance(size, Distribution):
        raise ArgumentError(
            f"randomizer.instantiate: size is {shown(size)}, of which the largest value is not known or a value is "
            "no number of objects; give a choice or sequence of whole numbers, or a uniform between two numbers"
        )
    return count_of(size)


def drawn_size(node: Node, root: str, execution: int) -> int:
    """Return how many objects of the population of `node`, below `root`, an execution shows: numbers round down."""
    return int(draw(node.inputs["size"], replace(node, prims=(root,)), execution, "size")[0])
