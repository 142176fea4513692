"""Where prims in the prototypes of scene-graph instances stand on the stage."""

from __future__ import annotations

from collections.abc import Iterator

from pxr import Sdf, Usd


def places_of(stage: Usd.Stage, path: Sdf.Path) -> Iterator[Sdf.Path]:
    """Yield a path and, if it lies in the prototype of instances, those of its instance proxies.

    Notices of edits that all instances share name the prim in the prototype, and none of the proxies. path: of a prim,
    also of one that is not on the stage any more.
    """
    yield path
    if not Usd.Prim.IsPathInPrototype(path):
        return
    top = path.GetPrefixes()[0]
    prototype = stage.GetPrimAtPath(top)
    for instance in prototype.GetInstances() if prototype else ():
        yield from places_of(stage, path.ReplacePrefix(top, instance.GetPath()))
