"""Nodes follow prims that are moved or renamed, as the targets of OmniGraph's relationships do."""

from typing import Any

from pxr import Sdf, Usd

from usdsdg.graph.authoring import author_input, author_prims
from usdsdg.graph.live_prims import LivePrims
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage

# What a node keeps of its last draws, which payloads repeat by the paths that prims had then; the rest are handles of
# prims, which a move has made invalid.
_KEPT = ("samples", "drawn_for")


def follow_move(source: str | Sdf.Path, target: str | Sdf.Path) -> None:
    """Let items, nodes and open blocks name the prims that were at and below `source` by their paths at `target`."""
    move = _Move(current_stage(), Sdf.Path(str(source)), Sdf.Path(str(target)))
    session = current()
    for node in list(session.nodes):
        _follow(node, move)
    session.open_groups[:] = [move.prims(group) for group in session.open_groups]
    session.graph.projections = None


class _Move:
    """The new paths of prims that were moved on a stage."""

    def __init__(self, stage: Usd.Stage, source: Sdf.Path, target: Sdf.Path) -> None:
        self._stage, self._source, self._target = stage, source, target

    def path(self, path: str) -> str:
        """Return the new path of a prim that was moved; other paths, and texts that name no prim, as they are."""
        if not path.startswith(str(self._source)) or not Sdf.Path.IsValidPathString(path):
            return path
        moved = Sdf.Path(path).ReplacePrefix(self._source, self._target)
        return str(moved) if moved != path and self._stage.GetPrimAtPath(moved) else path

    def prims(self, prims: tuple[str, ...]) -> tuple[str, ...]:
        """Return the paths of prims after the move."""
        return prims.renamed(self.path) if isinstance(prims, LivePrims) else tuple(map(self.path, prims))

    def value(self, value: Any) -> Any:
        """Return the value of an input after the move; items in it are those of nodes that follow on their own."""
        if isinstance(value, str):
            return self.path(value)
        if isinstance(value, (list, tuple)):
            moved = [self.value(each) for each in value]
            return value if all(new is old for new, old in zip(moved, value)) else type(value)(moved)
        if isinstance(value, ReplicatorItem):
            # The distribution of a randomizer with a seed of its own is a copy, which its node does not know.
            value.rename_held(self.value)
        return value


def _follow(node: Node, move: _Move) -> None:
    if node.path is not None:
        node.path = move.path(node.path)
    if (prims := move.prims(node.prims)) != node.prims:
        node.prims = prims
        author_prims(node)
    node.state = {name: value for name, value in node.state.items() if name in _KEPT}
    for name, value in node.inputs.items():
        if (moved := move.value(value)) is not value:
            node.inputs[name] = moved
            author_input(node, name)
    if node.item is not None:
        node.item.rename_held(move.value)
