"""Attributes of nodes as OmniGraph's scripts read and set them: `item.node.get_attribute("outputs:prims").get()`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

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
