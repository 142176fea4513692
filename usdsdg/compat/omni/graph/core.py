"""`omni.graph.core`: evaluation of the randomization graph, and graphs that process a camera's images.

Scripts use it to run randomizers at once (`Controller.evaluate_sync`) and to add the signal processing of
`omni.sensors.nv.camera` to a render product. Any other node type raises `Unsupported` with its name. Nodes of the
randomization graph are found by their path, and their inputs can be set.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence
from typing import Any

from usdsdg.app.app import get_app
from usdsdg.compat.omni.graph.camera_nodes import NODE_TYPES
from usdsdg.compat.omni.graph.graphs import (
    Attribute,
    Graph,
    Node,
    OmniGraphError,
    StageAttribute,
    attribute_of,
    find_attribute,
    find_node,
    graphs,
)
from usdsdg.errors import Unsupported
from usdsdg.graph import evaluate
from usdsdg.graph import node as randomization
from usdsdg.graph.node_attributes import NodeAttribute
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.scopes import PIPELINE

__all__ = [
    "Attribute", "AttributeValueHelper", "Controller", "DataView", "Graph", "GraphPipelineStage", "Node",
    "OmniGraphError", "get_all_graphs", "get_graph_by_path", "get_node_by_path", "get_registered_nodes",
    "post_render_graph",
]  # fmt: skip

# Graphs of Replicator, which scripts pass to `evaluate_sync`.
REPLICATOR = (PIPELINE, "/Render/PostProcess/SDGPipeline")
# Of a camera, and of the randomization.
AnyGraph = Graph | evaluate.Graph
AnyNode = Node | randomization.Node
_MADE_BY_REPLICATOR = (
    f"omni.graph.core: nodes of {PIPELINE} are made by functions of rep, such as rep.modify.pose, or by "
    "rep.utils.create_node; only their inputs can be set"
)


class GraphPipelineStage(enum.Enum):
    """When a graph is evaluated."""

    GRAPH_PIPELINE_STAGE_SIMULATION = 0
    GRAPH_PIPELINE_STAGE_PRERENDER = 1
    GRAPH_PIPELINE_STAGE_POSTRENDER = 2
    GRAPH_PIPELINE_STAGE_ONDEMAND = 200


class Keys:
    """The keys of `Controller.edit`."""

    CREATE_NODES = "create_nodes"
    CONNECT = "connect"
    DISCONNECT = "disconnect"
    SET_VALUES = "set_values"
    DELETE_NODES = "delete_nodes"
    CREATE_PRIMS = "create_prims"
    CREATE_ATTRIBUTES = "create_attributes"
    CREATE_VARIABLES = "create_variables"
    EXPOSE_PRIMS = "expose_prims"
    PROMOTE_ATTRIBUTES = "promote_attributes"


class Controller:
    """Functions on graphs, all static; an instance has no state."""

    Keys = Keys

    def __init__(self, *_: object, **__: object) -> None:
        pass

    @staticmethod
    def evaluate_sync(graph_id: object = None) -> None:
        """Run the nodes and events of the randomization graph that are pending, and the graphs of cameras.

        graph_id: a graph to run alone, or a list; paths of Replicator's own graphs stand for the randomization graph.
        """
        for graph in _listed(graph_id):
            if isinstance(graph, Graph) and graph.path not in REPLICATOR:
                graph.evaluate()
            else:
                evaluate.graph().evaluate(time=get_timeline().get_elapsed_time())
                if graph is None:
                    graphs().evaluate()

    @staticmethod
    async def evaluate(graph_id: object = None) -> None:
        """Run `evaluate_sync`, then wait for the next update."""
        Controller.evaluate_sync(graph_id)
        await get_app().next_update_async()

    @staticmethod
    def edit(
        graph_id: AnyGraph | str | Mapping[str, Any], edit_commands: Mapping[str, Any] | None = None
    ) -> tuple[AnyGraph, list[Node], list[Any], dict[str, Any]]:
        """Add nodes to a graph, connect them and set inputs; return the graph, its new nodes, [] and nodes by name.

        Of the randomization graph only inputs can be set: its nodes are made by functions of Replicator.

        Raises:
            Unsupported: a node type, or another kind of edit, that we do not have; the message names it.
            OmniGraphError: a node or attribute does not exist.
        """
        graph = _graph_of(graph_id)
        commands = dict(edit_commands or {})
        if isinstance(graph, evaluate.Graph):
            return _with_values(graph, commands)
        made = [graph.create_node(name, kind) for name, kind in _pairs(commands.pop(Keys.CREATE_NODES, ()))]
        for name in _listed(commands.pop(Keys.DELETE_NODES, ())):
            graph.nodes.pop(str(name), None)
        for source, target in _pairs(commands.pop(Keys.CONNECT, ())):
            graph.connect(source, target)
        for source, target in _pairs(commands.pop(Keys.DISCONNECT, ())):
            graph.disconnect(source, target)
        for path, value in _pairs(commands.pop(Keys.SET_VALUES, ())):
            Controller.attribute(path, graph).set(value)
        if left := [key for key, value in commands.items() if value]:
            raise Unsupported(f"omni.graph.core: Controller.edit cannot do {', '.join(map(str, left))}")
        graph.watch()
        return graph, made, [], dict(graph.nodes)

    @staticmethod
    def create_graph(graph_id: AnyGraph | str | Mapping[str, Any]) -> AnyGraph:
        return _graph_of(graph_id)

    @staticmethod
    def create_node(node_id: str | tuple[str, Any], node_type_id: str, *_: object, **__: object) -> Node:
        """Add a node to a graph, by its path or as (name, graph); return it.

        Raises:
            Unsupported: a node type that we do not have; the message names it.
        """
        path = node_id if isinstance(node_id, str) else ""
        name, graph_id = (path.rpartition("/")[2], path.rpartition("/")[0]) if path else node_id
        graph = _graph_of(graph_id)
        if isinstance(graph, evaluate.Graph):
            raise Unsupported(_MADE_BY_REPLICATOR)
        node = graph.create_node(str(name), str(node_type_id))
        graph.watch()
        return node

    @staticmethod
    def graph(graph_id: AnyGraph | str) -> AnyGraph | None:
        return graph_id if isinstance(graph_id, AnyGraph) else get_graph_by_path(str(graph_id))

    @staticmethod
    def node(node_id: AnyNode | str | tuple[str, Any], graph_id: AnyGraph | None = None) -> AnyNode:
        """Return a node by its path, or by its name in a graph.

        Raises:
            OmniGraphError: there is none.
        """
        if isinstance(node_id, AnyNode):
            return node_id
        name, graph = node_id if isinstance(node_id, tuple) else (node_id, graph_id)
        found = graph.get_node(str(name)) if isinstance(graph, AnyGraph) else find_node(str(name))
        if found is None:
            raise OmniGraphError(f"omni.graph.core: there is no node {name}")
        return found

    @staticmethod
    def attribute(attribute_id: Any, node_id: Any = None) -> Attribute | NodeAttribute | StageAttribute:
        """Return an attribute by "/graph/node.inputs:name", by ("inputs:name", node), or by both arguments.

        Raises:
            OmniGraphError: there is none.
        """
        if isinstance(attribute_id, (Attribute, NodeAttribute, StageAttribute)):
            return attribute_id
        if isinstance(attribute_id, tuple):
            attribute_id, node_id = attribute_id
        path = str(attribute_id)
        if isinstance(node_id, AnyGraph):
            name, _, attribute = path.rpartition(".")
            return attribute_of(Controller.node(name, node_id), attribute)
        return find_attribute(path) if node_id is None else attribute_of(Controller.node(node_id), path)

    @staticmethod
    def get(attribute: Any, *_: object, **__: object) -> Any:
        return Controller.attribute(attribute).get()

    @staticmethod
    def set(attribute: Any, value: Any, *_: object, **__: object) -> bool:
        Controller.attribute(attribute).set(value)
        return True


class AttributeValueHelper:
    """The value of one attribute."""

    def __init__(self, attribute: Any) -> None:
        self._attribute = Controller.attribute(attribute)

    def get(self, *_: object, **__: object) -> Any:
        return self._attribute.get()

    def set(self, value: Any, *_: object, **__: object) -> None:
        self._attribute.set(value)


class DataView:
    """Values of attributes."""

    get = staticmethod(Controller.get)
    set = staticmethod(Controller.set)


def get_all_graphs() -> list[Graph]:
    return graphs().all()


def get_registered_nodes() -> list[str]:
    """Return the types of nodes that a graph may have."""
    return sorted(NODE_TYPES)


def get_graph_by_path(path: str) -> AnyGraph | None:
    """Return the graph at `path`; None if there is none."""
    if str(path) == PIPELINE:
        return evaluate.graph()
    known = graphs().at(str(path))
    return Graph(str(path)) if known is None and str(path) in REPLICATOR else known


def get_node_by_path(path: str) -> AnyNode | None:
    return find_node(str(path))


def post_render_graph(render_product_path: str) -> Graph:
    """Return the graph that processes the images of a render product."""
    return graphs().add(Graph(f"{render_product_path}/PostRender", render_product_path))


def _with_values(graph: evaluate.Graph, commands: dict[str, Any]) -> tuple[AnyGraph, list[Node], list[Any], dict]:
    """Set inputs of nodes of the randomization graph, as `Controller.edit` does."""
    values = _pairs(commands.pop(Keys.SET_VALUES, ()))
    if any(commands.values()):
        raise Unsupported(_MADE_BY_REPLICATOR)
    for path, value in values:
        Controller.attribute(path, graph).set(value)
    return graph, [], [], {node.get_prim_path().rpartition("/")[2]: node for node in graph.get_nodes()}


def _graph_of(graph_id: AnyGraph | str | Mapping[str, Any]) -> AnyGraph:
    if isinstance(graph_id, AnyGraph):
        return graph_id
    path = str(graph_id.get("graph_path", "")) if isinstance(graph_id, Mapping) else str(graph_id)
    return get_graph_by_path(path) or graphs().add(Graph(path))


def _pairs(entries: Any) -> Sequence[tuple[Any, Any]]:
    """Return a list of pairs; a single pair may be given by itself."""
    listed = list(entries)
    return [tuple(listed)] if len(listed) == 2 and isinstance(listed[0], str) else [tuple(each) for each in listed]


def _listed(value: Any) -> list[Any]:
    return list(value) if isinstance(value, (list, tuple)) else [value]
