"""Transforms of prims: read them, and write poses into whatever xform ops a prim already has."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from pxr import Gf, Usd, UsdGeom

from usdsdg.errors import BadPrim, DegenerateFrame
from usdsdg.stage.rotations import (
    Pose,
    compose,
    compose_euler,
    decompose,
    euler_from_matrix,
    euler_xyz_from_quat,
    matrix_from_euler,
    matrix_from_quat,
    quat_from_matrix,
)

__all__ = [
    "Pose",
    "as_array",
    "author_pose",
    "compose",
    "compose_euler",
    "decompose",
    "euler_from_matrix",
    "euler_xyz_from_quat",
    "gf_quat",
    "local_to_world",
    "look_at",
    "matrix_from_euler",
    "matrix_from_quat",
    "meters_per_unit",
    "quat_from_matrix",
    "up_axis",
    "world_to_local",
]

Vector = Sequence[float] | Gf.Vec3d | Gf.Vec3f | np.ndarray

_TYPES = UsdGeom.XformOp
# Order in which a three-axis rotate op turns, outermost axis last.
_EULER_ORDERS = {
    getattr(_TYPES, f"TypeRotate{order}"): order for order in ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
}
_SINGLE_AXES = {getattr(_TYPES, f"TypeRotate{axis}"): axis for axis in "XYZ"}
_VECTORS = {_TYPES.PrecisionDouble: Gf.Vec3d, _TYPES.PrecisionFloat: Gf.Vec3f, _TYPES.PrecisionHalf: Gf.Vec3h}
_QUATERNIONS = {
    _TYPES.PrecisionDouble: Gf.Quatd,
    _TYPES.PrecisionFloat: Gf.Quatf,
    _TYPES.PrecisionHalf: Gf.Quath,
}


def local_to_world(prim: Usd.Prim, time: Usd.TimeCode = Usd.TimeCode.Default()) -> Gf.Matrix4d:  # noqa: B008
    """Matrix from the prim's own space to the world [stage units]; identity where nothing has a transform."""
    return UsdGeom.XformCache(time).GetLocalToWorldTransform(prim)


def world_to_local(prim: Usd.Prim, time: Usd.TimeCode = Usd.TimeCode.Default()) -> Gf.Matrix4d:  # noqa: B008
    """Inverse of `local_to_world`.

    Raises:
        DegenerateFrame: the prim or an ancestor is scaled to zero.
    """
    matrix = local_to_world(prim, time)
    if abs(matrix.GetDeterminant()) < 1e-30:
        raise DegenerateFrame(
            f"{prim.GetPath()} has no inverse transform: it or an ancestor has a scale of zero"
        )
    return matrix.GetInverse()


def as_array(matrix: Gf.Matrix4d) -> np.ndarray:
    """(4, 4) float64 copy, row vectors as in USD."""
    return np.array(matrix, np.float64)


def gf_quat(quat_xyzw: ArrayLike) -> Gf.Quatd:
    """One quaternion (x, y, z, w) as pxr wants it."""
    x, y, z, w = (float(value) for value in np.asarray(quat_xyzw))
    return Gf.Quatd(w, x, y, z)


def meters_per_unit(stage: Usd.Stage) -> float:
    """Length of one stage unit [m]."""
    return float(UsdGeom.GetStageMetersPerUnit(stage))


def up_axis(stage: Usd.Stage) -> str:
    """'Y' or 'Z'."""
    return str(UsdGeom.GetStageUpAxis(stage))


def look_at(eye: Vector, target: Vector, *, up: Vector = (0.0, 0.0, 1.0)) -> Gf.Matrix4d:
    """Camera-to-world matrix [stage units] of a USD camera (looks along -Z, +Y up) at `eye`.

    Raises:
        DegenerateFrame: eye and target coincide, or the view direction is parallel to `up`.
    """
    eye, target, up = (np.asarray(tuple(vector), np.float64) for vector in (eye, target, up))
    back = eye - target
    distance, height = np.linalg.norm(back), np.linalg.norm(up)
    if not distance > 1e-12 * max(1.0, float(np.abs(eye).max())):
        raise DegenerateFrame(
            f"a camera at {tuple(eye)} cannot look at its own position; move the eye or the target"
        )
    right = np.cross(up, back) / (height * distance) if height > 0 else np.zeros(3)
    if not np.linalg.norm(right) > 1e-9:
        raise DegenerateFrame(
            f"a camera at {tuple(eye)} looking at {tuple(target)} looks along its up direction {tuple(up)}; "
            "choose another up or move the eye sideways"
        )
    back /= distance
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = right, np.cross(back, right), back
    matrix[3, :3] = eye
    return Gf.Matrix4d(matrix.tolist())


