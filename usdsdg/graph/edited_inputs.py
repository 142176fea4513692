"""Inputs of nodes that a script has edited at the nodes' prims, with pxr, while it runs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pxr import Sdf, Usd

from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.graph.node_prims import decoded
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.change_tracker import ChangeTracker
from usdsdg.stage.changes import Changes
from usdsdg.stage.scopes import PIPELINE

_PREFIX = "inputs:"


class EditedInputs:
    """What is edited below the graph's prim other than by the graph itself."""

    def __init__(self) -> None:
        self._stage: Usd.Stage | None = None
        self._tracker: ChangeTracker | None = None
        self._of_others: Changes | None = None  # the last edits, if none of them was here: they mostly come again

    @contextmanager
    def own(self) -> Iterator[None]:
        """Author nodes in this block, and listen from then on to what others edit at them."""
        stage = current_stage()
        if self._tracker is None or stage != self._stage:
            self._stage, self._tracker = stage, ChangeTracker(stage)
        with self._tracker.muted():
            yield

    def take(self) -> list[Sdf.Path]:
        """Return the paths of the inputs that were edited since the last call."""
        if self._tracker is None or self._stage != current_stage():
            return []
        changes = self._tracker.take()
        if changes is self._of_others:
            return []
        edited = (path.GetPrimPath().AppendProperty(path.name) for path in changes.edited if path.IsPropertyPath())
        found = [path for path in edited if path.HasPrefix(PIPELINE) and path.name.startswith(_PREFIX)]
        self._of_others = None if found else changes
        return found


def adopt_input(node: Node, path: Sdf.Path) -> None:
    """Give a node the value that its prim has at the attribute `path`, or the targets of that relationship.

    Raises:
        UnknownInput: (a ValueError and a KeyError) the node has no such input.
        GraphError: it is an input of a trigger, which cannot have the value.
    """
    prop = current_stage().GetPropertyAtPath(path)
    item = node.item or ReplicatorItem(node)
    name = path.name.removeprefix(_PREFIX)
    if isinstance(prop, Usd.Relationship):
        item.set_input(name, [str(target) for target in prop.GetTargets()])
    elif isinstance(prop, Usd.Attribute) and not prop.HasAuthoredConnections() and prop.HasAuthoredValue():
        item.set_input(name, decoded(prop))
