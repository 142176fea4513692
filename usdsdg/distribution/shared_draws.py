"""Which nodes draw from a distribution: those under one trigger share its draws, as the samples of one node."""

from collections.abc import Hashable, Sequence

from usdsdg.graph.node import Node


class SharedDraws:
    """The nodes that draw from one distribution; all others under a trigger get the draws of the first one.

    Rows go by place: the first prim of each node has the same draw. Prims beyond those of the first node draw on their
    own, and nodes under different triggers draw independently.
    """

    def __init__(self) -> None:
        self._first: dict[Hashable, tuple[str, Node]] = {}  # by trigger
        self._others: dict[str, tuple[str, Node, Node]] = {}  # by consumer: that of the first node, it, and its own

    def note(self, consumer: str, node: Node, trigger: Hashable) -> None:
        """Note that `node` draws under `trigger`, with a key `consumer` of its own."""
        first, first_node = self._first.setdefault(trigger, (consumer, node))
        if first != consumer:
            self._others[consumer] = first, first_node, node

    def key(self, consumer: str) -> str:
        """Return what the draws of a consumer are keyed by."""
        return self._others[consumer][0] if consumer in self._others else consumer

    def rows(self, consumer: str, prims: Sequence[str]) -> Sequence[str]:
        """Return what the rows of a consumer's draws for `prims`, or for some of them, are keyed by."""
        if consumer not in self._others:
            return prims
        _, first_node, node = self._others[consumer]
        same_place = dict(zip(node.prims or prims, first_node.prims))
        return [same_place.get(prim, prim) for prim in prims]
