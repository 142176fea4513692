"""Attributes of nodes as OmniGraph's scripts read and set them: `item.node.get_attribute("outputs:prims").get()`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pxr import Sdf, Usd

from usdsdg.session.stage_context import current_stage

if TYPE_CHECKING:
    from usdsdg.graph.node import ReplicatorItem


@dataclass(frozen=True)
class NodeAttribute:
    """An input or an output of a node, by its name with the prefix `inputs:` or `outputs:`."""

    item: ReplicatorItem
    name: str

    def get(self) -> Any:
        """Return its value: what is given for an input, the distribution included; of outputs, paths of prims or draws.

        Raises:
            UnknownInput: (a ValueError and a KeyError) the node has no such attribute; the message lists those it has.
        """
        read = self.item.get_output if self.name.startswith("outputs:") else self.item.get_input
        return read(self.name)

    def set(self, value: Any) -> None:
        """Change an input from the next execution on.

        Raises:
            UnknownInput: the node has no such input, or it is an output.
        """
        self.item.set_input(self.name, value)

    def get_name(self) -> str:
        """Return the name with its prefix."""
        return self.name

    def get_path(self) -> str:
        """Return the path of the node's prim and the name, joined by a dot."""
        return f"{self.item.node.get_prim_path()}.{self.name}"

    def get_node(self) -> Any:
        """Return the node."""
        return self.item.node

    def is_valid(self) -> bool:
        """Whether the node has such an input or output."""
        return self.item.node.get_attribute_exists(self.name)

    def get_upstream_connections(self) -> list[NodeAttribute]:
        """Return the outputs that it has its values from: of a distribution, or of the node that runs before.

        Raises:
            Unsupported: the node has no prim, as it has run already.
        """
        attribute = current_stage().GetAttributeAtPath(self.get_path())
        return [each for each in map(self._at, attribute.GetConnections() if attribute else []) if each is not None]

    def get_downstream_connections(self) -> list[NodeAttribute]:
        """Return the inputs of other nodes that have their values from it.

        Raises:
            Unsupported: the node has no prim, as it has run already.
        """
        own = Sdf.Path(self.get_path())
        paths = [node.get_prim_path() for node in self.get_node().get_graph().get_nodes()]
        inputs = [each for path in paths for each in current_stage().GetPrimAtPath(path).GetAuthoredAttributes()]
        inputs = [each for each in inputs if own in each.GetConnections()]
        return [each for each in map(self._at, map(Usd.Attribute.GetPath, inputs)) if each is not None]

    def get_upstream_connection_count(self) -> int:
        """Return how many there are of `get_upstream_connections`."""
        return len(self.get_upstream_connections())

    def get_downstream_connection_count(self) -> int:
        """Return how many there are of `get_downstream_connections`."""
        return len(self.get_downstream_connections())

    def _at(self, path: Sdf.Path) -> NodeAttribute | None:
        """Return the attribute at a path; None of what starts the nodes that run once, of which there is no node."""
        node = self.get_node().get_graph().get_node(str(path.GetPrimPath()))
        return None if node is None else node.get_attribute(path.name)


@dataclass(frozen=True)
class NodeType:
    """The type of a node as OmniGraph hands it out: `node.get_node_type().get_node_type()` is its name."""

    name: str

    def get_node_type(self) -> str:
        """Return the name of the type, as `omni.replicator.core.OgnSampleUniform`."""
        return self.name

    def is_valid(self) -> bool:
        """Always True: there are no nodes without a type."""
        return True
