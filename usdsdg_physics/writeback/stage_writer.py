"""Write poses and velocities to the xform ops and velocity attributes that the prims have."""

from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import compress

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from usdsdg.errors import PhysicsError, warn_once
from usdsdg.stage.changes import Changes
from usdsdg.stage.physics.instances import split_instance
from usdsdg.stage.poses.rotations import euler_from_matrix, quat_from_matrix
from usdsdg_physics.scene.prim_paths import paths_below
from usdsdg_physics.scene.records import Body
from usdsdg_physics.scene.rigid_frames import pose_matrix
from usdsdg_physics.writeback.pose_ops import PoseOps, choose_pose_ops
from usdsdg_physics.writeback.restore import Backup, attribute_spec
from usdsdg_physics.writeback.shown import is_strongest, warn_if_deformed, warn_if_overridden

# What `spec.default = value` calls; a microsecond, which is most of the time that writing takes.
_set_default = Sdf.AttributeSpec.default.fset

VELOCITY, ANGULAR_VELOCITY = "physics:velocity", "physics:angularVelocity"


@dataclass
class _Channel:
    """Attributes of one role and value type: the rows of their bodies, and their specs."""

    rows: list[int] = field(default_factory=list)
    specs: list[Sdf.AttributeSpec] = field(default_factory=list)

    @cached_property
    def row_array(self) -> np.ndarray:
        """The rows, when all are there."""
        return np.array(self.rows)


