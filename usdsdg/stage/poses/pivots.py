"""Pivots: points of a prim's bounding box that are the origin of its position, rotation and scale.

A pivot is relative to the box, -1 to 1 on each axis: (0, 0, -1) is the middle of the bottom.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.errors import BadPrim
from usdsdg.stage.geometry.drawn_box import DRAWN_PURPOSES, DrawnBoxes
from usdsdg.stage.geometry.own_box import own_box
from usdsdg.stage.poses.pose_batch import Rotations
from usdsdg.stage.poses.rotations import decompose
from usdsdg.stage.poses.transforms import local_matrices
from usdsdg.stage.poses.xform_ops import author_pose

Array = NDArray[np.float64]

PIVOT = "xformOp:translate:pivot"
_INVERSE = f"!invert!{PIVOT}"


def bounds(prim: Usd.Prim, time: Usd.TimeCode = Usd.TimeCode.Default()) -> Gf.Range3d:  # noqa: B008
    """Return the bounding box of the geometry at and below a prim, in its own space; empty without geometry."""
    return own_box(prim, [*DRAWN_PURPOSES, UsdGeom.Tokens.proxy], time)


def extents(prim: Usd.Prim, time: Usd.TimeCode = Usd.TimeCode.Default()) -> Array:  # noqa: B008
    """Return the edge lengths (3,) of `bounds`.

    Raises:
        BadPrim: the prim has no extent.
    """
    return np.array(_box(prim, time).GetSize(), np.float64)


def _box(prim: Usd.Prim, time: Usd.TimeCode) -> Gf.Range3d:
    """Return `bounds`; raises BadPrim if they are empty."""
    box = bounds(prim, time)
    if box.IsEmpty():
        raise BadPrim(f"{prim.GetPath()} has no extent (no geometry below it), so it has neither a size nor a pivot")
    return box


def set_pivot(prim: Usd.Prim, relative: Sequence[float], time: Usd.TimeCode = Usd.TimeCode.Default()) -> None:  # noqa: B008
    """Author a pivot op at a point of the prim's bounding box, replacing an earlier one.

    Raises:
        BadPrim: the prim has no extent, or no transform.
    """
    box = _box(prim, time)
    author_pose(prim)
    half = np.array(box.GetSize(), np.float64) / 2
    point = np.array(box.GetMidpoint(), np.float64) + half * np.asarray(relative, np.float64)
    attribute = prim.GetAttribute(PIVOT) or prim.CreateAttribute(PIVOT, Sdf.ValueTypeNames.Double3, custom=False)
    kind = Gf.Vec3f if attribute.GetTypeName() == Sdf.ValueTypeNames.Float3 else Gf.Vec3d
    attribute.Set(kind(*point.tolist()))
    # Without the pivot op, the inverse op moves the pivot to the origin, and the other ops apply to that.
    order = prim.GetAttribute("xformOpOrder")
    names = [name for name in order.Get() or () if name not in (PIVOT, _INVERSE)]
    UsdGeom.Xformable(prim).CreateXformOpOrderAttr([*names, _INVERSE])


def translations_about_pivots(
    prims: Sequence[Usd.Prim],
    relative: ArrayLike,
    translate: Array | None,
    rotate: Rotations | None,
    scale: Array | None,
    time: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
) -> Array:
    """Return the translations (N, 3) that move each pivot to `translate`, or keep its position for None.

    `relative` (N, 3) are the pivots. Rotations and scales are those that will be written, None for those at
    the time.

    Raises:
        BadPrim: a prim has no extent.
    """
    points, before = _pivot_points(prims, np.asarray(relative, np.float64), time), local_matrices(prims, time)
    if translate is None:
        translate = np.einsum("ni,nij->nj", points, before[:, :3, :3]) + before[:, 3, :3]
    now = decompose(before)
    rotations = (Rotations(quats=now.rotation) if rotate is None else rotate).matrices()
    sizes = now.scale if scale is None else scale
    return translate - np.einsum("ni,nij->nj", points * sizes, rotations)


def _pivot_points(prims: Sequence[Usd.Prim], relative: Array, time: Usd.TimeCode) -> Array:
    """Return the pivots (N, 3) in the prims' own spaces."""
    boxes = DrawnBoxes(time)
    points = []
    for prim, normalized in zip(prims, relative):
        box = own_box(prim, DRAWN_PURPOSES, time, boxes=boxes)
        if box.IsEmpty():
            raise BadPrim(f"{prim.GetPath()} has no extent, so it has no pivot; leave pivot out")
        low, high = np.array(box.GetMin()), np.array(box.GetMax())
        points.append(low + (high - low) * (normalized + 1) / 2)
    return np.array(points)
