"""A layer for the prims that a script adds. Mirrors `rep.new_layer`."""

from collections.abc import Iterator
from contextlib import contextmanager

from pxr import Sdf, Usd

from usdsdg.annotators.annotator import attached_annotators
from usdsdg.errors import warn_once
from usdsdg.graph.evaluate import graph
from usdsdg.session.render_products import HydraTexture, products
from usdsdg.session.stage_context import current_stage
from usdsdg.writers.base import attached_writers


@contextmanager
def new_layer(name: str | None = None) -> Iterator[Sdf.Layer]:
    """Author into an anonymous sublayer with the display name `name` ("Replicator" by default) while the block runs.

    A layer of that name from an earlier block is cleared first, and the graph and the render products that were made in
    it are removed, with what was attached to these, so that a script can be run again on the same stage: its prims and
    products get the same paths, and what is drawn for them is the same. Errors inside are raised (Replicator only logs
    them).
    """
    stage, title = current_stage(), "Replicator" if name is None else name
    layer = _existing(stage, title)
    if layer is None:
        layer = Sdf.Layer.CreateAnonymous(title)
        stage.GetRootLayer().subLayerPaths.insert(0, layer.identifier)
    else:
        prims = _defined_in(layer)
        layer.Clear()
        _remove_values(stage, prims)
        graph().reset()
        for product in [each for each in products() if each.layer == layer]:
            _remove(product)
    with Usd.EditContext(stage, layer):
        yield layer


def _existing(stage: Usd.Stage, title: str) -> Sdf.Layer | None:
    for identifier in stage.GetRootLayer().subLayerPaths:
        layer = Sdf.Layer.Find(identifier)
        if layer is not None and layer.anonymous and layer.GetDisplayName() == title:
            return layer
    return None


def _remove(product: HydraTexture) -> None:
    """Remove a product with its prim; what was attached to it gets nothing of the product that will have its path."""
    for writer in attached_writers():
        writer.detach_from(product)
        if writer not in attached_writers() and not writer.num_written:
            warn_once(
                f"new_layer: {type(writer).__name__} got no frame of {product.path}, which is removed with the earlier "
                "layer of that name. Attach it to a product of the new one, or give the layers different names."
            )
    for annotator in attached_annotators():
        if annotator.render_product == product.path:
            annotator.release()
    product.destroy()


def _defined_in(layer: Sdf.Layer) -> list[Sdf.Path]:
    """Return the prims that a layer defines, parents first."""
    found: list[Sdf.Path] = []

    def note(path: Sdf.Path) -> None:
        if path.IsPrimPath() and layer.GetPrimAtPath(path).specifier == Sdf.SpecifierDef:
            found.append(path)

    layer.Traverse(Sdf.Path.absoluteRootPath, note)
    return sorted(found)


def _remove_values(stage: Usd.Stage, prims: list[Sdf.Path]) -> None:
    """Remove the values that frames have written for prims that are gone: else their paths would stay taken."""
    for layer in {stage.GetRootLayer(), stage.GetSessionLayer(), stage.GetEditTarget().GetLayer()}:
        with Sdf.ChangeBlock():
            for path in prims:
                if layer.GetPrimAtPath(path) and _only_overrides(layer, path):
                    del layer.GetPrimAtPath(path.GetParentPath()).nameChildren[path.name]


def _only_overrides(layer: Sdf.Layer, path: Sdf.Path) -> bool:
    """Return whether a layer neither defines a prim nor anything below it."""
    specifiers = []

    def note(each: Sdf.Path) -> None:
        if each.IsPrimPath():
            specifiers.append(layer.GetPrimAtPath(each).specifier)

    layer.Traverse(path, note)
    return all(each == Sdf.SpecifierOver for each in specifiers)