class StageWriter:
    """Writes bodies into one edit target; what stays constant while they move is computed once, when it is made.

    The matrix of the pose ops of a body is `left @ frame @ right`, where `frame` is its rigid frame (see `PoseOps`):
    `left` = after⁻¹ · body_from_prim, `right` = parent_to_world⁻¹ · before⁻¹.
    """

    def __init__(self, stage: Usd.Stage, bodies: Mapping[str, Body], backup: Backup, *, meters_per_unit: float) -> None:
        self._stage = stage
        self._meters_per_unit = meters_per_unit
        self._target = stage.GetEditTarget()
        if bodies and not self._target.GetLayer().permissionToEdit:
            raise PhysicsError(
                f"the edit target, layer {self._target.GetLayer().identifier}, may not be edited, so poses cannot be "
                "written there. Allow edits (Sdf.Layer.SetPermissionToEdit), or set another edit target."
            )
        self._backup = backup
        self._is_strongest = is_strongest(stage, self._target)
        self._channels: defaultdict[tuple[str, str], _Channel] = defaultdict(_Channel)
        self._rows = {path: row for row, path in enumerate(bodies)}
        self._sorted = sorted(bodies)
        self._written_ops: dict[str, set[str]] = {}
        self._specs: defaultdict[str, list[Sdf.AttributeSpec]] = defaultdict(list)
        count = len(bodies)
        self._left = np.tile(np.eye(4), (count, 1, 1))
        self._right = np.tile(np.eye(4), (count, 1, 1))
        self._between = np.tile(np.eye(4), (count, 1, 1))
        # Bodies below another: row, row of the ancestor, parent_from_ancestor, before⁻¹.
        self._nested: list[tuple[int, int, np.ndarray, np.ndarray]] = []
        self._body_from_prim = (
            np.array([body.body_from_prim for body in bodies.values()]).reshape(-1, 4, 4) / meters_per_unit
        )
        self._body_from_prim[:, 3, 3] = 1.0
        cache = UsdGeom.XformCache(Usd.TimeCode.Default())
        for row, body in enumerate(bodies.values()):
            self._add(row, body, cache)
        self._between_inverse = np.linalg.inv(self._between[:, :3, :3])
        self._poses = np.array([body.pose for body in bodies.values()], np.float32).reshape(-1, 7)
        self._velocities = np.array(
            [[*body.velocity, *body.angular_velocity] for body in bodies.values()], np.float32
        ).reshape(-1, 6)

    def is_stale(self, changes: Changes) -> bool:
        """Return whether the constants are out of date.

        They are when users changed the edit target, an ancestor's transform, another op of a body, or removed its
        attributes; values of the ops that are written do not matter.
        """
        if self._target != self._stage.GetEditTarget():
            return True
        if any(paths_below(self._sorted, str(root)) for root in changes.resynced):
            return True
        for path, names in changes.changed.items():
            others = {name for name in names if name.startswith("xformOp")} - self._written_ops.get(str(path), set())
            if others and paths_below(self._sorted, str(path)):
                return True
        return any(spec.expired for path in changes.changed for spec in self._specs.get(str(path), ()))

    def set_written(self, poses: np.ndarray, velocities: np.ndarray) -> None:
        """Set the state that the stage already has, because it was read from there."""
        self._poses, self._velocities = poses.astype(np.float32), velocities.astype(np.float32)

    def write(self, poses: np.ndarray, velocities: np.ndarray) -> None:
        """Author what changed since the last call of poses (N, 7) and velocities (N, 6) [SI].

        That is less than all of what moves: what falls keeps its spin, and what slides its rotation.
        """
        changed = self._changed(poses, velocities)
        values = self._values(poses, velocities)
        with Sdf.ChangeBlock():
            for (role, kind), channel in self._channels.items():
                _write_channel(channel, changed.get(role, changed["rotate"]), values[role, kind], _TO_VALUES[kind])
        self._poses, self._velocities = poses.copy(), velocities.copy()

    def _changed(self, poses: np.ndarray, velocities: np.ndarray) -> dict[str, np.ndarray]:
        """Return (N,) bool for roles of channels, "rotate" for all of rotations: of which bodies the value changed."""
        turned = (poses[:, 3:] != self._poses[:, 3:]).any(axis=1)
        moved = turned | (poses[:, :3] != self._poses[:, :3]).any(axis=1)
        for row, ancestor, _, _ in self._nested:
            turned[row] |= turned[ancestor]
            moved[row] |= moved[ancestor]
        differs = velocities != self._velocities
        return {
            "rotate": turned,
            "translate": moved,
            "matrix": moved,
            VELOCITY: differs[:, :3].any(axis=1),
            ANGULAR_VELOCITY: differs[:, 3:].any(axis=1),
        }

    def _values(self, poses: np.ndarray, velocities: np.ndarray) -> dict[tuple[str, str], np.ndarray]:
        """Return for every channel its numbers for all bodies."""
        frames = pose_matrix(poses, self._meters_per_unit)
        self._follow_ancestors(frames)
        pose_matrices = self._left @ frames @ self._right
        rotation = pose_matrices[:, :3, :3] @ self._between_inverse
        rotation /= np.linalg.norm(rotation, axis=2, keepdims=True)
        roles = {
            VELOCITY: lambda: velocities[:, :3] / self._meters_per_unit,
            ANGULAR_VELOCITY: lambda: np.degrees(velocities[:, 3:]),
            "translate": lambda: pose_matrices[:, 3, :3] - self._between[:, 3, :3],
            "matrix": lambda: pose_matrices,
            "quat": lambda: quat_from_matrix(rotation),
        }
        return {
            (role, kind): roles[role]() if role in roles else _euler(rotation, role) for role, kind in self._channels
        }

    def _follow_ancestors(self, frames: np.ndarray) -> None:
        """Recompute `right` of the bodies below another body, which has moved their parent."""
        for row, ancestor, parent_from_ancestor, before_inverse in self._nested:
            parent = parent_from_ancestor @ self._body_from_prim[ancestor] @ frames[ancestor]
            self._right[row] = np.linalg.inv(parent) @ before_inverse

    def _add(self, row: int, body: Body, cache: UsdGeom.XformCache) -> None:
        if body.kinematic or split_instance(body.path):
            return
        prim = self._stage.GetPrimAtPath(body.path)
        if abs(np.linalg.det(self._body_from_prim[row])) < 1e-30:
            warn_once(f"{body.path} has a scale of zero, so its pose cannot be written; give it a scale above zero.")
            return
        self._remember_op_order(prim)
        ops = choose_pose_ops(prim)
        before_inverse = np.linalg.inv(ops.before)
        self._left[row] = np.linalg.inv(ops.after) @ self._body_from_prim[row]
        parent_to_world = np.array(cache.GetParentToWorldTransform(prim))
        if UsdGeom.Xformable(prim).GetResetXformStack():
            parent_to_world = np.eye(4)
        elif (ancestor := self._ancestor_body(prim)) is not None:
            ancestor_prim = self._stage.GetPrimAtPath(list(self._rows)[ancestor])
            relative = np.array(cache.ComputeRelativeTransform(prim.GetParent(), ancestor_prim)[0])
            self._nested.append((row, ancestor, relative, before_inverse))
        warn_if_deformed(prim, ops.between @ ops.before @ parent_to_world)
        self._right[row] = np.linalg.inv(parent_to_world) @ before_inverse
        self._between[row] = ops.between
        self._written_ops[body.path] = {ops.translate, *ops.rotate}
        self._open_channels(row, prim, ops)

    def _ancestor_body(self, prim: Usd.Prim) -> int | None:
        """Return the row of the nearest rigid body above a prim."""
        parent = prim.GetParent()
        while parent and not parent.IsPseudoRoot():
            if str(parent.GetPath()) in self._rows:
                return self._rows[str(parent.GetPath())]
            parent = parent.GetParent()
        return None

    def _remember_op_order(self, prim: Usd.Prim) -> None:
        path = self._target.MapToSpecPath(prim.GetPath())
        for name in ("xformOpOrder", "xformOp:translate", "xformOp:orient"):
            self._backup.keep(self._target.GetLayer(), path.AppendProperty(name))

    def _open_channels(self, row: int, prim: Usd.Prim, ops: PoseOps) -> None:
        if ops.order == "matrix":
            self._open(row, prim, ops.translate, "matrix")
        else:
            self._open(row, prim, ops.translate, "translate")
            if len(ops.rotate) == 1:
                self._open(row, prim, ops.rotate[0], ops.order)
            else:
                for axis, name in zip("XYZ", ops.rotate):
                    self._open(row, prim, name, f"{ops.order}:{axis}")
        self._open(row, prim, VELOCITY, VELOCITY)
        self._open(row, prim, ANGULAR_VELOCITY, ANGULAR_VELOCITY)

    def _open(self, row: int, prim: Usd.Prim, name: str, role: str) -> None:
        attribute = prim.GetAttribute(name)
        self._backup.keep(self._target.GetLayer(), self._target.MapToSpecPath(attribute.GetPath()))
        channel = self._channels[role, str(attribute.GetTypeName())]
        spec = attribute_spec(self._target, attribute)
        if not self._is_strongest:
            warn_if_overridden(attribute, spec)
        channel.rows.append(row)
        channel.specs.append(spec)
        self._specs[str(prim.GetPath())].append(spec)


