"""Draws for many worlds at once: world w shows what the graph would draw for the w-th frame from now on.

World 0 is authored on the stage, by the actions of the nodes. What they would write in the other worlds, their twins
for worlds compute as arrays, with one call for all worlds. A node without a twin is refused.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext, suppress

import numpy as np
from pxr import Usd

from usdsdg.errors import GraphError, Unsupported, UsdsdgError
from usdsdg.graph.evaluate import Graph, Trigger, run
from usdsdg.graph.node import Node
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
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


class WorldDraws:
    """The draws of the graph for frame `frame` and those that follow, one for each of `count` worlds.

    Making one runs pending nodes, and authors what frame `frame` shows.

    Raises:
        Unsupported: a trigger does not fire by frames; nothing has been run then.
        GraphError: a node failed; the message names the script line that made it.
    """

    def __init__(self, graph: Graph, frame: int, count: int) -> None:
        frames = frame + np.arange(count)
        self._fired = [(trigger, executions_at(trigger, frames)) for trigger in graph.triggers]
        self.count = count
        impulses, graph.impulses = graph.impulses, []
        for node in impulses:
            run(node)
        for trigger, executions in self._fired:
            for node in trigger.nodes:
                if node.executions != executions[0] + 1:
                    node.executions = int(executions[0])
                    run(node)
            # Frame 0, the first execution, is what a preview draws.
            trigger.executions, trigger.previews = int(executions[0]) + 1, 1

    def values(self) -> WorldValues:
        """Return what the worlds have instead of what the stage has.

        Raises:
            Unsupported: a node has no twin for worlds, or its twin cannot do this; names the script line.
            GraphError: a node failed, likewise.
        """
        values = WorldValues(self.count, stage_time(current_stage()))
        for trigger, executions in self._fired:
            differs = executions[-1] > executions[0]
            for node in trigger.nodes:
                # Where all worlds have one draw it is on the stage, and among the values for those who save a world.
                with nullcontext() if differs else suppress(Unsupported):
                    _run_twin(node, executions, values)
        return values

    def count_triggers(self) -> None:
        """Count the firings of all worlds, of which the stage shows the first."""
        for trigger, executions in self._fired:
            trigger.executions = int(executions[-1]) + 1

    def author(self, values: WorldValues, stage: Usd.Stage, world: int) -> None:
        """Author what a world shows, and count firings and executions up to it."""
        values.author(stage, world)
        for trigger, executions in self._fired:
            trigger.executions = int(executions[world]) + 1
            for node in trigger.nodes:
                node.executions = trigger.executions


def executions_at(trigger: Trigger, frames: np.ndarray) -> np.ndarray:
    """Return the number of the last execution of a trigger's nodes at each frame.

    Raises:
        Unsupported: the trigger does not fire by frames.
    """
    if trigger.kind != "OgnOnFrame":
        raise Unsupported(f"worlds: {trigger.node.describe()} does not fire by frames, as worlds need. {_REMEDY}")
    last = frames // int(trigger.node.inputs["interval"])
    return np.minimum(last, trigger.max_execs - 1) if trigger.max_execs > 0 else last


def _run_twin(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    twin = _TWINS.get(node.kind)
    if twin is None:
        raise Unsupported(f"worlds: {node.describe()} cannot be drawn for many worlds at once. {_REMEDY}")
    try:
        twin(node, executions, values)
    except Unsupported as error:
        raise Unsupported(f"worlds: {node.describe()}: {error}. {_REMEDY}") from error
    except UsdsdgError as error:
        raise GraphError(f"{node.describe()}: {error}") from error
