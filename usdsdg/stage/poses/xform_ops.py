"""Reading and authoring of the pose of one prim, in the xform ops that it has."""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from pxr import Gf, Usd, UsdGeom

from usdsdg.errors import BadPrim
from usdsdg.stage.poses.rotations import (
    ROTATION_ORDERS,
    compose,
    decompose,
    euler_from_matrix,
    matrix_from_euler,
    matrix_from_quat,
    quat_from_matrix,
)
from usdsdg.stage.poses.transforms import SINGULAR, as_array, inverse_of_parent, product_of_ops

Vector: TypeAlias = Sequence[float] | Gf.Vec3d | Gf.Vec3f | np.ndarray
Quaternion: TypeAlias = Gf.Quatd | Gf.Quatf | Gf.Quath

_TYPES = UsdGeom.XformOp
# Axis order of three-axis rotate ops; the last axis is applied last.
EULER_ORDERS = {getattr(_TYPES, f"TypeRotate{order}"): order for order in ROTATION_ORDERS}
SINGLE_AXES = {getattr(_TYPES, f"TypeRotate{axis}"): axis for axis in "XYZ"}
_VECTORS = {_TYPES.PrecisionDouble: Gf.Vec3d, _TYPES.PrecisionFloat: Gf.Vec3f, _TYPES.PrecisionHalf: Gf.Vec3h}
_PRECISIONS = {"d": _TYPES.PrecisionDouble, "f": _TYPES.PrecisionFloat, "h": _TYPES.PrecisionHalf}
_QUATERNIONS = {_TYPES.PrecisionDouble: Gf.Quatd, _TYPES.PrecisionFloat: Gf.Quatf, _TYPES.PrecisionHalf: Gf.Quath}


def author_pose(
    prim: Usd.Prim,
    *,
    translate: Vector | None = None,
    rotate_xyz: Vector | None = None,
    orient: Quaternion | None = None,
    scale: Vector | None = None,
) -> None:
    """Set parts of a prim's local pose, in the ops that it has.

    Missing ops are added in the order translate, rotateXYZ (or orient), scale. `rotate_xyz` is in degrees, x
    first. A prim with another rotate order, an orient op or a single matrix gets the same rotation in that form, at
    that op's precision. Pivots and !resetXformStack! stay. `translate` is in the parent's space also where ops that
    are applied after the translate op turn or scale it.

    Raises:
        BadPrim: the prim is not Xformable or cannot be edited (it lies inside an instance), or an op that is applied
            after its translate op scales it to zero.
        ValueError: both `rotate_xyz` and `orient` are given.
    """
    if rotate_xyz is not None and orient is not None:
        raise ValueError("give either rotate_xyz or orient, not both")
    ops = _Ops(_editable(prim))
    if translate is not None:
        ops.set_translate(translate)
    if rotate_xyz is not None or orient is not None:
        ops.set_rotation(_Rotation(rotate_xyz, orient))
    if scale is not None:
        ops.set_scale(scale)


def author_world_position(
    prim: Usd.Prim,
    point: Vector,
    time: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
) -> None:
    """Move a prim to a point of the world [stage units], with what is above it as it is at a time.

    Raises:
        BadPrim: the prim has no transform.
        DegenerateFrame: an ancestor is scaled to zero.
    """
    in_parent = inverse_of_parent(prim, time).Transform(Gf.Vec3d(*(float(c) for c in point)))
    author_pose(prim, translate=in_parent)


def local_translation(prim: Usd.Prim) -> np.ndarray:
    """Return the translation (3,) of the translate op [parent's space]; without one, of the local matrix."""
    xformable = UsdGeom.Xformable(prim)
    ops = _Ops(xformable)
    op = ops.find(_TYPES.TypeTranslate)
    if op is not None:
        value = op.Get() or (0.0, 0.0, 0.0)
        after = ops.applied_after(op)
        return np.array(after.Transform(Gf.Vec3d(*value)) if after is not None else value, np.float64)
    return as_array(xformable.GetLocalTransformation())[3, :3]


def local_euler(prim: Usd.Prim, order: str = "XYZ") -> np.ndarray:
    """Return the angles (3,) about x, y, z [degrees] of the prim's own rotation, for a rotate op of `order`."""
    xformable = UsdGeom.Xformable(prim)
    op = _Ops(xformable).find(getattr(_TYPES, f"TypeRotate{order}"))
    if op is not None:
        return np.array(op.Get() or (0.0, 0.0, 0.0), np.float64)
    pose = decompose(as_array(xformable.GetLocalTransformation()))
    return euler_from_matrix(matrix_from_quat(pose.rotation), order)