def _euler(rotation: np.ndarray, role: str) -> np.ndarray:
    """Return angles [degrees] for a role such as "XYZ", or "XYZ:Y" for one of its axes."""
    order, _, axis = role.partition(":")
    angles = euler_from_matrix(rotation, order)
    return angles[:, "XYZ".index(axis)] if axis else angles


def _from_numpy(array: type, dtype: type) -> Callable[[np.ndarray], Iterable[object]]:
    return lambda numbers: array.FromNumpy(np.ascontiguousarray(numbers, dtype))


_TO_VALUES: dict[str, Callable[[np.ndarray], Iterable[object]]] = {
    "double3": _from_numpy(Vt.Vec3dArray, np.float64),
    "float3": _from_numpy(Vt.Vec3fArray, np.float32),
    "half3": _from_numpy(Vt.Vec3hArray, np.float16),
    "vector3f": _from_numpy(Vt.Vec3fArray, np.float32),
    "quatd": _from_numpy(Vt.QuatdArray, np.float64),
    "quatf": _from_numpy(Vt.QuatfArray, np.float32),
    "quath": _from_numpy(Vt.QuathArray, np.float16),
    "matrix4d": _from_numpy(Vt.Matrix4dArray, np.float64),
    "double": lambda numbers: numbers.tolist(),
    "float": lambda numbers: numbers.tolist(),
    "half": lambda numbers: numbers.tolist(),
}


def _write_channel(
    channel: _Channel, changed: np.ndarray, numbers: np.ndarray, to_values: Callable[[np.ndarray], Iterable[object]]
) -> None:
    rows, specs = channel.row_array, channel.specs
    mask = changed[rows]
    if not mask.all():
        if not mask.any():
            return
        rows, specs = rows[mask], list(compress(specs, mask))
    # Iterating a Vt array makes Gf values several times faster than Python constructors do.
    deque(map(_set_default, specs, to_values(numbers[rows])), maxlen=0)
