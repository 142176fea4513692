"""Write poses and velocities of bodies that PointInstancers draw to the instancers' arrays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from usdsdg.stage.physics.instances import split_instance
from usdsdg.stage.poses.rotations import quat_from_matrix
from usdsdg.stage.time_code import current_time, current_value
from usdsdg_physics.scene.records import Body
from usdsdg_physics.scene.rigid_frames import pose_matrix
from usdsdg_physics.writeback.freeze import freeze
from usdsdg_physics.writeback.restore import Backup, attribute_spec

POSES = frozenset({"positions", "orientations", "orientationsf"})
VELOCITIES = frozenset({"velocities", "angularVelocities"})


class InstancerWriter:
    """Writes the instances of all instancers with bodies; what stays constant is computed once.

    The matrix of an instance without its scale is `left @ frame @ right`, where `frame` is its rigid frame: `left` =
    (prototype's matrix · scale)⁻¹ · body_from_prim, `right` = instancer_to_world⁻¹.
    """

    def __init__(
        self,
        stage: Usd.Stage,
        bodies: Mapping[str, Body],
        backup: Backup,
        *,
        meters_per_unit: float,
        velocities: bool = True,
    ) -> None:
        """`velocities`: whether those are written where an instancer has them."""
        rows: dict[str, list[tuple[int, int, Body]]] = {}
        for row, body in enumerate(bodies.values()):
            found = split_instance(body.path)
            if found is not None and not body.kinematic:
                rows.setdefault(found[0], []).append((row, found[1], body))
        self._instancers = {
            path: _Instancer(stage, path, instances, backup, meters_per_unit, velocities)
            for path, instances in rows.items()
        }

    def write(self, poses: np.ndarray, velocities: np.ndarray) -> None:
        """Author poses (N, 7) and velocities (N, 6) [SI] of all bodies."""
        if self._instancers:
            with Sdf.ChangeBlock():
                for instancer in self._instancers.values():
                    instancer.write(poses, velocities)

    def moved(self, path: str) -> set[int]:
        """Return the indices of an instancer's instances whose poses are not those that were written or read last."""
        instancer = self._instancers.get(path)
        return instancer.moved() if instancer is not None else set()

    def kept(self, path: str) -> set[int]:
        """Return the indices of an instancer's instances that are still the same, whether moved or not.

        All are where there are as many as before, else those at an index at which the pose is the same.
        """
        instancer = self._instancers.get(path)
        return instancer.kept() if instancer is not None else set()


class _Instancer:
    def __init__(
        self,
        stage: Usd.Stage,
        path: str,
        instances: list[tuple[int, int, Body]],
        backup: Backup,
        meters: float,
        has_velocities: bool,
    ) -> None:
        self._meters = meters
        self._schema = UsdGeom.PointInstancer(stage.GetPrimAtPath(path))
        prim, target = self._schema.GetPrim(), stage.GetEditTarget()
        self._rows = np.array([row for row, _, _ in instances])
        self._indices = np.array([index for _, index, _ in instances])
        count = len(current_value(self._schema.GetProtoIndicesAttr()))
        constant = np.array([body.body_from_prim for _, _, body in instances]) / meters
        constant[:, 3, 3] = 1.0
        self._left = np.linalg.inv(self._unposed(stage)[self._indices]) @ constant
        self._right = np.linalg.inv(np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(current_time())))
        for name in (*POSES, *VELOCITIES, "accelerations"):
            freeze(prim.GetAttribute(name), target, backup)
        self._fine = bool(current_value(self._schema.GetOrientationsfAttr()))
        self._positions = np.array(current_value(self._schema.GetPositionsAttr()), np.float32).reshape(count, 3)
        self._orientations = self._read_orientations(count)
        self._moved: set[int] = set()  # by users, since poses were written
        names = ["positions", "orientationsf" if self._fine else "orientations"]
        if has_velocities:
            names += [name for name in ("velocities", "angularVelocities") if current_value(prim.GetAttribute(name))]
        self._specs = {}
        for name in names:
            attribute = prim.GetAttribute(name)
            backup.keep(target.GetLayer(), target.MapToSpecPath(attribute.GetPath()))
            self._specs[name] = attribute_spec(target, attribute)

    def write(self, poses: np.ndarray, velocities: np.ndarray) -> None:
        self._moved = set()
        frames = pose_matrix(poses[self._rows], self._meters)
        matrices = self._left @ frames @ self._right
        rotation = matrices[:, :3, :3] / np.linalg.norm(matrices[:, :3, :3], axis=2, keepdims=True)
        positions, orientations = self._positions.copy(), self._orientations.copy()
        positions[self._indices] = matrices[:, 3, :3]
        orientations[self._indices] = quat_from_matrix(rotation)
        if not np.array_equal(positions, self._positions) or not np.array_equal(orientations, self._orientations):
            self._specs["positions"].default = Vt.Vec3fArray.FromNumpy(positions)
            if self._fine:
                self._specs["orientationsf"].default = Vt.QuatfArray.FromNumpy(orientations)
            else:
                self._specs["orientations"].default = Vt.QuathArray.FromNumpy(orientations)
            self._positions, self._orientations = positions, orientations
        # Row vectors from the world to the instancer.
        axes = self._right[:3, :3]
        turn = axes / np.linalg.norm(axes, axis=1, keepdims=True)
        self._write_velocities("velocities", velocities[self._rows, :3] / self._meters @ axes)
        turn *= np.sign(np.linalg.det(turn))
        self._write_velocities("angularVelocities", np.degrees(velocities[self._rows, 3:]) @ turn)

    def moved(self) -> set[int]:
        positions, orientations = self._read_poses()
        if len(positions) != len(self._positions):
            return set(self._indices.tolist())
        differs = (positions != self._positions).any(axis=1) | (orientations != self._orientations).any(axis=1)
        self._positions, self._orientations = positions, orientations
        self._moved |= set(np.flatnonzero(differs).tolist())
        return self._moved

    def kept(self) -> set[int]:
        positions, orientations = self._read_poses()
        if len(positions) == len(self._positions):
            return set(range(len(positions)))
        count = min(len(positions), len(self._positions))
        same = (positions[:count] == self._positions[:count]).all(axis=1)
        return set(np.flatnonzero(same & (orientations[:count] == self._orientations[:count]).all(axis=1)).tolist())

    def _read_poses(self) -> tuple[np.ndarray, np.ndarray]:
        positions = np.array(current_value(self._schema.GetPositionsAttr()) or (), np.float32).reshape(-1, 3)
        return positions, self._read_orientations(len(positions))

    def _write_velocities(self, name: str, values: np.ndarray) -> None:
        if name in self._specs:
            attribute = self._schema.GetPrim().GetAttribute(name)
            numbers = np.array(self._specs[name].default or current_value(attribute), np.float32)
            numbers[self._indices] = values
            self._specs[name].default = Vt.Vec3fArray.FromNumpy(numbers)

    def _read_orientations(self, count: int) -> np.ndarray:
        """Return the orientations (n, 4) as x, y, z, w, in the precision of the attribute."""
        attribute = self._schema.GetOrientationsfAttr() if self._fine else self._schema.GetOrientationsAttr()
        quats = current_value(attribute)
        dtype = np.float32 if self._fine else np.float16
        if not quats or len(quats) != count:
            return np.tile(np.array([0, 0, 0, 1], dtype), (count, 1))
        return np.array([(*quat.GetImaginary(), quat.GetReal()) for quat in quats], dtype)

    def _unposed(self, stage: Usd.Stage) -> np.ndarray:
        """Return the matrix (n, 4, 4) of each instance without its position and orientation."""
        time = current_time()
        prototypes = [
            np.array(UsdGeom.Xformable(stage.GetPrimAtPath(path)).GetLocalTransformation(time))
            for path in self._schema.GetPrototypesRel().GetForwardedTargets()
        ]
        indices = list(current_value(self._schema.GetProtoIndicesAttr()))
        scales = current_value(self._schema.GetScalesAttr()) or [(1.0, 1.0, 1.0)] * len(indices)
        return np.array([prototypes[kind] @ np.diag([*scale, 1.0]) for kind, scale in zip(indices, scales)])
