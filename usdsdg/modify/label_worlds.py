"""`rep.modify.semantics` in many worlds at once: labels that are the same in all of them."""

from __future__ import annotations

import numpy as np

from usdsdg.distribution import Distribution
from usdsdg.errors import Unsupported
from usdsdg.graph.node import Node
from usdsdg.graph.worlds import in_worlds
from usdsdg.stage.world_values import WorldValues


@in_worlds("OgnWriteSemantics")
def _labels_in_worlds(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    """Write nothing: all worlds have the labels that are on the stage.

    Raises:
        Unsupported: labels are drawn, or not written in every world, so that they may differ.
    """
    if isinstance(node.inputs.get("semantics"), Distribution):
        raise Unsupported("labels that are drawn cannot differ between worlds")
    # Where others write labels too, those of a frame without this execution may be theirs.
    if (np.diff(executions) != 1).any():
        raise Unsupported("labels that are not written in every frame cannot differ between worlds")