def author_pose(
    prim: Usd.Prim,
    *,
    translate: Vector | None = None,
    rotate_xyz: Vector | None = None,
    orient: Gf.Quatd | Gf.Quatf | Gf.Quath | None = None,
    scale: Vector | None = None,
) -> None:
    """Set parts of a prim's local pose in the ops that it has; ops that are missing are added as translate,
    rotateXYZ (or orient), scale, in this order.

    `rotate_xyz` is in degrees, x first. A prim with another rotate order, an orient op or a single matrix
    gets the same rotation in that form, at that op's precision. Pivots and !resetXformStack! stay.

    Raises:
        BadPrim: the prim is not Xformable or cannot be edited (it lies inside an instance).
        ValueError: both `rotate_xyz` and `orient` are given.
    """
    if rotate_xyz is not None and orient is not None:
        raise ValueError("give either rotate_xyz or orient, not both")
    xformable = _editable(prim)
    ops = _Ops(xformable)
    if translate is not None:
        ops.set_translate(translate)
    if rotate_xyz is not None:
        ops.set_rotation(rotate_xyz, None)
    if orient is not None:
        ops.set_rotation(None, orient)
    if scale is not None:
        ops.set_scale(scale)


def _editable(prim: Usd.Prim) -> UsdGeom.Xformable:
    if not prim:
        raise BadPrim(f"cannot pose {prim}: the prim does not exist any more")
    if prim.IsInstanceProxy() or prim.IsInPrototype():
        raise BadPrim(
            f"cannot pose {prim.GetPath()}: it lies inside an instance; "
            "pose the instance or SetInstanceable(False)"
        )
    if not prim.IsA(UsdGeom.Xformable):
        kind = prim.GetTypeName() or "a prim without a type"
        raise BadPrim(
            f"cannot pose {prim.GetPath()}: {kind} has no transform; "
            "it must be an Xform, gprim, camera or light"
        )
    return UsdGeom.Xformable(prim)


