"""Node inputs with one number per prim."""

import numpy as np

from usdsdg.arguments.values import shown
from usdsdg.distribution import Distribution, draw
from usdsdg.errors import ArgumentError
from usdsdg.graph.node import Node


def draw_numbers(role: str, node: Node, execution: int) -> np.ndarray:
    """Return (len(node.prims),) numbers of the input `role`: one for all, a list of one per prim, or a distribution.

    Raises:
        ArgumentError: it is something else.
    """
    value = node.inputs[role]
    drawn = draw(value, node, execution, role) if isinstance(value, Distribution) else value
    try:
        numbers = np.asarray(drawn, np.float64)
    except (TypeError, ValueError):
        numbers = np.full((0, 0), np.nan)
    if numbers.shape not in ((), (len(node.prims),)):
        raise ArgumentError(f"{role} is {shown(drawn)}; expected one number, or a list of one per prim")
    return np.broadcast_to(numbers, len(node.prims))
