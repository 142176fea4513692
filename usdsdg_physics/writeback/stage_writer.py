"""Poses and velocities → the prims' own xform ops and velocity attributes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from usdsdg.errors import warn_once
from usdsdg.stage.changes import Changes
from usdsdg.stage.poses.transforms import euler_from_matrix, quat_from_matrix
from usdsdg_physics.scene.prim_paths import below
from usdsdg_physics.scene.records import Body
from usdsdg_physics.scene.rigid_frames import pose_matrix
from usdsdg_physics.writeback.pose_ops import PoseOps, plan_pose_ops
from usdsdg_physics.writeback.restore import Backup, attribute_spec

VELOCITY, ANGULAR_VELOCITY = "physics:velocity", "physics:angularVelocity"


@dataclass
class _Channel:
    """Attributes of one value type: body rows, their specs, and how numpy rows become values."""

    rows: list[int] = field(default_factory=list)
    specs: list[Sdf.AttributeSpec] = field(default_factory=list)


class Writer:
    """Writes bodies into one edit target. Everything that stays the same while they move is computed here once."""

    def __init__(self, stage: Usd.Stage, bodies: Mapping[str, Body], backup: Backup, *, meters_per_unit: float) -> None:
        self._stage = stage
        self._units = meters_per_unit
        self._target = stage.GetEditTarget()
        self._backup = backup
        self._channels: defaultdict[tuple[str, str], _Channel] = defaultdict(_Channel)
        self._rows = {path: row for row, path in enumerate(bodies)}
        self._sorted = sorted(bodies)
        self._own_ops: dict[str, set[str]] = {}
        self._specs: defaultdict[str, list[Sdf.AttributeSpec]] = defaultdict(list)
        count = len(bodies)
        self._left = np.tile(np.eye(4), (count, 1, 1))
        self._right = np.tile(np.eye(4), (count, 1, 1))
        self._between = np.tile(np.eye(4), (count, 1, 1))
        self._carried: list[tuple[int, int, np.ndarray, np.ndarray]] = []
        self._full = np.array([body.body_from_prim for body in bodies.values()]).reshape(-1, 4, 4) / meters_per_unit
        self._full[:, 3, 3] = 1.0
        cache = UsdGeom.XformCache(Usd.TimeCode.Default())
        for row, body in enumerate(bodies.values()):
            self._add(row, body, cache)
        self._poses = np.array([body.pose for body in bodies.values()], np.float32).reshape(-1, 7)
        self._velocities = np.array(
            [[*body.velocity, *body.angular_velocity] for body in bodies.values()], np.float32
        ).reshape(-1, 6)

    def is_stale(self, changes: Changes) -> bool:
        """Whether users changed what was worked out here: the edit target, an ancestor's transform, another op of a
        body, its attributes. Values of the ops that are written need nothing."""
        if self._target != self._stage.GetEditTarget():
            return True
        if any(below(self._sorted, str(root)) for root in changes.resynced):
            return True
        for path, names in changes.changed.items():
            ops = {name for name in names if name.startswith("xformOp")} - self._own_ops.get(str(path), set())
            if ops and below(self._sorted, str(path)):
                return True
        return any(spec.expired for path in changes.changed for spec in self._specs.get(str(path), ()))

    def set_known(self, poses: np.ndarray, velocities: np.ndarray) -> None:
        """Say that the stage already shows this state, because it was read from there."""
        self._poses, self._velocities = poses.astype(np.float32), velocities.astype(np.float32)

    def write(self, poses: np.ndarray, velocities: np.ndarray) -> None:
        """Author poses (N, 7) and velocities (N, 6) [SI] of the bodies whose values changed since the last call."""
        moved = (poses != self._poses).any(axis=1)
        sped = (velocities != self._velocities).any(axis=1)
        for row, carrier, _, _ in self._carried:
            moved[row] |= moved[carrier]
        values = self._values(poses, velocities)
        with Sdf.ChangeBlock():
            for (name, kind), channel in self._channels.items():
                chosen = sped if name in (VELOCITY, ANGULAR_VELOCITY) else moved
                _write_channel(channel, chosen, values[name, kind], _TO_VALUES[kind])
        self._poses, self._velocities = poses.copy(), velocities.copy()

    def _values(self, poses: np.ndarray, velocities: np.ndarray) -> dict[tuple[str, str], np.ndarray]:
        """For every channel, its numbers for all bodies."""
        frames = pose_matrix(poses, self._units)
        self._carry(frames)
        own = self._left @ frames @ self._right
        rotation = own[:, :3, :3] @ np.linalg.inv(self._between[:, :3, :3])
        rotation /= np.linalg.norm(rotation, axis=2, keepdims=True)
        roles = {
            VELOCITY: lambda: velocities[:, :3] / self._units,
            ANGULAR_VELOCITY: lambda: np.degrees(velocities[:, 3:]),
            "translate": lambda: own[:, 3, :3] - self._between[:, 3, :3],
            "matrix": lambda: own,
            "quat": lambda: quat_from_matrix(rotation),
        }
        return {
            (role, kind): roles[role]() if role in roles else _euler(rotation, role) for role, kind in self._channels
        }

    def _carry(self, frames: np.ndarray) -> None:
        """Bodies below another body: their parent has moved, so the way from the world to it has changed."""
        for row, carrier, parent_from_carrier, before_inverse in self._carried:
            parent = parent_from_carrier @ self._full[carrier] @ frames[carrier]
            self._right[row] = np.linalg.inv(parent) @ before_inverse

    def _add(self, row: int, body: Body, cache: UsdGeom.XformCache) -> None:
        prim = self._stage.GetPrimAtPath(body.path)
        if body.kinematic:
            return
        if abs(np.linalg.det(self._full[row])) < 1e-30:
            warn_once(f"{body.path} is scaled to nothing, so its pose cannot be written; give it a scale above zero.")
            return
        self._keep_before_adding_ops(prim)
        plan = plan_pose_ops(prim)
        before_inverse = np.linalg.inv(plan.before)
        self._left[row] = np.linalg.inv(plan.after) @ self._full[row]
        self._right[row] = np.linalg.inv(np.array(cache.GetParentToWorldTransform(prim))) @ before_inverse
        if UsdGeom.Xformable(prim).GetResetXformStack():
            self._right[row] = before_inverse
        elif (carrier := self._carrier(prim)) is not None:
            above = self._stage.GetPrimAtPath(list(self._rows)[carrier])
            relative = np.array(cache.ComputeRelativeTransform(prim.GetParent(), above)[0])
            self._carried.append((row, carrier, relative, before_inverse))
        self._between[row] = plan.between
        self._own_ops[body.path] = {plan.translate, *plan.rotate}
        self._open_channels(row, prim, plan)

    def _carrier(self, prim: Usd.Prim) -> int | None:
        parent = prim.GetParent()
        while parent and not parent.IsPseudoRoot():
            if str(parent.GetPath()) in self._rows:
                return self._rows[str(parent.GetPath())]
            parent = parent.GetParent()
        return None

    def _keep_before_adding_ops(self, prim: Usd.Prim) -> None:
        path = self._target.MapToSpecPath(prim.GetPath())
        for name in ("xformOpOrder", "xformOp:translate", "xformOp:orient"):
            self._backup.keep(self._target.GetLayer(), path.AppendProperty(name))

    def _open_channels(self, row: int, prim: Usd.Prim, plan: PoseOps) -> None:
        if plan.order == "matrix":
            self._open(row, prim, plan.translate, "matrix")
        else:
            self._open(row, prim, plan.translate, "translate")
            if len(plan.rotate) == 1:
                self._open(row, prim, plan.rotate[0], plan.order)
            else:
                for axis, name in zip("XYZ", plan.rotate):
                    self._open(row, prim, name, f"{plan.order}:{axis}")
        self._open(row, prim, VELOCITY, VELOCITY)
        self._open(row, prim, ANGULAR_VELOCITY, ANGULAR_VELOCITY)

    def _open(self, row: int, prim: Usd.Prim, name: str, role: str) -> None:
        attribute = prim.GetAttribute(name)
        self._backup.keep(self._target.GetLayer(), self._target.MapToSpecPath(attribute.GetPath()))
        channel = self._channels[role, str(attribute.GetTypeName())]
        spec = attribute_spec(self._target, attribute)
        _warn_if_hidden(attribute, spec)
        channel.rows.append(row)
        channel.specs.append(spec)
        self._specs[str(prim.GetPath())].append(spec)


def _warn_if_hidden(attribute: Usd.Attribute, spec: Sdf.AttributeSpec) -> None:
    stack = attribute.GetPropertyStack(Usd.TimeCode.Default())
    strongest = next((each for each in stack if each == spec or each.HasDefaultValue()), spec)
    if strongest != spec:
        warn_once(
            f"{attribute.GetPath()} is simulated but will not show: layer {strongest.layer.identifier} says otherwise "
            "and is stronger than the edit target. Remove that opinion or edit in that layer.",
        )


def _euler(rotation: np.ndarray, role: str) -> np.ndarray:
    """Degrees for a role such as "XYZ", or "XYZ:Y" for one of its axes."""
    order, _, axis = role.partition(":")
    angles = euler_from_matrix(rotation, order)
    return angles[:, "XYZ".index(axis)] if axis else angles


def _vt(array: type, dtype: type) -> Callable[[np.ndarray], Iterable[object]]:
    return lambda numbers: array.FromNumpy(np.ascontiguousarray(numbers, dtype))


_TO_VALUES: dict[str, Callable[[np.ndarray], Iterable[object]]] = {
    "double3": _vt(Vt.Vec3dArray, np.float64),
    "float3": _vt(Vt.Vec3fArray, np.float32),
    "half3": _vt(Vt.Vec3hArray, np.float16),
    "vector3f": _vt(Vt.Vec3fArray, np.float32),
    "quatd": _vt(Vt.QuatdArray, np.float64),
    "quatf": _vt(Vt.QuatfArray, np.float32),
    "quath": _vt(Vt.QuathArray, np.float16),
    "matrix4d": _vt(Vt.Matrix4dArray, np.float64),
    "double": lambda numbers: numbers.tolist(),
    "float": lambda numbers: numbers.tolist(),
    "half": lambda numbers: numbers.tolist(),
}


def _write_channel(
    channel: _Channel, chosen: np.ndarray, numbers: np.ndarray, to_values: Callable[[np.ndarray], Iterable[object]]
) -> None:
    mask = chosen[channel.rows]
    if not mask.any():
        return
    rows = np.asarray(channel.rows)[mask]
    specs = channel.specs if mask.all() else [channel.specs[i] for i in np.flatnonzero(mask)]
    # Iterating a Vt array makes Gf values several times faster than Python constructors do.
    for spec, value in zip(specs, to_values(numbers[rows])):
        spec.default = value
