"""Which xform ops of a prim carry its simulated pose, and how a pose becomes their values.

With the ops of a prim in order, its local matrix is the product of their matrices, last op first (row vectors):

    local = after · R · between · T · before

T and R are the translate and rotate op that follow the simulation; what stands before, between and after them is
constant, whether it is a scale, a pivot, or rotations by somebody else. A prim with a single matrix op has that as T
and R in one. A prim that lacks a translate or a full rotation gets the op added, as PhysX does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Sdf, Usd, UsdGeom

_OP = UsdGeom.XformOp
EULER = {getattr(_OP, f"TypeRotate{order}"): order for order in ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")}
_AXES = {_OP.TypeRotateX: "X", _OP.TypeRotateY: "Y", _OP.TypeRotateZ: "Z"}


@dataclass(frozen=True)
class PoseOps:
    """Where one prim's pose is written. Matrices are row-vector 4x4 in stage units."""

    translate: str  # attribute name; the matrix op's where `rotate` is empty
    rotate: tuple[str, ...]  # one name, or three of single-axis ops in x, y, z order; none for a matrix op
    order: str  # Euler order, "quat", or "matrix"
    before: np.ndarray
    between: np.ndarray
    after: np.ndarray


def plan_pose_ops(prim: Usd.Prim) -> PoseOps:
    """Find the ops of a prim that follow the simulation, adding to its xformOpOrder what is missing."""
    xformable = UsdGeom.Xformable(prim)
    ops = xformable.GetOrderedXformOps()
    moving = _find_translate(ops)
    matrix = next((i for i, op in enumerate(ops) if op.GetOpType() == _OP.TypeTransform and not op.IsInverseOp()), None)
    if moving is None and matrix is not None:
        return _planned(ops, matrix, matrix, (), "matrix")
    if moving is None:
        ops = _insert(xformable, ops, 0, "translate")
        moving = 0
    turning = next((i for i, op in enumerate(ops) if i > moving and _is_full_rotation(op)), None)
    if turning is not None:
        order = EULER.get(ops[turning].GetOpType(), "quat")
        return _planned(ops, moving, turning, (ops[turning].GetName(),), order)
    singles = _single_axes(ops, moving)
    if singles is not None:
        first, order = singles
        names = {_AXES[op.GetOpType()]: op.GetName() for op in ops[first : first + 3]}
        return _planned(ops, moving, first, (names["X"], names["Y"], names["Z"]), order, width=3)
    ops = _insert(xformable, ops, moving + 1, "orient")
    return _planned(ops, moving, moving + 1, (ops[moving + 1].GetName(),), "quat")


def _find_translate(ops: list[UsdGeom.XformOp]) -> int | None:
    for index, op in enumerate(ops):
        if op.GetOpType() == _OP.TypeTranslate and not op.IsInverseOp() and not op.GetOpName().endswith(":pivot"):
            return index
    return None


def _is_full_rotation(op: UsdGeom.XformOp) -> bool:
    return not op.IsInverseOp() and (op.GetOpType() == _OP.TypeOrient or op.GetOpType() in EULER)


def _single_axes(ops: list[UsdGeom.XformOp], moving: int) -> tuple[int, str] | None:
    """Index and Euler order of three single-axis rotations in a row; the op listed last turns first."""
    for first in range(moving + 1, len(ops) - 2):
        axes = [_AXES.get(op.GetOpType()) if not op.IsInverseOp() else None for op in ops[first : first + 3]]
        if None not in axes and sorted(axes) == ["X", "Y", "Z"]:
            return first, "".join(reversed(axes))
    return None


def _planned(
    ops: list[UsdGeom.XformOp], moving: int, turning: int, rotate: tuple[str, ...], order: str, width: int = 1
) -> PoseOps:
    return PoseOps(
        translate=ops[moving].GetName(),
        rotate=rotate,
        order=order,
        before=_product(ops[:moving]),
        between=_product(ops[moving + 1 : turning]),
        after=_product(ops[turning + width :]),
    )


def _product(ops: list[UsdGeom.XformOp]) -> np.ndarray:
    matrix = np.eye(4)
    for op in ops:
        matrix = np.array(op.GetOpTransform(Usd.TimeCode.Default())) @ matrix
    return matrix


def _insert(xformable: UsdGeom.Xformable, ops: list[UsdGeom.XformOp], index: int, kind: str) -> list[UsdGeom.XformOp]:
    """Add a translate or orient op at a place in the order; pxr itself can only append."""
    resets = xformable.GetResetXformStack()
    suffix = "simulated" if any(op.GetName() == f"xformOp:{kind}" for op in ops) else ""
    add = xformable.AddTranslateOp if kind == "translate" else xformable.AddOrientOp
    added = add(opSuffix=suffix)
    identity = Sdf.ValueTypeNames.Quatf if kind == "orient" else Sdf.ValueTypeNames.Double3
    added.Set(identity.defaultValue)
    ops = [*ops[:index], added, *ops[index:]]
    xformable.SetXformOpOrder(ops, resets)
    return ops
