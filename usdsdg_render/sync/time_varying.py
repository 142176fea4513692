"""Splines and value clips, which no layer lists as it does time samples."""

from collections.abc import Sequence
from functools import lru_cache

from pxr import Sdf, Usd

# Splines are of numbers; these are none, and each frame of a simulation writes thousands of them.
_VECTORS = frozenset(
    {
        "physics:angularVelocity",
        "physics:velocity",
        "visibility",
        "xformOp:orient",
        "xformOp:rotateXYZ",
        "xformOp:scale",
        "xformOp:transform",
        "xformOp:translate",
    }
)


def has_splines_or_clips(stage: Usd.Stage, root: Sdf.Path) -> bool:
    """Return whether a prim at or below `root`, or in a prototype that it may be an instance of, has any."""
    start = stage.GetPrimAtPath(root)
    if not start:
        return False
    found, has_instances = _search(start)
    # Each prototype once: a thousand instances of one cost no more.
    return found or (has_instances and any(_search(prototype)[0] for prototype in stage.GetPrototypes()))


def _search(root: Usd.Prim) -> tuple[bool, bool]:
    """Return whether there is any at or below a prim, and whether there is an instance."""
    has_instances, has_spline = False, Usd.Attribute.HasSpline
    for prim in Usd.PrimRange(root):
        if prim.HasAuthoredMetadata("clips") or any(map(has_spline, prim.GetAuthoredAttributes())):
            return True, has_instances
        has_instances = has_instances or prim.IsInstance()
    return False, has_instances


def splined(stage: Usd.Stage, properties: Sequence[Sdf.Path]) -> set[Sdf.Path]:
    """Return those of the prims with these properties of which one has a spline."""
    attributes = map(stage.GetAttributeAtPath, filter(_may_be_number, properties))
    return {attribute.GetPrimPath() for attribute in attributes if attribute and attribute.HasSpline()}


@lru_cache(maxsize=1 << 16)
def _may_be_number(path: Sdf.Path) -> bool:
    return path.name not in _VECTORS
