"""The bounding box of a prim along its own axes, which does not depend on how the prim is posed."""

from collections.abc import Iterator, Sequence

from pxr import Gf, Usd, UsdGeom, UsdSkel

from usdsdg.stage.geometry.drawn_box import DrawnBoxes


def own_box(
    prim: Usd.Prim, purposes: Sequence[str], time: Usd.TimeCode = Usd.TimeCode.Default(), *,  # noqa: B008
    boxes: DrawnBoxes | None = None,
) -> Gf.Range3d:  # fmt: skip
    """Return the box of the geometry at and below a prim in its own space; empty without any.

    USD's BBoxCache unites the boxes of gprims along the axes of the world, so that what it returns grows as the prim
    turns, and believes authored extents that do not fit. Here the box of what is drawn of each gprim is united with the
    others along the axes of the prim.

    boxes: for these purposes and this time, to be shared by several prims.
    """
    boxes = DrawnBoxes(time, purposes) if boxes is None else boxes
    united, transforms = Gf.Range3d(), UsdGeom.XformCache(time)
    for each in _drawn(prim, purposes, time):
        box = boxes.own(each)
        if box is not None:
            corners = Gf.BBox3d(Gf.Range3d(*(Gf.Vec3d(*corner) for corner in box.tolist())))
            corners.Transform(_relative(transforms, each, prim))
            united.UnionWith(corners.ComputeAlignedRange())
    return united


def _drawn(prim: Usd.Prim, purposes: Sequence[str], time: Usd.TimeCode) -> Iterator[Usd.Prim]:
    """Yield the prims with a box at and below a prim, which may be hidden; what is below one of them is in its box."""
    prims = iter(Usd.PrimRange(prim, Usd.TraverseInstanceProxies()))
    for each in prims:
        imageable = UsdGeom.Imageable(each)
        if not imageable:
            continue
        if each != prim and imageable.GetVisibilityAttr().Get(time) == UsdGeom.Tokens.invisible:
            prims.PruneChildren()
        elif each.IsA(UsdGeom.Boundable) and not each.IsA(UsdSkel.Root):  # whose extent covers what is below it
            prims.PruneChildren()
            if imageable.ComputePurpose() in purposes:
                yield each


def _relative(transforms: UsdGeom.XformCache, prim: Usd.Prim, ancestor: Usd.Prim) -> Gf.Matrix4d:
    """Return the matrix from a prim's space to that of a prim above it."""
    matrix, resets = transforms.ComputeRelativeTransform(prim, ancestor)
    if not resets:
        return matrix
    return transforms.GetLocalToWorldTransform(prim) * transforms.GetLocalToWorldTransform(ancestor).GetInverse()
