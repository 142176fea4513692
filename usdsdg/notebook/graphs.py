"""The randomization graph: triggers in their order, and under each the nodes that it runs."""

from __future__ import annotations

from typing import Any

from usdsdg.errors import counted
from usdsdg.graph.evaluate import Graph, Trigger
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.notebook import html

_PREFIX = "Ogn"
_PRIMS = 3


def graph_html(graph: Graph) -> str:
    """Return what a notebook shows of the graph of a stage."""
    parts = [html.title("graph", counted(len(graph.triggers), "trigger"))]
    if graph.impulses:
        parts.append(_block("once, at the next evaluation", graph.impulses))
    parts += [trigger_html(trigger) for trigger in graph.triggers]
    if not graph.triggers:
        parts.append(html.note("with rep.trigger.on_frame(): … puts nodes under a trigger"))
    return "".join(parts)


def trigger_html(trigger: Trigger) -> str:
    """Return a trigger with its nodes."""
    limit = f"{trigger.executions} of " if trigger.max_execs else ""
    times = counted(trigger.max_execs or trigger.executions, "time")
    about = f"{_inputs(trigger.node)} · ran {limit}{times} · {trigger.node.line}"
    return _block(f"{trigger.node.name or _kind(trigger.node)}", trigger.nodes, about)


def item_html(item: ReplicatorItem) -> str:
    """Return the node of an item, with its inputs and prims."""
    if item.trigger is not None:
        return trigger_html(item.trigger)
    return _node(item.node)


def _block(name: str, nodes: list[Node], about: str = "") -> str:
    line = html.title(name, about).removeprefix("<div>").removesuffix("</div>")
    inside = "".join(map(_node, nodes)) or html.note("no nodes")
    return html.details(line, html.indented(inside), is_open=True)


def _node(node: Node) -> str:
    return html.title(
        node.name or _kind(node), " · ".join(filter(None, (_inputs(node), _prims(node.prims), node.line)))
    )


def _kind(node: Node) -> str:
    return node.kind.removeprefix(_PREFIX)


def _inputs(node: Node) -> str:
    return ", ".join(f"{name}={_value(value)}" for name, value in node.inputs.items())


def _value(value: Any) -> str:
    if isinstance(value, ReplicatorItem):
        return f"{_kind(value.node)}({_inputs(value.node)})"
    if isinstance(value, (list, tuple)):
        shown = ", ".join(_value(each) for each in value[:_PRIMS])
        return f"[{shown}{', …' if len(value) > _PRIMS else ''}]"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _prims(paths: tuple[str, ...]) -> str:
    more = f" and {len(paths) - _PRIMS} more" if len(paths) > _PRIMS else ""
    return f"on {', '.join(paths[:_PRIMS])}{more}" if paths else ""