def _editable(prim: Usd.Prim) -> UsdGeom.Xformable:
    if not prim:
        raise BadPrim(f"cannot pose {prim}: the prim does not exist any more")
    if prim.IsInstanceProxy() or prim.IsInPrototype():
        raise BadPrim(
            f"cannot pose {prim.GetPath()}: it lies inside an instance; pose the instance or SetInstanceable(False)"
        )
    if not prim.IsA(UsdGeom.Xformable):
        kind = prim.GetTypeName() or "a prim without a type"
        raise BadPrim(
            f"cannot pose {prim.GetPath()}: {kind} has no transform; it must be an Xform, gprim, camera or light"
        )
    return UsdGeom.Xformable(prim)


def gf_quat(quat_xyzw: ArrayLike) -> Gf.Quatd:
    """Convert one quaternion (x, y, z, w) to pxr's type."""
    x, y, z, w = (float(value) for value in np.asarray(quat_xyzw))
    return Gf.Quatd(w, x, y, z)


class _Rotation(NamedTuple):
    """A rotation as the caller gave it: Euler angles or a quaternion."""

    degrees: Vector | None
    orient: Quaternion | None

    def quat(self) -> Gf.Quatd:
        if self.orient is not None:
            return Gf.Quatd(self.orient)
        return gf_quat(quat_from_matrix(matrix_from_euler(() if self.degrees is None else self.degrees)))

    def euler(self, order: str) -> Vector:
        """Return the angles about x, y, z for an op of `order`; given angles stay if the order agrees, 370° too."""
        if self.degrees is not None and order == "XYZ":
            return self.degrees
        quat = self.quat()
        return euler_from_matrix(matrix_from_quat((*quat.GetImaginary(), quat.GetReal())), order)


