"""Copies of prims, all of them in one change: USD composes the parent of new prims again at each change."""

from collections.abc import Sequence

from pxr import Sdf, Usd


def copy_prim(stage: Usd.Stage, layer: Sdf.Layer, source: Sdf.Path, paths: Sequence[str]) -> list[Usd.Prim]:
    """Copy a layer's spec of a prim, and of all below it, to `paths` in the stage's edit target; return the prims.

    Targets and connections inside of the source lead into the copy.
    """
    target = stage.GetEditTarget()
    with Sdf.ChangeBlock():
        for path in paths:
            copy = target.MapToSpecPath(Sdf.Path(path))
            Sdf.CreatePrimInLayer(target.GetLayer(), copy)
            Sdf.CopySpec(layer, source, target.GetLayer(), copy)
    return [stage.GetPrimAtPath(path) for path in paths]
