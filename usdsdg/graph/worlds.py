"""Draws for many worlds at once: world w shows what the graph would draw for the w-th frame from now on.

World 0 is authored on the stage, by the actions of the nodes. What they would write in the other worlds, their twins
for worlds compute as arrays, with one call for all worlds; where a node reads what others write in another frame, with
one call for each. A node without a twin is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import nullcontext, suppress

import numpy as np
from pxr import Usd

from usdsdg.errors import GraphError, Unsupported, UsdsdgError
from usdsdg.graph.evaluate import Graph, run
from usdsdg.graph.firings import REMEDY, Firings
from usdsdg.graph.live_prims import LivePrims
from usdsdg.graph.node import Node
from usdsdg.graph.world_sequence import WorldSequence
from usdsdg.graph.world_uses import WorldUses
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
from usdsdg.stage.world_values import WorldValues

# Of a node with the numbers of its executions in all worlds: set what it would write.
Twin = Callable[[Node, np.ndarray, WorldValues], None]

_TWINS: dict[str, Twin] = {}


def in_worlds(kind: str) -> Callable[[Twin], Twin]:
    """Register the twin for worlds of the action of nodes of type `kind`."""

    def register(function: Twin) -> Twin:
        _TWINS[kind] = function
        return function

    return register


class WorldDraws:
    """The draws of the graph for frame `frame` and those that follow, one for each of `count` worlds.

    Making one runs pending nodes, and authors what frame `frame` shows; the stage has to show the frame before. With
    `is_shown` the stage shows `frame` already, and nothing is run.

    Raises:
        Unsupported: a trigger does not fire by frames; nothing has been run then.
        GraphError: a node failed; the message names the script line that made it.
    """

    def __init__(self, graph: Graph, frame: int, count: int, *, is_shown: bool = False) -> None:
        frames = frame + np.arange(count)
        if not is_shown:
            graph.adopt_edits()
        self._firings = [Firings.of(trigger, frames) for trigger in graph.triggers]
        self.count, self._frames = count, frames
        if not is_shown:
            self._show_first(graph)
        # What follows counts from here.
        self._executed = [firings.trigger.executions for firings in self._firings]
        self._runs = [(firings, node, node.executions) for firings in self._firings for node in firings.trigger.nodes]

    def _show_first(self, graph: Graph) -> None:
        graph.run_impulses()
        for firings in self._firings:
            if firings.fires[0]:
                for node in firings.trigger.nodes:
                    run(node)
                firings.trigger.executions += 1
                firings.trigger.latest = int(self._frames[0])

    def independent_values(self) -> WorldValues | None:
        """Return what the worlds have where none depends on an earlier one; else, or where it is not known, None.

        Then what a node writes depends on the number of its execution alone, and no node of another trigger writes it.
        """
        uses = WorldUses()
        try:
            values = self._drawn_together(uses, lenient=False, only_independent=True)
        except UsdsdgError:  # evaluating the frames tells what is wrong, where it is
            return None
        written = {(path, name) for path, drawn in values.values.items() for name in drawn}
        return values if uses.are_in_order and written.isdisjoint(values.read_from_stage) else None

    def values(self) -> WorldValues:
        """Return what the worlds have instead of what the stage has.

        Raises:
            Unsupported: a node has no twin for worlds, or its twin cannot do this; names the script line.
            GraphError: a node failed, likewise.
        """
        uses = WorldUses()
        try:
            values = self._drawn_together(uses)
        except GraphError:
            # A node may have read what its frame does not have; drawn in turn it fails only where the frame would.
            uses.are_in_order = False
        return values if uses.are_in_order else self._drawn_in_turn()

    def _drawn_together(
        self, uses: WorldUses, *, lenient: bool = True, only_independent: bool = False
    ) -> WorldValues:  # fmt: skip
        """Return the values of all worlds by one call of each twin; note in `uses` what twins read and write.

        lenient: leave out what a twin cannot do where all worlds have the same.
        """
        values = WorldValues(self.count, stage_time(current_stage()), only_independent=only_independent)
        for firings, node, executed in self._runs:
            executions = executed - 1 + firings.later()
            if executions[0] < 0:
                if executions[-1] < 0:
                    continue
                raise Unsupported(f"worlds: {node.describe()} has not run yet and is about to. {REMEDY}")
            # Where all worlds have one draw it is on the stage, and among the values for those who save a world.
            is_same = executions[-1] == executions[0]
            with suppress(Unsupported) if is_same and (lenient or firings.trigger.exhausted) else nullcontext():
                _run_twin(node, executions, values)
            uses.note((*firings.cadence, executed), values, is_steady=firings.is_steady)
        values.steady = uses.steady()
        return values

    def _drawn_in_turn(self) -> WorldValues:
        """Return the values of all worlds by calls of twins for one world after the other."""
        sequence = WorldSequence(current_stage(), self.count, stage_time(current_stage()))
        for world in range(1, self.count):
            for node, execution in self._runs_of(world):
                _run_twin(node, np.array([execution]), sequence.now)
            sequence.close(world)
        for firings, node, executed in self._runs:
            if executed and not firings.fires[1:].any():
                scratch = WorldValues(1, sequence.now.time)
                # As where all are drawn together: all worlds have the same, which is on the stage. There, what a node
                # has read may have been moved by those after it, so that it could not run again.
                with suppress(Unsupported, GraphError):
                    _run_twin(node, np.array([executed - 1]), scratch)
                sequence.keep(scratch)
        return sequence.values

    def _runs_of(self, world: int) -> Iterator[tuple[Node, int]]:
        """Go over the nodes that run in a world after the first, with the numbers of their executions."""
        for firings, node, executed in self._runs:
            if firings.fires[world]:
                yield node, executed - 1 + int(firings.later()[world])

    def count_triggers(self, world: int = -1) -> None:
        """Count the firings up to a world, the last one by default."""
        end = world % self.count + 1
        for firings, executed in zip(self._firings, self._executed):
            firings.trigger.executions = executed + int(firings.later()[world])
            if (fired := self._frames[:end][firings.fires[:end]]).size:
                firings.trigger.latest = int(fired[-1])
        for firings, node, executed in self._runs:
            node.executions = executed + int(firings.later()[world])

    def author(self, values: WorldValues, stage: Usd.Stage, world: int) -> None:
        """Author what a world shows, and count firings and executions up to it."""
        values.author(stage, world)
        self.count_triggers(world)


def _run_twin(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    twin = _TWINS.get(node.kind)
    if isinstance(node.prims, LivePrims) and node.prims.depend_on_labels:
        # Nothing that is drawn for many worlds adds prims, but labels may be others in each.
        raise Unsupported(f"worlds: {node.describe()} acts on prims that it searches by labels each time. {REMEDY}")
    if twin is None:
        raise Unsupported(f"worlds: {node.describe()} cannot be drawn for many worlds at once. {REMEDY}")
    try:
        twin(node, executions, values)
    except Unsupported as error:
        raise Unsupported(f"worlds: {node.describe()}: {error}. {REMEDY}") from error
    except UsdsdgError as error:
        raise GraphError(f"{node.describe()}: {error}") from error
