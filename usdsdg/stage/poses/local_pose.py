"""What a prim's own xform ops say, pivots, and positions given in the world."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.errors import BadPrim
from usdsdg.stage.poses.rotations import decompose, euler_from_matrix, matrix_from_quat
from usdsdg.stage.poses.transforms import as_array
from usdsdg.stage.poses.xform_ops import Vector, author_pose

PIVOT = "xformOp:translate:pivot"
_INVERSE = f"!invert!{PIVOT}"


def translation(prim: Usd.Prim) -> np.ndarray:
    """(3,) of the translate op [parent's units], which `author_pose` writes; without one, of the whole local matrix."""
    op = _op(prim, UsdGeom.XformOp.TypeTranslate)
    if op is not None:
        return np.array(op.Get() or (0.0, 0.0, 0.0), np.float64)
    return as_array(UsdGeom.Xformable(prim).GetLocalTransformation())[3, :3]


def euler(prim: Usd.Prim, order: str = "XYZ") -> np.ndarray:
    """(3,) angles about x, y, z [degrees] of the prim's own rotation, for a rotate op of `order`."""
    op = _op(prim, getattr(UsdGeom.XformOp, f"TypeRotate{order}"))
    if op is not None:
        return np.array(op.Get() or (0.0, 0.0, 0.0), np.float64)
    pose = decompose(as_array(UsdGeom.Xformable(prim).GetLocalTransformation()))
    return euler_from_matrix(matrix_from_quat(pose.rotation), order)


def _op(prim: Usd.Prim, kind: UsdGeom.XformOp.Type) -> UsdGeom.XformOp | None:
    for op in UsdGeom.Xformable(prim).GetOrderedXformOps():
        if op.GetOpType() == kind and not op.IsInverseOp() and op.GetOpName() != PIVOT:
            return op
    return None


def bounds(prim: Usd.Prim) -> Gf.Range3d:
    """Box around what is drawn of a prim, in the space in which its own transform starts; empty where nothing is."""
    purposes = [UsdGeom.Tokens.default_, UsdGeom.Tokens.render, UsdGeom.Tokens.proxy]
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), purposes, useExtentsHint=False)
    return cache.ComputeUntransformedBound(prim).ComputeAlignedRange()


def extents(prim: Usd.Prim) -> np.ndarray:
    """(3,) lengths of `bounds`, before scaling.

    Raises:
        BadPrim: the prim has no extent.
    """
    box = bounds(prim)
    if box.IsEmpty():
        raise BadPrim(f"{prim.GetPath()} has no extent (no geometry below it), so it has neither a size nor a pivot")
    return np.array(box.GetSize(), np.float64)


def set_pivot(prim: Usd.Prim, relative: Sequence[float]) -> None:
    """Make a point of the prim's box its origin: what is placed, turned about and scaled from.

    `relative` is -1 to 1 on each axis, from the box's lowest to its highest corner: (0, 0, -1) is the middle of the
    bottom. An earlier pivot is replaced.

    Raises:
        BadPrim: the prim has no extent, or no transform.
    """
    extents(prim)
    box = bounds(prim)
    author_pose(prim)
    half = np.array(box.GetSize(), np.float64) / 2
    point = np.array(box.GetMidpoint(), np.float64) + half * np.asarray(relative, np.float64)
    attribute = prim.GetAttribute(PIVOT) or prim.CreateAttribute(PIVOT, Sdf.ValueTypeNames.Double3, custom=False)
    kind = Gf.Vec3f if attribute.GetTypeName() == Sdf.ValueTypeNames.Float3 else Gf.Vec3d
    attribute.Set(kind(*point.tolist()))
    # Without its counterpart the inverse op moves the pivot to the origin, and the other ops act on that.
    order = prim.GetAttribute("xformOpOrder")
    names = [name for name in order.Get() or () if name not in (PIVOT, _INVERSE)]
    UsdGeom.Xformable(prim).CreateXformOpOrderAttr([*names, _INVERSE])


def parent_to_world(prim: Usd.Prim) -> Gf.Matrix4d:
    """What the prim's local matrix is multiplied with: identity where its stack is reset."""
    if UsdGeom.Xformable(prim).GetResetXformStack():
        return Gf.Matrix4d(1)
    return UsdGeom.XformCache(Usd.TimeCode.Default()).GetParentToWorldTransform(prim)


def author_world_position(prim: Usd.Prim, point: Vector) -> None:
    """Place a prim at a point of the world [stage units].

    Raises:
        BadPrim: the prim has no transform, or an ancestor is scaled to nothing.
    """
    matrix = parent_to_world(prim)
    if abs(matrix.GetDeterminant()) < 1e-30:
        raise BadPrim(f"{prim.GetPath()} cannot be placed: an ancestor is scaled to nothing")
    author_pose(prim, translate=matrix.GetInverse().Transform(Gf.Vec3d(*(float(c) for c in point))))
