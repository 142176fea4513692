"""Why the shape of an object is not the same in all frames."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from pxr import Usd, UsdGeom, UsdSkel

from usdsdg.stage.geometry.point_velocities import have_velocities
from usdsdg.stage.time_code import transform_varies

# Attributes of gprims and of point instancers that decide on triangles.
SHAPE_ATTRIBUTES = (
    "points", "faceVertexIndices", "faceVertexCounts", "holeIndices", "orientation", "subdivisionScheme", "size",
    "radius", "radiusTop", "radiusBottom", "height", "width", "length", "axis", "positions", "orientations",
    "orientationsf", "scales", "protoIndices", "invisibleIds", "purpose",
)  # fmt: skip


def deformations(prim: Usd.Prim, is_other: Callable[[Usd.Prim], bool]) -> Iterator[str]:
    """Yield what deforms an object: skins, and samples of shapes and of poses below its own, each with its prim path.

    The shape that `triangles_below` reads is that of one time, without skins. is_other: whether a prim below
    and what is below it belong to another object.
    """
    walk = iter(Usd.PrimRange(prim, Usd.TraverseInstanceProxies()))
    for part in walk:
        if part != prim and is_other(part):
            walk.PruneChildren()
            continue
        if not part.IsA(UsdGeom.Imageable):
            continue
        path = part.GetPath()
        if part.IsA(UsdGeom.Mesh) and UsdSkel.BindingAPI(part).GetInheritedSkeleton() and UsdSkel.Root.Find(part):
            yield f"{path} is skinned"
        if part.IsA(UsdGeom.PointBased) and have_velocities(part):
            yield f"{path} has velocities"
        for name in SHAPE_ATTRIBUTES:
            if part.GetAttribute(name).ValueMightBeTimeVarying():
                yield f"{name} of {path} has time samples"
        if part != prim and transform_varies(part):
            yield f"{path} moves within it"