class _Ops:
    """The xform ops of one prim while a pose is written."""

    def __init__(self, xformable: UsdGeom.Xformable) -> None:
        self.xformable = xformable
        self.ops = xformable.GetOrderedXformOps()
        self.resets = xformable.GetResetXformStack()

    def find(self, *kinds: UsdGeom.XformOp.Type) -> UsdGeom.XformOp | None:
        """The outermost op of one of these kinds that is not part of a pivot."""
        for op in self.ops:
            if op.GetOpType() in kinds and not op.IsInverseOp() and not op.GetOpName().endswith(":pivot"):
                return op
        return None

    def set_translate(self, value: Vector) -> None:
        if op := self.find(_TYPES.TypeTranslate):
            _set_vector(op, value)
        elif matrix := self.find(_TYPES.TypeTransform):
            matrix.Set(_replaced(matrix, translate=value))
        else:
            self.insert(0, lambda: self.xformable.AddTranslateOp(), value)

    def set_scale(self, value: Vector) -> None:
        if op := self.find(_TYPES.TypeScale):
            _set_vector(op, value)
        elif matrix := self.find(_TYPES.TypeTransform):
            matrix.Set(_replaced(matrix, scale=value))
        else:
            self.insert(self.after_rotation(), lambda: self.xformable.AddScaleOp(), value)

    def set_rotation(self, degrees: Vector | None, orient: Gf.Quatd | Gf.Quatf | Gf.Quath | None) -> None:
        if op := self.find(_TYPES.TypeOrient):
            op.Set(_QUATERNIONS[op.GetPrecision()](_as_quat(degrees, orient)))
        elif op := self.find(*_EULER_ORDERS):
            _set_vector(op, _as_euler(degrees, orient, _EULER_ORDERS[op.GetOpType()]))
        elif self.find(*_SINGLE_AXES):
            self.set_single_axes(degrees, orient)
        elif matrix := self.find(_TYPES.TypeTransform):
            matrix.Set(_replaced(matrix, orient=_as_quat(degrees, orient)))
        elif orient is not None:
            self.insert(self.after_translation(), lambda: self.xformable.AddOrientOp(), Gf.Quatf(orient))
        else:
            self.insert(self.after_translation(), lambda: self.xformable.AddRotateXYZOp(), degrees)

    def set_single_axes(self, degrees: Vector | None, orient: Gf.Quatd | Gf.Quatf | Gf.Quath | None) -> None:
        """Rotations about one axis each: three of them in a row form an Euler order; fewer give way to
        rotateXYZ.
        """
        singles = [op for op in self.ops if op.GetOpType() in _SINGLE_AXES and not op.IsInverseOp()]
        # The op listed last is applied first.
        order = "".join(_SINGLE_AXES[op.GetOpType()] for op in reversed(singles))
        start = self.ops.index(singles[0])
        if sorted(order) == ["X", "Y", "Z"] and self.ops[start : start + 3] == singles:
            angles = _as_euler(degrees, orient, order)
            for op in singles:
                op.Set(float(angles["XYZ".index(_SINGLE_AXES[op.GetOpType()])]))
            return
        self.ops = [op for op in self.ops if op not in singles]
        angles = _as_euler(degrees, orient, "XYZ")
        self.insert(start, lambda: self.xformable.AddRotateXYZOp(), angles)

    def insert(self, index: int, add: object, value: Vector | Gf.Quatf) -> None:
        """Add an op at `index` of the order; pxr can only append."""
        before = list(self.ops)
        self.xformable.SetXformOpOrder(before, self.resets)
        op = add()
        self.ops = [*before[:index], op, *before[index:]]
        if index != len(before):
            self.xformable.SetXformOpOrder(self.ops, self.resets)
        op.Set(value) if isinstance(value, Gf.Quatf) else _set_vector(op, value)

    def after_translation(self) -> int:
        """Behind the leading translate and pivot, where a rotation belongs."""
        index = 0
        while (
            index < len(self.ops)
            and self.ops[index].GetOpType() == _TYPES.TypeTranslate
            and not self.ops[index].IsInverseOp()
        ):
            index += 1
        return index

    def after_rotation(self) -> int:
        """Behind the last rotation, where a scale belongs."""
        rotations = {_TYPES.TypeOrient, *_EULER_ORDERS, *_SINGLE_AXES}
        places = [i for i, op in enumerate(self.ops) if op.GetOpType() in rotations and not op.IsInverseOp()]
        return places[-1] + 1 if places else self.after_translation()


def _set_vector(op: UsdGeom.XformOp, value: Vector) -> None:
    op.Set(_VECTORS[op.GetPrecision()](*(float(component) for component in value)))


def _as_quat(degrees: Vector | None, orient: Gf.Quatd | Gf.Quatf | Gf.Quath | None) -> Gf.Quatd:
    return (
        Gf.Quatd(orient)
        if orient is not None
        else gf_quat(quat_from_matrix(matrix_from_euler(tuple(degrees or ()))))
    )


def _as_euler(degrees: Vector | None, orient: Gf.Quatd | Gf.Quatf | Gf.Quath | None, order: str) -> Vector:
    """Angles for an op of `order`; given angles stay untouched where the order agrees (370° stays 370°)."""
    if degrees is not None and order == "XYZ":
        return degrees
    quat = _as_quat(degrees, orient)
    return euler_from_matrix(matrix_from_quat((*quat.GetImaginary(), quat.GetReal())), order)


def _replaced(
    op: UsdGeom.XformOp,
    *,
    translate: Vector | None = None,
    orient: Gf.Quatd | None = None,
    scale: Vector | None = None,
) -> Gf.Matrix4d:
    """The matrix of a transform op with one part of its pose exchanged."""
    pose = decompose(as_array(op.GetOpTransform(Usd.TimeCode.Default())))
    rotation = pose.rotation if orient is None else (*orient.GetImaginary(), orient.GetReal())
    matrix = compose(
        pose.translate if translate is None else tuple(translate),
        rotation,
        pose.scale if scale is None else tuple(scale),
    )
    return Gf.Matrix4d(matrix.tolist())
