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
    """Return whether a prim at or below `root`, or in what these are instances of, has any."""
    unread, prototypes, has_spline = [stage.GetPrimAtPath(root)], set(), Usd.Attribute.HasSpline
    while unread:
        start = unread.pop()
        for prim in Usd.PrimRange(start) if start else ():
            if prim.HasAuthoredMetadata("clips") or any(map(has_spline, prim.GetAuthoredAttributes())):
                return True
            if prim.IsInstance() and (prototype := prim.GetPrototype()).GetPath() not in prototypes:
                # Each once: a thousand instances of one cost no more.
                prototypes.add(prototype.GetPath())
                unread.append(prototype)
    return False


def splined(stage: Usd.Stage, properties: Sequence[Sdf.Path]) -> set[Sdf.Path]:
    """Return those of the prims with these properties of which one has a spline."""
    attributes = map(stage.GetAttributeAtPath, filter(_may_be_number, properties))
    return {attribute.GetPrimPath() for attribute in attributes if attribute and attribute.HasSpline()}


@lru_cache(maxsize=1 << 16)
def _may_be_number(path: Sdf.Path) -> bool:
    return path.name not in _VECTORS
