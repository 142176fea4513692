"""What the nodes of each type do: a table from node type to function, so that a saved graph can run again."""

from __future__ import annotations

import importlib
from collections.abc import Callable

from usdsdg.graph.node import Node

Action = Callable[[Node, int], None]

# Modules that register the actions of all node types when they are imported.
FAMILIES = ("usdsdg.create", "usdsdg.modify", "usdsdg.physics", "usdsdg.randomizer", "usdsdg.settings")

_ACTIONS: dict[str, Action] = {}


def action(kind: str) -> Callable[[Action], Action]:
    """Register the action of nodes of type `kind`.

    It is called with the node and the number of executions before, and reads nothing but the node: what it needs is in
    `inputs` and `prims`, what it keeps between executions in `state`.
    """

    def register(function: Action) -> Action:
        _ACTIONS[kind] = function
        return function

    return register


def action_of(kind: str) -> Action | None:
    """The action of nodes of this type; None for a type that only holds prims."""
    return _ACTIONS.get(kind)


def load_actions() -> None:
    """Import all families, so that the action of every node type is known, whichever scripts have called."""
    for family in FAMILIES:
        importlib.import_module(family)
