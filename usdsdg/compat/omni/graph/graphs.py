"""Graphs of nodes that scripts build with `omni.graph.core`, evaluated at every update of the application."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Usd

from usdsdg.annotators import named_annotators
from usdsdg.annotators.annotator import Annotator
from usdsdg.app.app import get_app
from usdsdg.compat.omni.graph.camera_nodes import NODE_TYPES, Tick, annotator_of
from usdsdg.compat.omni.graph.camera_signal import Signal
from usdsdg.errors import Unsupported, UsdsdgError
from usdsdg.graph import evaluate
from usdsdg.graph import node as randomization
from usdsdg.graph.node_attributes import NodeAttribute
from usdsdg.graph.sampling import get_global_seed
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.scopes import PIPELINE

# Inputs and outputs that carry the image, and those that only pass on times and handles.
IMAGE_IN, IMAGE_OUT = "src", "dest"
PASSED_ON = {
    "exec", "execIn", "execOut", "gpu", "rp", "simTime", "hydraTime", "simTimeIn", "simTimeOut", "hydraTimeIn",
    "hydraTimeOut", "stream",
}  # fmt: skip


class OmniGraphError(UsdsdgError):
    """A graph, node or attribute does not exist."""


class Node:
    """A node of a graph: its type, the values of its inputs, and the node that its image comes from."""

    def __init__(self, graph: Graph, name: str, type_name: str) -> None:
        if type_name not in NODE_TYPES:
            raise Unsupported(
                f"omni.graph.core: node type {type_name!r} ({name}) has no counterpart; a graph may have nodes of the "
                f"types {', '.join(NODE_TYPES)}"
            )
        self.graph, self.name, self.type_name = graph, name, type_name
        self.inputs: dict[str, Any] = dict(NODE_TYPES[type_name].inputs)
        self.source: Node | None = None

    def get_prim_path(self) -> str:
        return f"{self.graph.path}/{self.name}"

    def get_type_name(self) -> str:
        return self.type_name

    def get_graph(self) -> Graph:
        return self.graph

    def get_attribute(self, name: str) -> Attribute:
        return Attribute(self, name)

    def get_attributes(self) -> list[Attribute]:
        return [Attribute(self, name) for name in self.inputs]

    def is_valid(self) -> bool:
        return self.graph.nodes.get(self.name) is self


class Attribute:
    """An input of a node."""

    def __init__(self, node: Node, name: str) -> None:
        self._node, self._name = node, name.removeprefix("inputs:")
        if self._name not in node.inputs:
            known = ", ".join(f"inputs:{each}" for each in node.inputs) or "none"
            raise OmniGraphError(f"{node.get_prim_path()} has no attribute {name!r}; there are: {known}")

    def get(self) -> Any:
        return self._node.inputs[self._name]

    def set(self, value: Any) -> bool:
        self._node.inputs[self._name] = value
        return True

    def get_name(self) -> str:
        return f"inputs:{self._name}"

    def get_path(self) -> str:
        return f"{self._node.get_prim_path()}.{self.get_name()}"

    def get_node(self) -> Node:
        return self._node

    def is_valid(self) -> bool:
        return self._node.is_valid()


class StageAttribute:
    """An attribute of a prim on the stage, under the interface of attributes of nodes."""

    def __init__(self, attribute: Usd.Attribute) -> None:
        self._attribute = attribute

    def get(self) -> Any:
        return self._attribute.Get()

    def set(self, value: Any) -> bool:
        """Set the attribute of the prim.

        Raises:
            Unsupported: it is an input of a randomization node of a file, which does not run.
        """
        if str(self._attribute.GetPath()).startswith(f"{PIPELINE}/"):
            raise Unsupported(
                f"{self._attribute.GetPath()}: the node was saved with the stage and does not run in a script; "
                "`usdsdg generate` runs the graph of a saved stage"
            )
        return self._attribute.Set(value)

    def get_name(self) -> str:
        return self._attribute.GetName()

    def get_path(self) -> str:
        return str(self._attribute.GetPath())

    def is_valid(self) -> bool:
        return bool(self._attribute)


class Graph:
    """Nodes by name; with the path of a render product, those that process its images."""

    def __init__(self, path: str, render_product: str | None = None) -> None:
        self.path, self._render_product = path, render_product
        self.nodes: dict[str, Node] = {}
        self._annotators: dict[str, Annotator] = {}
        self._evaluations = 0

    def get_path_to_graph(self) -> str:
        return self.path

    def get_wrapped_graph(self) -> Graph:
        """Return the graph itself: it is not inside a node."""
        return self

    def get_nodes(self) -> list[Node]:
        return list(self.nodes.values())

    def get_node(self, path: str) -> Node | None:
        return self.nodes.get(path.removeprefix(f"{self.path}/"))

    def is_valid(self) -> bool:
        return True

    def create_node(self, name: str, type_name: str) -> Node:
        """Add a node.

        Raises:
            Unsupported: there is no such node type here.
        """
        if self._render_product is None:
            raise Unsupported(
                f"omni.graph.core: {self.path} is no graph of a render product, so it can have no node {name!r} of "
                f"type {type_name!r}; actions and controllers are not simulated. Register a Python function with "
                "rep.randomizer.register, or change the stage between calls of rep.orchestrator.step"
            )
        self.nodes[name] = Node(self, name, type_name)
        return self.nodes[name]

    def connect(self, source: str, target: str) -> None:
        """Connect "A.outputs:x" to "B.inputs:y"; only the image, outputs:dest to inputs:src, has an effect.

        Raises:
            OmniGraphError: there is no such node or attribute.
        """
        (a, output), (b, wanted) = self._split(source, "outputs:"), self._split(target, "inputs:")
        if (output, wanted) == (IMAGE_OUT, IMAGE_IN):
            b.source = a
        elif output not in PASSED_ON or wanted not in PASSED_ON:
            raise OmniGraphError(f"{self.path}: {source} cannot be connected to {target}")

    def disconnect(self, source: str, target: str) -> None:
        (_, output), (b, wanted) = self._split(source, "outputs:"), self._split(target, "inputs:")
        if (output, wanted) == (IMAGE_OUT, IMAGE_IN):
            b.source = None

    def evaluate(self) -> None:
        """Process the current image of the render product; nothing happens before its first frame."""
        images = self._images()
        if images is None or not self.nodes:
            return
        rng = np.random.default_rng([get_global_seed(), self._evaluations])
        tick = Tick(images, self._evaluations, rng)
        done: dict[str, Signal | None] = {}
        for node in self.nodes.values():
            self._compute(node, tick, done)
        self._evaluations += 1

    def _compute(self, node: Node, tick: Tick, done: dict[str, Signal | None]) -> Signal | None:
        if node.name not in done:
            source = self._compute(node.source, tick, done) if node.source else None
            done[node.name] = NODE_TYPES[node.type_name].compute(source, node.inputs, tick)
        return done[node.name]

    def watch(self) -> set[str]:
        """Attach what texture nodes read, which then has data from the next update on; return the annotators."""
        names = {annotator_of(node.inputs) for node in self.nodes.values() if "aov" in node.inputs}
        for name in names.difference(self._annotators):
            self._annotators[name] = named_annotators.get(name).attach(self._render_product)
        return names

    def _images(self) -> dict[str, np.ndarray] | None:
        """Return the arrays that texture nodes read, by annotator; None before the first frame."""
        images = {name: self._annotators[name].get_data() for name in self.watch()}
        return None if any(not image.size for image in images.values()) else images

    def _split(self, path: str, prefix: str) -> tuple[Node, str]:
        name, _, attribute = path.rpartition(".")
        node = self.get_node(name)
        if node is None or not attribute.startswith(prefix):
            raise OmniGraphError(f"{self.path}: there is no {path}; nodes are {', '.join(self.nodes) or 'none'}")
        return node, attribute.removeprefix(prefix)


class Graphs:
    """The graphs of the stage, by path."""

    def __init__(self) -> None:
        self._graphs: dict[str, Graph] = {}
        get_app().subscribe_update(lambda _: self.evaluate())

    def reset(self) -> None:
        """Forget all graphs, as a new stage does."""
        self._graphs = {}

    def add(self, graph: Graph) -> Graph:
        """Add a graph, or return the one at its path."""
        return self._graphs.setdefault(graph.path, graph)

    def at(self, path: str) -> Graph | None:
        return self._graphs.get(path)

    def all(self) -> list[Graph]:
        return list(self._graphs.values())

    def evaluate(self) -> None:
        for graph in self.all():
            graph.evaluate()


def graphs() -> Graphs:
    """Return the graphs of the session."""
    return current().omnigraph


def find_node(path: str) -> Node | randomization.Node | None:
    """Return the node at `path`, of a camera's graph or of the randomization graph."""
    if path.startswith(f"{PIPELINE}/"):
        return evaluate.graph().get_node(path)
    found = (graph.get_node(path) for graph in graphs().all() if path.startswith(f"{graph.path}/"))
    return next((node for node in found if node is not None), None)


def attribute_of(node: Node | randomization.Node, name: str) -> Attribute | NodeAttribute:
    """Return an attribute of a node.

    Raises:
        OmniGraphError: the node has none of that name.
    """
    found = node.get_attribute(name)
    if not found.is_valid():
        known = ", ".join(each.get_name() for each in node.get_attributes())
        raise OmniGraphError(f"{node.get_type_name()} has no attribute {name!r}; there are: {known}")
    return found


def find_attribute(path: str) -> Attribute | NodeAttribute | StageAttribute:
    """Return the attribute at `path`, "/graph/node.inputs:name", of a node or of a prim on the stage.

    Raises:
        OmniGraphError: there is none.
    """
    name, _, attribute = path.rpartition(".")
    if (node := find_node(name)) is not None:
        return attribute_of(node, attribute)
    prim = current_stage().GetPrimAtPath(name)
    if prim and prim.HasAttribute(attribute):
        return StageAttribute(prim.GetAttribute(attribute))
    raise OmniGraphError(f"omni.graph.core: there is no attribute {path}")
