"""References and payloads of prims, as `omni.usd` lists them."""

from typing import Any

from pxr import Sdf, Usd

Arcs = list[tuple[Any, Sdf.Layer]]  # references, or payloads, and the layers that author them


def get_composed_references_from_prim(prim: Usd.Prim, fix_slashes: bool = True) -> Arcs:
    """Return the references of a prim with the layers that author them, the stronger ones first."""
    return _arcs(prim, "referenceList", fix_slashes)


def get_composed_payloads_from_prim(prim: Usd.Prim, fix_slashes: bool = True) -> Arcs:
    """Return the payloads of a prim with the layers that author them, the stronger ones first."""
    return _arcs(prim, "payloadList", fix_slashes)


def _arcs(prim: Usd.Prim, name: str, fix_slashes: bool) -> Arcs:
    """Return the items of a list of arcs in the stage's own layers, each once, without those that a layer deletes."""
    found: Arcs = []
    deleted: list[Any] = []
    own = set(prim.GetStage().GetLayerStack())
    for spec in prim.GetPrimStack():
        if spec.layer not in own or spec.path != prim.GetPath():
            continue
        items = getattr(spec, name)
        for item in items.GetAddedOrExplicitItems():
            if item not in deleted and all(item != known for known, _ in found):
                found.append((item, spec.layer))
        deleted += items.deletedItems
        if items.isExplicit:
            break
    if not fix_slashes:
        return found
    return [(_with_slashes(item), layer) for item, layer in found]


def _with_slashes(item: Any) -> Any:
    """Return an arc whose file has slashes between its folders, as on Windows it may not."""
    if "\\" not in item.assetPath:
        return item
    return type(item)(item.assetPath.replace("\\", "/"), item.primPath, item.layerOffset)
