"""Copies of prims, all of them in one change: USD composes the parent of new prims again at each change."""

from collections.abc import Sequence

from pxr import Sdf, Usd


def copy_prim(stage: Usd.Stage, layer: Sdf.Layer, source: Sdf.Path, paths: Sequence[str]) -> None:
    """Copy a layer's spec of a prim, and of all below it, to `paths` in the stage's edit target.

    Targets and connections inside of the source lead into the copy.
    """
    target = stage.GetEditTarget()
    edited, parents = target.GetLayer(), set()
    with Sdf.ChangeBlock():
        for path in paths:
            copy = target.MapToSpecPath(Sdf.Path(path))
            parent = copy.GetParentPath()
            if parent not in parents and not parent.IsAbsoluteRootPath():
                Sdf.CreatePrimInLayer(edited, parent)
            parents.add(parent)
            Sdf.CopySpec(layer, source, edited, copy)
