"""Batched authoring of poses, in the xform ops that prims have.

`xform_ops.author_pose` does the same for one prim through USD's own interface. Here the Sdf specs of the ops are looked
up once per prim and set within one ChangeBlock, from Vt arrays: 1,000 prims take milliseconds.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pxr import Sdf, Usd, UsdGeom, Vt

from usdsdg.stage.attribute_batch import Expired, set_defaults
from usdsdg.stage.poses.first_ops import add_first_ops
from usdsdg.stage.poses.rotations import ROTATION_ORDERS, euler_from_matrix, matrix_from_euler, matrix_from_quat
from usdsdg.stage.poses.xform_ops import author_pose, gf_quat

Array = NDArray[np.float64]

_ROLES = ("translate", "rotate", "scale")
_FIRST_OPS = {"translate": "translate", "rotate": "rotateXYZ", "scale": "scale"}
_ROTATIONS = ("orient", *(f"rotate{order}" for order in ROTATION_ORDERS))
_ROLE_OF = {f"xformOp:{kind}": kind for kind in ("translate", "scale")} | {
    f"xformOp:{op}": "rotate" for op in _ROTATIONS
}
_VECTOR_ARRAYS: dict[str, tuple[Any, Any]] = {
    "double3": (Vt.Vec3dArray, np.float64),
    "float3": (Vt.Vec3fArray, np.float32),
    "half3": (Vt.Vec3hArray, np.float16),
}
_QUATERNION_ARRAYS: dict[str, tuple[Any, Any]] = {
    "quatd": (Vt.QuatdArray, np.float64),
    "quatf": (Vt.QuatfArray, np.float32),
    "quath": (Vt.QuathArray, np.float16),
}


class Rotations:
    """One rotation per prim, given as Euler angles XYZ [degrees] or as quaternions xyzw, and converted on demand."""

    def __init__(self, *, degrees: Array | None = None, quats: Array | None = None) -> None:
        """Give either `degrees` (N, 3) or `quats` (N, 4)."""
        self._degrees = np.zeros((0, 3)) if degrees is None else degrees
        self._quats = quats

    @property
    def are_angles(self) -> bool:
        """Whether they are given as Euler angles."""
        return self._quats is None

    def matrices(self) -> Array:
        """Return the rotation matrices (N, 3, 3), row vectors."""
        return matrix_from_quat(self._quats) if self._quats is not None else matrix_from_euler(self._degrees)

    def quats(self) -> Array:
        """Return the unit quaternions (N, 4) xyzw."""
        if self._quats is not None:
            return self._quats / np.linalg.norm(self._quats, axis=1, keepdims=True)
        half = np.radians(self._degrees) / 2
        (cx, cy, cz), (sx, sy, sz) = np.cos(half).T, np.sin(half).T
        x, y, z = sx * cy * cz - cx * sy * sz, cx * sy * cz + sx * cy * sz, cx * cy * sz - sx * sy * cz
        return np.stack([x, y, z, cx * cy * cz + sx * sy * sz], axis=1)

    def euler(self, order: str) -> Array:
        """Return the angles (N, 3) about x, y, z [degrees] of a rotate op of `order`; given angles stay, 370° too."""
        if self._quats is None and order == "XYZ":
            return self._degrees
        return euler_from_matrix(self.matrices(), order)

    def select(self, rows: Any) -> Rotations:
        """Return the rotations of some rows."""
        if self._quats is not None:
            return Rotations(quats=self._quats[rows])
        return Rotations(degrees=self._degrees[rows])

    def parts(self, row: int) -> dict[str, Any]:
        """Return the rotation of one row, as an argument of `author_pose`."""
        if self._quats is not None:
            return {"orient": gf_quat(self._quats[row])}
        return {"rotate_xyz": self._degrees[row].tolist()}


def author_poses(
    prims: Sequence[Usd.Prim],
    *,
    translate: Array | None = None,
    rotate: Rotations | None = None,
    scale: Array | None = None,
) -> None:
    """Set parts of the local poses of N different prims of one stage: `translate` (N, 3) [stage units], `scale` (N, 3).

    The result is that of `xform_ops.author_pose` for each prim, in the current edit target.

    Raises:
        BadPrim: a prim is not Xformable or cannot be edited.
    """
    columns = {"translate": translate, "rotate": rotate, "scale": scale}
    given = {role: column for role, column in columns.items() if column is not None}
    if not prims or not given:
        return
    are_angles = rotate is None or rotate.are_angles
    batch = _batch(list(prims), frozenset(given), [_FIRST_OPS[role] for role in _ROLES if role in given and are_angles])
    singly = sorted(batch.others.union(*(batch.lacking[role] for role in given)))
    try:
        with Sdf.ChangeBlock():
            for role, column in given.items():
                batch.write(role, column)
    except Expired:
        # A script has removed an op since it was looked up; author_pose adds it again.
        _batches.remove(batch)
        singly = list(range(len(prims)))
    for row in singly:
        parts: dict[str, Any] = {} if rotate is None else rotate.parts(row)
        for role in ("translate", "scale"):
            if role in given:
                parts[role] = given[role][row].tolist()
        author_pose(prims[row], **parts)


class _Group(NamedTuple):
    """Ops of one role that have the same type."""

    type_name: str  # a vector's or quaternion's type, or "float3 XYZ" for Euler angles
    rows: list[int]
    specs: list[Sdf.AttributeSpec]  # in the edit target's layer


class _Batch:
    """The xform ops of the prims of one call, cached for calls with the same prims."""

    def __init__(self, prims: list[Usd.Prim], target: Usd.EditTarget, roles: Set[str]) -> None:
        """Look up the ops; attributes are added to the layer only for `roles`, which will be written."""
        self.prims, self.target = prims, target
        self._stage = prims[0].GetStage() if prims and prims[0] else None
        self._stronger = _stronger_layers(self._stage, target.GetLayer())
        self.others: set[int] = set()  # rows that need `author_pose` whatever is written
        self.lacking: dict[str, set[int]] = {role: set() for role in _ROLES}
        self._groups: dict[str, list[_Group]] = {role: [] for role in _ROLES}
        self._unprepared: set[str] = set()  # roles of ops of which the layer has no attribute yet
        self._orders: list[Any] = []
        for row, prim in enumerate(prims):
            ops = self._look_up(prim)
            if ops is None:
                self.others.add(row)
                continue
            for role in _ROLES:
                if role not in ops:
                    self.lacking[role].add(row)
                elif spec := _spec(target.GetLayer(), ops[role], create=role in roles):
                    self._enter(role, row, _type_of(ops[role]), spec)
                else:
                    self._unprepared.add(role)
        self._orders_before = [order.default for order in self._orders]

    def holds(self, prims: list[Usd.Prim], target: Usd.EditTarget, roles: Set[str]) -> bool:
        """Whether these are the same prims, and they still exist with the same ops in the same order."""
        if prims != self.prims or target != self.target or not all(prims) or not self._unprepared.isdisjoint(roles):
            return False
        try:
            return [order.default for order in self._orders] == self._orders_before
        except (RuntimeError, TypeError):  # an order has been removed
            return False

    def write(self, role: str, column: Any) -> None:
        """Set the ops of one role; raises as `set_defaults`."""
        for group in self._groups[role]:
            part = column
            if len(group.rows) < len(self.prims):
                part = column.select(group.rows) if isinstance(column, Rotations) else column[group.rows]
            kind = group.type_name
            values = _rotations(part, kind) if isinstance(part, Rotations) else _vectors(part, kind)
            set_defaults(group.specs, values)

    def _enter(self, role: str, row: int, type_name: str, spec: Sdf.AttributeSpec) -> None:
        for group in self._groups[role]:
            if group.type_name == type_name:
                group.rows.append(row)
                group.specs.append(spec)
                return
        self._groups[role].append(_Group(type_name, [row], [spec]))

    def _look_up(self, prim: Usd.Prim) -> dict[str, Usd.Attribute] | None:
        """Return the attribute of each op by role; None for ops that only `author_pose` supports."""
        if not prim or prim.IsInstanceProxy() or prim.IsInPrototype() or not prim.IsA(UsdGeom.Xformable):
            return None
        if prim.GetStage() != self._stage:
            return None
        layer, order = self.target.GetLayer(), prim.GetAttribute("xformOpOrder")
        names = list(order.Get() or ())
        ranks = [_ROLES.index(_ROLE_OF[name]) for name in names if name in _ROLE_OF]
        # Only translate, one rotation, scale, each at most once, can be written independently.
        if len(ranks) != len(names) or ranks != sorted(set(ranks)):
            return None
        ops = {_ROLE_OF[name]: prim.GetAttribute(name) for name in names}
        if any(not attr or attr.GetNumTimeSamples() or attr.HasSpline() for attr in ops.values()):
            return None
        path = order.GetPath()
        spec = layer.GetAttributeAtPath(path)
        # If another layer has the order, it must be read from the stage.
        layers = self._stronger
        ours = spec is not None and layers is not None and not any(each.GetAttributeAtPath(path) for each in layers)
        self._orders.append(spec if ours else _Composed(order))
        return ops


def _stronger_layers(stage: Usd.Stage | None, layer: Sdf.Layer) -> list[Sdf.Layer] | None:
    """The layers of a stage whose opinions are stronger than those of one; None if it is no layer of the stage."""
    layers = stage.GetLayerStack() if stage else []
    return layers[: layers.index(layer)] if layer in layers else None


class _Composed:
    """A composed attribute with the interface of a spec."""

    def __init__(self, attribute: Usd.Attribute) -> None:
        self._attribute = attribute

    @property
    def default(self) -> Any:
        return self._attribute.Get()


# The last few batches, newest first: scripts pose the same groups repeatedly.
_batches: list[_Batch] = []
_MAX_BATCHES = 16


def _batch(prims: list[Usd.Prim], roles: Set[str], first_ops: Sequence[str]) -> _Batch:
    """Return the batch of some prims. When it is made, prims without any op get `first_ops`."""
    target = prims[0].GetStage().GetEditTarget() if prims[0] else Usd.EditTarget()
    for batch in _batches:
        if len(batch.prims) == len(prims) and batch.holds(prims, target, roles):
            return batch
    # Inside a variant or a reference paths differ from the stage's.
    if not prims[0] or not target.GetMapFunction().isIdentity:
        batch = _Batch([], target, roles)
        batch.others = set(range(len(prims)))
        return batch
    if first_ops:
        add_first_ops(prims, target.GetLayer(), first_ops)
    with Sdf.ChangeBlock():
        batch = _Batch(prims, target, roles)
    _batches[:] = [batch, *(each for each in _batches if each.prims != prims)][:_MAX_BATCHES]
    return batch


def _spec(layer: Sdf.Layer, attribute: Usd.Attribute, *, create: bool) -> Sdf.AttributeSpec | None:
    path = attribute.GetPath()
    if create and not layer.GetAttributeAtPath(path):
        Sdf.JustCreatePrimAttributeInLayer(layer, path, attribute.GetTypeName())
    return layer.GetAttributeAtPath(path)


def _type_of(op: Usd.Attribute) -> str:
    """Return the type of an op: "double3", "quatf", or "float3 ZYX" for Euler angles."""
    kind, type_name = op.GetName().removeprefix("xformOp:"), str(op.GetTypeName())
    return f"{type_name} {kind.removeprefix('rotate')}" if kind.startswith("rotate") else type_name


def _vectors(column: Array, type_name: str) -> Sequence[Any]:
    array, dtype = _VECTOR_ARRAYS[type_name]
    return array.FromNumpy(np.ascontiguousarray(column, dtype))


def _rotations(column: Rotations, type_name: str) -> Sequence[Any]:
    if type_name in _QUATERNION_ARRAYS:
        array, dtype = _QUATERNION_ARRAYS[type_name]
        return array.FromNumpy(np.ascontiguousarray(column.quats(), dtype))
    vectors, _, order = type_name.partition(" ")
    return _vectors(column.euler(order), vectors)
