"""Draws for many worlds at once: world w shows what the graph would draw for the w-th frame from now on.

World 0 is authored on the stage, by the actions of the nodes. What they would write in the other worlds, their twins
for worlds compute as arrays, with one call for all worlds. A node without a twin is refused.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from usdsdg.errors import GraphError, Unsupported, UsdsdgError
from usdsdg.graph.evaluate import Graph, Trigger, run
from usdsdg.graph.node import Node
from usdsdg.stage.world_values import WorldValues

# Of a node with the numbers of its executions in all worlds: set what it would write.
Twin = Callable[[Node, np.ndarray, WorldValues], None]

_TWINS: dict[str, Twin] = {}
_REMEDY = "Leave it out, or run without worlds."


def in_worlds(kind: str) -> Callable[[Twin], Twin]:
    """Register the twin for worlds of the action of nodes of type `kind`."""

    def register(function: Twin) -> Twin:
        _TWINS[kind] = function
        return function

    return register


def evaluate_worlds(graph: Graph, frame: int, count: int) -> WorldValues:
    """Run pending nodes, author what frame `frame` shows on the stage, and return the values of worlds.

    World w is frame `frame + w` of a run of single frames: its values, samples and labels are the same.

    Raises:
        Unsupported: a trigger does not fire by frames, or a node has no twin for worlds; names the script line.
        GraphError: a node failed; the message names the script line that made it.
    """
    impulses, graph.impulses = graph.impulses, []
    for node in impulses:
        run(node)
    values = WorldValues(count)
    for trigger in graph.triggers:
        _fire(trigger, executions_at(trigger, frame + np.arange(count)), values)
    return values


def executions_at(trigger: Trigger, frames: np.ndarray) -> np.ndarray:
    """Return the number of the last execution of a trigger's nodes at each frame.

    Raises:
        Unsupported: the trigger does not fire by frames.
    """
    if trigger.kind != "OgnOnFrame":
        raise Unsupported(f"worlds: {trigger.node.describe()} does not fire by frames, as worlds need. {_REMEDY}")
    last = frames // int(trigger.node.inputs["interval"])
    return np.minimum(last, trigger.max_execs - 1) if trigger.max_execs > 0 else last


def _fire(trigger: Trigger, executions: np.ndarray, values: WorldValues) -> None:
    first, last = int(executions[0]), int(executions[-1])
    for node in trigger.nodes:
        if node.executions != first + 1:
            node.executions = first
            run(node)
        if last > first:
            _run_twin(node, executions, values)
    trigger.executions = last + 1


def _run_twin(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    twin = _TWINS.get(node.kind)
    if twin is None:
        raise Unsupported(f"worlds: {node.describe()} cannot be drawn for many worlds at once. {_REMEDY}")
    try:
        twin(node, executions, values)
    except Unsupported as error:
        raise Unsupported(f"worlds: {node.describe()}: {error}") from error
    except UsdsdgError as error:
        raise GraphError(f"{node.describe()}: {error}") from error


@in_worlds("OgnWriteSemantics")
def _same_in_all(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    """Write nothing: these nodes draw nothing, so what world 0 has is the same everywhere."""
