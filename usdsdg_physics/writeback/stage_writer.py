"""Write poses and velocities to the xform ops and velocity attributes that the prims have."""

from collections import defaultdict, deque
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import compress

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from usdsdg.errors import PhysicsError, warn_once
from usdsdg.stage.changes import Changes
from usdsdg.stage.physics.instances import split_instance
from usdsdg.stage.poses.rotations import euler_from_matrix, quat_from_matrix
from usdsdg.stage.time_code import current_time
from usdsdg_physics.scene.prim_paths import paths_below
from usdsdg_physics.scene.records import Body
from usdsdg_physics.writeback.freeze import freeze
from usdsdg_physics.writeback.moved_parents import MovedParents
from usdsdg_physics.writeback.pose_matrices import PoseMatrices
from usdsdg_physics.writeback.pose_ops import ADDED_OPS, PoseOps, choose_pose_ops
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
    """Writes bodies into one edit target; what stays constant while they move is computed once, when it is made."""

    def __init__(
        self,
        stage: Usd.Stage,
        bodies: Mapping[str, Body],
        backup: Backup,
        *,
        meters_per_unit: float,
        velocities: bool = True,
        animated: Collection[str] = (),
    ) -> None:
        """Open the attributes of the bodies that are written.

        These are the dynamic bodies, and the kinematic ones below such a body, which it would take along.

        Args:
            velocities: whether those of dynamic bodies are written, too.
            animated: bodies that follow time samples, which are not written.
        """
        self._stage = stage
        self._has_velocities = velocities
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
        self._opened: list[tuple[int, Usd.Attribute, str]] = []  # rows of bodies, attributes and their roles
        constants = np.array([body.body_from_prim for body in bodies.values()]).reshape(-1, 4, 4)
        self._matrices = PoseMatrices(constants, meters_per_unit)
        self._moved_parents = MovedParents(stage)
        is_flat, written = self._matrices.is_flat, []
        for row, path in enumerate(bodies):
            if path in animated or split_instance(path):
                continue
            if bodies[path].kinematic and not self._is_below_dynamic(path, bodies):
                continue
            if is_flat[row]:
                warn_once(f"{path} has a scale of zero, so its pose cannot be written; give it a scale above zero.")
                continue
            written.append((row, stage.GetPrimAtPath(path)))
        for _, prim in written:
            self._freeze(prim)
        cache = UsdGeom.XformCache(current_time())
        for row, prim in written:
            self._add(row, prim, cache, is_kinematic=bodies[str(prim.GetPath())].kinematic)
        self._make_specs()
        self._matrices.finish()
        warn_if_deformed(list(compress(bodies, self._matrices.deforms)))
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
        if not self._sorted:
            return False  # there is no body to write
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
        changed = self._changed(poses, velocities, self._moved_parents.update(self._matrices))
        values = self._values(poses, velocities)
        with Sdf.ChangeBlock():
            for (role, kind), channel in self._channels.items():
                _write_channel(channel, changed.get(role, changed["rotate"]), values[role, kind], _TO_VALUES[kind])
        self._poses, self._velocities = poses.copy(), velocities.copy()

    def stop(self, paths: Iterable[str]) -> None:
        """Write that bodies which are not moved any more, where they are still on the stage, have no velocity."""
        prims = (self._stage.GetPrimAtPath(path) for path in paths if self._has_velocities and not split_instance(path))
        for prim in filter(None, prims):
            for name in (VELOCITY, ANGULAR_VELOCITY):
                attribute = prim.GetAttribute(name)
                if attribute and any(attribute.Get() or ()):
                    self._keep(prim, name)
                    attribute_spec(self._target, attribute).default = Gf.Vec3f(0.0)

    def _changed(self, poses: np.ndarray, velocities: np.ndarray, moved_parents: list[int]) -> dict[str, np.ndarray]:
        """Return (N,) bool for roles of channels, "rotate" for all of rotations: of which bodies the value changed."""
        turned = (poses[:, 3:] != self._poses[:, 3:]).any(axis=1)
        turned[moved_parents] = True
        moved = turned | (poses[:, :3] != self._poses[:, :3]).any(axis=1)
        self._matrices.follow_ancestors(turned)
        self._matrices.follow_ancestors(moved)
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
        matrices, rotations = self._matrices.of_poses(poses)
        roles = {
            VELOCITY: lambda: velocities[:, :3] / self._meters_per_unit,
            ANGULAR_VELOCITY: lambda: np.degrees(velocities[:, 3:]),
            "translate": lambda: self._matrices.translations(matrices, rotations),
            "matrix": lambda: matrices,
            "quat": lambda: quat_from_matrix(rotations),
        }
        return {
            (role, kind): roles[role]() if role in roles else _euler(rotations, role) for role, kind in self._channels
        }

    def _freeze(self, prim: Usd.Prim) -> None:
        """Let samples of what is written not be drawn in its place."""
        attributes = [op.GetAttr() for op in UsdGeom.Xformable(prim).GetOrderedXformOps()]
        if self._has_velocities:
            attributes += [prim.GetAttribute(name) for name in (VELOCITY, ANGULAR_VELOCITY)]
        for attribute in attributes:
            freeze(attribute, self._target, self._backup)

    def _add(self, row: int, prim: Usd.Prim, cache: UsdGeom.XformCache, *, is_kinematic: bool) -> None:
        path = str(prim.GetPath())
        for name in ("xformOpOrder", *ADDED_OPS):
            self._keep(prim, name)
        ops = choose_pose_ops(prim)
        parent_to_world = np.array(cache.GetParentToWorldTransform(prim))
        if UsdGeom.Xformable(prim).GetResetXformStack():
            parent_to_world = np.eye(4)
        else:
            ancestor = self._ancestor_body(path)
            if ancestor is not None:
                relative, resets = cache.ComputeRelativeTransform(prim.GetParent(), self._stage.GetPrimAtPath(ancestor))
                if resets:  # the parent does not follow the body, then
                    ancestor = None
                else:
                    self._matrices.set_ancestor(row, self._rows[ancestor], np.array(relative))
            self._moved_parents.add(row, prim, ancestor)
        self._matrices.set(row, ops, parent_to_world)
        self._written_ops[path] = {ops.translate, *ops.rotate}
        self._open_channels(row, prim, ops, is_kinematic=is_kinematic)

    def _is_below_dynamic(self, path: str, bodies: Mapping[str, Body]) -> bool:
        while path := self._ancestor_body(path) or "":
            if not bodies[path].kinematic:
                return True
        return False

    def _ancestor_body(self, path: str) -> str | None:
        """Return the path of the nearest rigid body above another."""
        while path := path.rpartition("/")[0]:
            if path in self._rows:
                return path
        return None

    def _open_channels(self, row: int, prim: Usd.Prim, ops: PoseOps, *, is_kinematic: bool) -> None:
        if ops.order == "matrix":
            self._open(row, prim, ops.translate, "matrix")
        else:
            self._open(row, prim, ops.translate, "translate")
            if len(ops.rotate) == 1:
                self._open(row, prim, ops.rotate[0], ops.order)
            else:
                for axis, name in zip("XYZ", ops.rotate):
                    self._open(row, prim, name, f"{ops.order}:{axis}")
        for name in (VELOCITY, ANGULAR_VELOCITY):
            if self._has_velocities and not is_kinematic:
                self._open(row, prim, name, name)
            else:  # what a user sets while the scene plays is undone with the rest
                self._keep(prim, name)

    def _keep(self, prim: Usd.Prim, name: str) -> None:
        self._backup.keep(self._target.GetLayer(), self._target.MapToSpecPath(prim.GetPath().AppendProperty(name)))

    def _open(self, row: int, prim: Usd.Prim, name: str, role: str) -> None:
        self._keep(prim, name)
        self._opened.append((row, prim.GetAttribute(name), role))

    def _make_specs(self) -> None:
        """Find the specs of all attributes that were opened, and make those that are missing with one notice."""
        types = [attribute.GetTypeName().cppTypeName for _, attribute, _ in self._opened]
        with Sdf.ChangeBlock():
            specs = [attribute_spec(self._target, attribute) for _, attribute, _ in self._opened]
        for (row, attribute, role), kind, spec in zip(self._opened, types, specs):
            if not self._is_strongest:
                warn_if_overridden(attribute, spec)
            channel = self._channels[role, kind]
            channel.rows.append(row)
            channel.specs.append(spec)
            self._specs[str(attribute.GetPrimPath())].append(spec)


