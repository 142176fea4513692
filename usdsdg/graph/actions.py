"""What the nodes of each type do: a table from node type to function, so that a saved graph can run again."""

from __future__ import annotations

from collections.abc import Callable

from usdsdg.graph.node import Node
from usdsdg.settings import write_drawn_setting

Action = Callable[[Node, int], None]

# The settings lie below the graph and cannot register themselves.
_ACTIONS: dict[str, Action] = {"OgnCarbSettings": write_drawn_setting}


def action(kind: str) -> Callable[[Action], Action]:
    """Register what a node of type `kind` does. It is called with the node and the execution number, and reads
    nothing but the node: what it needs is in `inputs` and `prims`, what it keeps between executions in `state`.
    """

    def register(function: Action) -> Action:
        _ACTIONS[kind] = function
        return function

    return register


def action_of(kind: str) -> Action | None:
    """What nodes of this type do; None for a type that only holds prims."""
    return _ACTIONS.get(kind)
