"""Copies of prims, for `omni.usd`."""

from __future__ import annotations

from typing import Any

from pxr import Sdf, Usd, UsdUtils

from usdsdg.errors import BadPrim, Unsupported

__all__ = ["duplicate_prim"]


def duplicate_prim(stage: Usd.Stage, prim_path: Any, path_to: Any, duplicate_layers: bool = True) -> bool:
    """Copy a prim with what is below it to a path, in the layer that is edited; return True.

    What the stage's own layers say of the prim is copied, stronger ones over weaker ones, with its references and
    payloads. It takes the place of what the edited layer says of the path.

    Args:
        prim_path: A path or a prim.
        duplicate_layers: Has no effect: copies have the opinions of all layers.

    Raises:
        BadPrim: there is no such prim.
        Unsupported: the prim comes from a reference of a prim above it alone.
    """
    source = Sdf.Path(str(prim_path.GetPath() if isinstance(prim_path, Usd.Prim) else prim_path))
    target = Sdf.Path(str(path_to))
    if not stage.GetPrimAtPath(source):
        raise BadPrim(f"duplicate_prim: {source} is not on the stage")
    layers = [layer for layer in stage.GetLayerStack() if layer.GetPrimAtPath(source)]
    if not layers:
        raise Unsupported(f"duplicate_prim: {source} comes from a reference above it; reference its file instead")
    copy = _single(layers[0], source)
    for layer in layers[1:]:
        UsdUtils.StitchLayers(copy, _single(layer, source))
    edited = stage.GetEditTarget().GetLayer()
    with Sdf.ChangeBlock():
        Sdf.JustCreatePrimInLayer(edited, target)
        Sdf.CopySpec(copy, source, edited, target)
    return True


def _single(layer: Sdf.Layer, path: Sdf.Path) -> Sdf.Layer:
    """Return a layer with nothing but what another one says of a prim and of those below it."""
    alone = Sdf.Layer.CreateAnonymous()
    Sdf.CreatePrimInLayer(alone, path)
    Sdf.CopySpec(layer, path, alone, path)
    return alone