def _euler(rotation: np.ndarray, role: str) -> np.ndarray:
    """Return angles [degrees] for a role such as "XYZ", or "XYZ:Y" for one of its axes."""
    order, _, axis = role.partition(":")
    angles = euler_from_matrix(rotation, order)
    return angles[:, "XYZ".index(axis)] if axis else angles


def _from_numpy(array: type, dtype: type) -> Callable[[np.ndarray], Iterable[object]]:
    return lambda numbers: array.FromNumpy(np.ascontiguousarray(numbers, dtype))


# By the type of a value in C++, which those of roles share.
_TO_VALUES: dict[str, Callable[[np.ndarray], Iterable[object]]] = {
    "GfVec3d": _from_numpy(Vt.Vec3dArray, np.float64),
    "GfVec3f": _from_numpy(Vt.Vec3fArray, np.float32),
    "GfVec3h": _from_numpy(Vt.Vec3hArray, np.float16),
    "GfQuatd": _from_numpy(Vt.QuatdArray, np.float64),
    "GfQuatf": _from_numpy(Vt.QuatfArray, np.float32),
    "GfQuath": _from_numpy(Vt.QuathArray, np.float16),
    "GfMatrix4d": _from_numpy(Vt.Matrix4dArray, np.float64),
    "double": lambda numbers: numbers.tolist(),
    "float": lambda numbers: numbers.tolist(),
    "GfHalf": lambda numbers: numbers.tolist(),
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
