"""Access to nodes of the randomization graph, and custom events.

Nodes are usdsdg's own, not OmniGraph's; functions about OmniGraph do the closest equivalent.
"""

import functools
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.registry import near_misses
from usdsdg.errors import UnknownInput, Unsupported, warn_once
from usdsdg.graph import evaluate
from usdsdg.graph.actions import action_of
from usdsdg.graph.evaluate import graph
from usdsdg.graph.node import Node, ReplicatorItem, current_prims, plain, prim_paths
from usdsdg.graph.node_prims import TYPE_PREFIX, define_graph
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.scopes import PIPELINE
from usdsdg.utils.prims import get_non_xform_prims

# Extensions whose node types usdsdg has some of.
EXTENSIONS = (TYPE_PREFIX.rstrip("."), "isaacsim.replicator.examples", "omni.replicator.isaac")


def get_reduced_ref_time(numerator: int, denominator: int) -> tuple[int, int]:
    """Return a time, as a fraction, in lowest terms; one with a zero stays."""
    if numerator == 0 or denominator == 0:
        return numerator, denominator
    common = math.gcd(numerator, denominator)
    return numerator // common, denominator // common


def send_og_event(event_name: str) -> None:
    """Fire `trigger.on_custom_event(event_name)` at the next app update or step, whichever comes first."""
    events = (trigger.node for trigger in graph().triggers if trigger.kind == "OnCustomEvent")
    known = sorted({node.inputs["eventName"] for node in events})
    if event_name not in known:
        near = near_misses(event_name, known)
        hint = f"did you mean {near[0]!r}?" if near else f"known events: {', '.join(known) or 'none'}."
        warn_once(f"send_og_event: no trigger waits for event {event_name!r}; {hint}")
    graph().send(event_name)


def get_replicator_graph_exists() -> bool:
    """Whether the stage has a randomization graph."""
    return bool(current_stage().GetPrimAtPath(PIPELINE))


def get_graph(graph_path: str | None = None, is_hidden: bool = False) -> evaluate.Graph:
    """Return the randomization graph, with its nodes; its prim is created if there is none. `is_hidden` is ignored.

    Raises:
        Unsupported: another path is given: there is one graph per stage.
    """
    if graph_path not in (None, PIPELINE):
        raise Unsupported(f"utils.get_graph: there is one graph per stage, {PIPELINE}; leave graph_path out")
    define_graph(current_stage())
    return graph()


def create_node(
    node_type_id: str, graph: Any = None, node_name: str | None = None, input_prims: Any = None, **attributes: Any
) -> Node:
    """Add a node of a type that usdsdg implements (`omni.replicator.core.OgnWritePose`) under the current trigger.

    The nodes of Isaac Sim's examples, `OgnSampleInSphere`, `OgnSampleOnSphere` (with `radius`) and
    `OgnSampleBetweenSpheres` (`radius1`, `radius2`) are among them.

    Args:
        graph: ignored: there is one graph per stage.
        node_name: replaces the default key of the node's random draws, as the `name` of a rep function does.
        input_prims: the targets: items, prims or paths; default, those of the enclosing `with group:`.
        attributes: inputs of the node, with or without the `inputs:` prefix.

    Raises:
        Unsupported: any other type; register a Python function with rep.randomizer.register instead.
    """
    extension, _, name = node_type_id.rpartition(".")
    kind = name if extension in ("", *EXTENSIONS) else node_type_id
    if action_of(kind) is None:
        raise Unsupported(
            f"utils.create_node: usdsdg has no node type {node_type_id!r}; compose rep functions and register them "
            "with rep.randomizer.register"
        )
    given = {name.removeprefix("inputs:"): plain(value) for name, value in attributes.items()}
    prims = prim_paths(input_prims) or current_prims()
    return evaluate.graph().add(Node(kind=kind, inputs=given, prims=prims, name=node_name))


def _node(node: Any) -> Node:
    return node.node if isinstance(node, ReplicatorItem) else node


def get_node_targets(node: Any, attribute: str, replicatorXform: bool = True) -> list[str]:
    """Return the paths of a node's prims (`inputs:prims`, `outputs:prims`), or of the prims in another of its inputs.

    replicatorXform: False returns for the Xform of a Replicator object its children.

    Raises:
        UnknownInput: (a GraphError) the node has no such input.
    """
    node = _node(node)
    name = attribute.removeprefix("inputs:")
    # OmniGraph names a bundle with a colon, and the prim that stands for it with an underscore.
    if name in ("prims", "outputs:prims", "outputs_prims", "inputs_prims"):
        found = list(node.prims)
    elif name in node.inputs:
        found = list(prim_paths(node.inputs[name]))
    else:
        known = ", ".join(["prims", *node.inputs])
        raise UnknownInput(f"get_node_targets: {node.describe()} has no input {attribute!r}; it has {known}")
    return found if replicatorXform else get_non_xform_prims(found)


def set_target_prims(node: Any, attribute: str, target_prims: Any) -> None:
    """Set the target prims of a node (`inputs:prims`), or the prims of another input, from the next execution on.

    Raises:
        BadPrim: a target is not on the stage.
    """
    node, targets = _node(node), prim_paths(target_prims)
    for path in targets:
        prim_at(path)
    name = attribute.removeprefix("inputs:")
    if name != "prims":
        ReplicatorItem(node).set_input(name, list(targets))
        return
    graph().retarget(node, targets)


def auto_connect(upstream_node: Any, downstream_node: Any, mapping: Any = None, no_exec: bool = False) -> None:
    """Check that `upstream_node` runs before `downstream_node`; nodes always run in the order of the script.

    A node that is None is left alone, as in Replicator. `no_exec` has no effect, as nodes have no connections.

    Raises:
        Unsupported: the second node was made before the first, or `mapping` says which attributes to connect.
    """
    if mapping:
        raise Unsupported(
            "utils.auto_connect: mapping is not available, since nodes have no connections; give the distribution as a "
            "value, as in utils.create_node(kind, values=distribution)"
        )
    if upstream_node is None or downstream_node is None:
        return
    order = [node for trigger in graph().triggers for node in trigger.nodes] + graph().impulses
    one, other = _node(upstream_node), _node(downstream_node)
    if one in order and other in order and order.index(other) < order.index(one):
        raise Unsupported(
            f"utils.auto_connect: {other.describe()} was made before {one.describe()}, and nodes run in the order of "
            "the script; make them in the other order"
        )


@contextmanager
def sequential() -> Iterator[None]:
    """Accept nodes that must run in sequence (context manager); usdsdg always runs nodes in sequence."""
    yield


def ReplicatorWrapper(function: Callable[..., Any]) -> Callable[..., ReplicatorItem]:
    """Wrap the returned node of a function in a ReplicatorItem (decorator)."""

    @functools.wraps(function)
    def wrapped(*args: Any, **kwargs: Any) -> ReplicatorItem:
        made = function(*args, **kwargs)
        return ReplicatorItem(made) if isinstance(made, Node) else made

    return wrapped
