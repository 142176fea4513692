"""A layer for the prims that a script adds. Mirrors `rep.new_layer`."""

from collections.abc import Iterator
from contextlib import contextmanager

from pxr import Sdf, Usd

from usdsdg.create import render_products
from usdsdg.graph.evaluate import graph
from usdsdg.session.stage_context import current_stage


@contextmanager
def new_layer(name: str | None = None) -> Iterator[Sdf.Layer]:
    """Author into an anonymous sublayer with the display name `name` ("Replicator" by default) while the block runs.

    A layer of that name from an earlier block is cleared first, and the graph and all render products are removed, so
    that a script can be run again on the same stage. Errors inside are raised (Replicator only logs them).
    """
    stage, title = current_stage(), "Replicator" if name is None else name
    layer = _existing(stage, title)
    if layer is None:
        layer = Sdf.Layer.CreateAnonymous(title)
        stage.GetRootLayer().subLayerPaths.insert(0, layer.identifier)
    else:
        layer.Clear()
        graph().reset()
        render_products.reset()
    with Usd.EditContext(stage, layer):
        yield layer


def _existing(stage: Usd.Stage, title: str) -> Sdf.Layer | None:
    for identifier in stage.GetRootLayer().subLayerPaths:
        layer = Sdf.Layer.Find(identifier)
        if layer is not None and layer.anonymous and layer.GetDisplayName() == title:
            return layer
    return None