class _Ops:
    """The xform ops of one prim during authoring of a pose."""

    def __init__(self, xformable: UsdGeom.Xformable) -> None:
        self.xformable = xformable
        self.ops = xformable.GetOrderedXformOps()
        self.resets = xformable.GetResetXformStack()

    def find(self, *kinds: UsdGeom.XformOp.Type) -> UsdGeom.XformOp | None:
        """Return the outermost op of these types that is not part of a pivot."""
        for op in self.ops:
            if op.GetOpType() in kinds and not op.IsInverseOp() and not op.GetOpName().endswith(":pivot"):
                return op
        return None

    def set_translate(self, value: Vector) -> None:
        if op := self.find(_TYPES.TypeTranslate):
            _set(op, self.translation_for(op, value))
        elif matrix := self.find(_TYPES.TypeTransform):
            matrix.Set(_replaced(matrix, translate=value))
        else:
            self.insert(0, _TYPES.TypeTranslate, value)

    def applied_after(self, op: UsdGeom.XformOp) -> Gf.Matrix4d | None:
        """Return the matrix of the ops that are applied after one, which are listed before it; None without any."""
        after = self.ops[: self.ops.index(op)]
        return product_of_ops(each.GetOpTransform(Usd.TimeCode.Default()) for each in after) if after else None

    def translation_for(self, op: UsdGeom.XformOp, point: Vector) -> Vector:
        """Return the value of a translate op that lands at a point of the parent's space."""
        after = self.applied_after(op)
        if after is None:
            return point
        if abs(after.GetDeterminant()) < SINGULAR:
            raise BadPrim(f"{self.xformable.GetPath()} cannot be placed: an op before its translate op scales it to 0")
        return after.GetInverse().Transform(Gf.Vec3d(*(float(c) for c in point)))

    def set_scale(self, value: Vector) -> None:
        if op := self.find(_TYPES.TypeScale):
            _set(op, value)
        elif matrix := self.find(_TYPES.TypeTransform):
            matrix.Set(_replaced(matrix, scale=value))
        else:
            self.insert(self.after_rotation(), _TYPES.TypeScale, value)

    def set_rotation(self, rotation: _Rotation) -> None:
        if op := self.find(_TYPES.TypeOrient):
            _set(op, rotation.quat())
        elif op := self.find(*EULER_ORDERS):
            _set(op, rotation.euler(EULER_ORDERS[op.GetOpType()]))
        elif self.find(*SINGLE_AXES):
            self.set_single_axes(rotation)
        elif matrix := self.find(_TYPES.TypeTransform):
            matrix.Set(_replaced(matrix, orient=rotation.quat()))
        elif rotation.orient is not None:
            self.insert(self.after_translation(), _TYPES.TypeOrient, rotation.orient)
        else:
            self.insert(self.after_translation(), _TYPES.TypeRotateXYZ, rotation.euler("XYZ"))

    def set_single_axes(self, rotation: _Rotation) -> None:
        """Set single-axis ops; unless they are three consecutive ops about all axes, replace them by rotateXYZ."""
        singles = [op for op in self.ops if op.GetOpType() in SINGLE_AXES and not op.IsInverseOp()]
        # The op listed last is applied first.
        order = "".join(SINGLE_AXES[op.GetOpType()] for op in reversed(singles))
        start = self.ops.index(singles[0])
        if sorted(order) == ["X", "Y", "Z"] and self.ops[start : start + 3] == singles:
            angles = rotation.euler(order)
            for op in singles:
                op.Set(float(angles["XYZ".index(SINGLE_AXES[op.GetOpType()])]))
            return
        self.ops = [op for op in self.ops if op not in singles]
        angles = rotation.euler("XYZ")
        self.insert(start, _TYPES.TypeRotateXYZ, angles)

    def insert(self, index: int, kind: UsdGeom.XformOp.Type, value: Vector | Quaternion) -> None:
        """Insert an op at `index` of the order; pxr can only append."""
        name = f"xformOp:{UsdGeom.XformOp.GetOpTypeToken(kind)}"
        precision = _precision(self.xformable.GetPrim().GetAttribute(name), kind)
        before = list(self.ops)
        self.xformable.SetXformOpOrder(before, self.resets)
        op = self.xformable.AddXformOp(kind, precision)
        self.ops = [*before[:index], op, *before[index:]]
        if index != len(before):
            self.xformable.SetXformOpOrder(self.ops, self.resets)
        _set(op, value)

    def after_translation(self) -> int:
        """Return the index after the leading translate and pivot, where a rotation belongs."""
        index = 0
        while (
            index < len(self.ops)
            and self.ops[index].GetOpType() == _TYPES.TypeTranslate
            and not self.ops[index].IsInverseOp()
        ):
            index += 1
        return index

    def after_rotation(self) -> int:
        """Return the index after the last rotation, where a scale belongs."""
        rotations = {_TYPES.TypeOrient, *EULER_ORDERS, *SINGLE_AXES}
        indices = [i for i, op in enumerate(self.ops) if op.GetOpType() in rotations and not op.IsInverseOp()]
        return indices[-1] + 1 if indices else self.after_translation()


def _precision(attribute: Usd.Attribute, kind: UsdGeom.XformOp.Type) -> UsdGeom.XformOp.Precision:
    """Return the precision of an existing attribute that is not in the order, else pxr's default for new ops."""
    letter = str(attribute.GetTypeName()).removeprefix("quat")[:1] if attribute else ""
    usual = _TYPES.PrecisionDouble if kind == _TYPES.TypeTranslate else _TYPES.PrecisionFloat
    return _PRECISIONS.get(letter, usual)


def _set(op: UsdGeom.XformOp, value: Vector | Quaternion) -> None:
    """Set an op in its own precision."""
    if op.GetOpType() == _TYPES.TypeOrient:
        op.Set(_QUATERNIONS[op.GetPrecision()](value))
    else:
        op.Set(_VECTORS[op.GetPrecision()](*(float(component) for component in value)))


def _replaced(
    op: UsdGeom.XformOp, *, translate: Vector | None = None, orient: Gf.Quatd | None = None, scale: Vector | None = None
) -> Gf.Matrix4d:
    """Return the matrix of a transform op with one part of its pose replaced."""
    pose = decompose(np.array(op.GetOpTransform(Usd.TimeCode.Default())))
    rotation = pose.rotation if orient is None else (*orient.GetImaginary(), orient.GetReal())
    matrix = compose(
        pose.translate if translate is None else tuple(translate),
        rotation,
        pose.scale if scale is None else tuple(scale),
    )
    return Gf.Matrix4d(matrix.tolist())
