"""The registry of actions: the function that each node type executes, so that a saved graph can run again."""

import importlib
from collections.abc import Callable

from usdsdg.graph.node import Node

Action = Callable[[Node, int], None]

# Modules that register the actions of all node types when they are imported.
FAMILIES = ("usdsdg.create", "usdsdg.modify", "usdsdg.physics", "usdsdg.randomizer", "usdsdg.settings")

_ACTIONS: dict[str, Action] = {}
_OPTIONAL: dict[str, tuple[str, ...]] = {}


def action(kind: str, *optional: str) -> Callable[[Action], Action]:
    """Register the action of nodes of type `kind`, which may lack the inputs `optional`.

    It is called with the node and the number of its earlier executions, and reads only the node: its arguments are in
    `inputs` and `prims`, values kept between executions in `state`.
    """

    def register(function: Action) -> Action:
        _ACTIONS[kind] = function
        _OPTIONAL[kind] = optional
        return function

    return register


def action_of(kind: str) -> Action | None:
    """Return the action of a node type; None for a type that only holds prims."""
    return _ACTIONS.get(kind)


def optional_inputs(kind: str) -> tuple[str, ...]:
    """Return the inputs that nodes of a type may have or lack."""
    return _OPTIONAL.get(kind, ())


def load_actions() -> None:
    """Import all families, so that the actions of all node types are registered."""
    for family in FAMILIES:
        importlib.import_module(family)
