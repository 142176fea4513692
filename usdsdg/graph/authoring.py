"""Author the graph on the stage: a prim for each node when it is added, so that a saved stage can run it."""

from typing import Any

from pxr import Sdf

from usdsdg.graph.live_prims import LivePrims
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.graph.node_prims import Link, NodeRecord, define_graph, define_node, write_input
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import paths
from usdsdg.stage.scopes import PIPELINE

IMPULSE = f"{PIPELINE}/OnImpulseEvent"


def author(node: Node, *, after: str | None) -> None:
    """Author a node that executes after the one at `after`, and store its path in `node.path`."""
    stage = current_stage()
    inputs = {name: _linked(value) for name, value in node.inputs.items()}
    metadata = {"key": node.key, "line": node.line, "name": node.name or ""}
    metadata["search"] = node.prims.text() if isinstance(node.prims, LivePrims) else ""
    node.layer = stage.GetRootLayer()
    with current().graph.edits.own():
        define_graph(stage)
        node.path = paths.next_free_path(stage, f"{PIPELINE}/{node.kind}")
        define_node(stage, node.path, NodeRecord(node.kind, inputs, node.prims, after, _given(metadata)))


def author_impulse() -> str:
    """Return the path of the impulse node, which starts the nodes that run once; author it if there is none."""
    stage = current_stage()
    if not stage.GetPrimAtPath(IMPULSE):
        with current().graph.edits.own():
            define_graph(stage)
            define_node(stage, IMPULSE, NodeRecord("OnImpulseEvent"))
    return IMPULSE


def author_input(node: Node, name: str) -> None:
    """Author the current value of one input of an authored node."""
    stage = current_stage()
    if is_authored(node):
        value = _linked(node.inputs[name])
        with current().graph.edits.own():
            write_input(stage.GetPrimAtPath(node.path), name, value)


def author_prims(node: Node) -> None:
    """Author the current target prims of an authored node."""
    if is_authored(node):
        with current().graph.edits.own():
            relation = current_stage().GetPrimAtPath(node.path).CreateRelationship("inputs:prims", custom=False)
            relation.SetTargets([Sdf.Path(path) for path in node.prims])


def is_authored(node: Node) -> bool:
    """Return whether the node is on the current stage."""
    stage = current_stage()
    return node.path is not None and node.layer == stage.GetRootLayer() and bool(stage.GetPrimAtPath(node.path))


def _given(metadata: dict[str, str]) -> dict[str, str]:
    return {name: text for name, text in metadata.items() if text}


def _linked(value: Any) -> Any:
    """Replace distributions by links to their prims, which are authored on first use."""
    if isinstance(value, ReplicatorItem):
        if not is_authored(value.node):
            author(value.node, after=None)
        return Link(str(value.node.path))
    if isinstance(value, (list, tuple)) and any(isinstance(each, ReplicatorItem) for each in value):
        return [_linked(each) for each in value]
    return value
