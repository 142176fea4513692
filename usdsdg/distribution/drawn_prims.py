"""Prims that a distribution draws at each execution, for nodes to act on: `with rep.distribution.choice(prims):`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from usdsdg.distribution.base import Distribution, from_inputs
from usdsdg.graph.live_prims import search

_SEARCH = "draw"


@dataclass(frozen=True)
class DrawnPrims:
    """`count` prims of those that `item` draws from, without repetition; `key` is that of the draws."""

    item: Distribution
    key: str
    count: int

    def paths(self, execution: int) -> tuple[str, ...]:
        """Return the prims of one execution."""
        self.item.node.state["targets"] = execution
        return _drawn(self.item, self.key, self.count, execution)

    def record(self) -> Mapping[str, Any]:
        """Return the search of a saved graph that draws the same."""
        node = self.item.node
        inputs = {name: value.tolist() if hasattr(value, "tolist") else value for name, value in node.inputs.items()}
        arguments = {"type": node.kind, "inputs": inputs, "key": self.key, "count": self.count}
        return {"kind": _SEARCH, "arguments": arguments}


@search(_SEARCH, by_execution=True)
def _drawn_again(execution: int, type: str, inputs: dict[str, Any], key: str, count: int) -> tuple[str, ...]:
    """Draw as a `DrawnPrims` did whose graph was saved."""
    return _drawn(from_inputs(type, inputs, None), key, count, execution)


def _drawn(item: Distribution, key: str, count: int, execution: int) -> tuple[str, ...]:
    places = [str(place) for place in range(count)]
    return tuple(dict.fromkeys(str(path) for path in item.sample(key, execution, places)))
