"""Joint positions, velocities, drives and limits of articulations, as arrays with one row per robot.

Angles are in rad, distances in stage units; stiffness and damping per rad or stage unit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from pxr import UsdPhysics

from usdsdg.articulations.articulation import Articulation, limits_of, read_drive
from usdsdg.articulations.articulations import get_articulations
from usdsdg.articulations.joint_tree import drive_of
from usdsdg.errors import BadValue
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.physics.joints import Joint

WHY = (
    "of the joints of an articulation there are positions, velocities, limits, drives and efforts that push them; set "
    "what else there is on the prims of its joints and links"
)


class JointRows:
    """The articulations at some paths, which have the same joints."""

    def __init__(self, paths: Sequence[str]) -> None:
        """Take the robots at `paths`.

        Raises:
            BadPrim: one has no joint between two bodies.
            BadValue: they have different numbers of joints.
        """
        self.robots: list[Articulation] = [get_articulations().at(path) for path in paths]
        counts = {len(robot.dofs) for robot in self.robots}
        if len(counts) > 1:
            raise BadValue(f"{', '.join(paths)}: these articulations have {sorted(counts)} joints; wrap them apart")

    @property
    def names(self) -> list[str]:
        """The names of the joints that have a position, in order."""
        return [joint.path.rsplit("/", 1)[1] for joint in self.robots[0].dofs]

    def positions(self) -> np.ndarray:
        """Return (N, D) float32."""
        return np.array([robot.positions for robot in self.robots], np.float32)

    def velocities(self) -> np.ndarray:
        """Return (N, D) float32."""
        return np.array([robot.velocities for robot in self.robots], np.float32)

    def targets(self) -> np.ndarray:
        """Return the drives' target positions (N, D) float32."""
        return self._drives("target")

    def gains(self) -> tuple[np.ndarray, np.ndarray]:
        """Return stiffness and damping (N, D) float32 of the drives."""
        return self._drives("stiffness"), self._drives("damping")

    def velocity_targets(self) -> np.ndarray:
        """Return the drives' target velocities (N, D) float32."""
        return self._drives("target_velocity")

    def max_efforts(self) -> np.ndarray:
        """Return the largest torques and forces (N, D) float32 of the drives."""
        return self._drives("max_force")

    def limits(self) -> np.ndarray:
        """Return lower and upper limits (N, D, 2) float32."""
        stage = current_stage()
        return np.array([[limits_of(stage, joint) for joint in robot.dofs] for robot in self.robots], np.float32)

    def set_positions(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Move joints at once: values (n, d)."""
        for row, value in zip(rows, values, strict=True):
            positions = self.robots[row].positions.copy()
            positions[list(columns)] = value
            self.robots[row].set_positions(positions)

    def set_velocities(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set velocities (n, d)."""
        for row, value in zip(rows, values, strict=True):
            velocities = self.robots[row].velocities.copy()
            velocities[list(columns)] = value
            self.robots[row].set_velocities(velocities)

    def set_targets(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set the target positions (n, d) of the drives, which joints without a drive do not have."""
        for joint, drive, number in self._driven(rows, columns, values):
            drive.CreateTargetPositionAttr().Set(number / joint.unit)

    def set_velocity_targets(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set the target velocities (n, d) of the drives."""
        for joint, drive, number in self._driven(rows, columns, values):
            drive.CreateTargetVelocityAttr().Set(number / joint.unit)

    def set_stiffness(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set the stiffness (n, d) of the drives."""
        for joint, drive, number in self._driven(rows, columns, values):
            drive.CreateStiffnessAttr().Set(number * joint.unit)

    def set_damping(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set the damping (n, d) of the drives."""
        for joint, drive, number in self._driven(rows, columns, values):
            drive.CreateDampingAttr().Set(number * joint.unit)

    def set_max_efforts(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set the largest torques and forces (n, d) of the drives."""
        for _, drive, number in self._driven(rows, columns, values):
            drive.CreateMaxForceAttr().Set(number)

    def apply_efforts(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Push joints during the next physics step with torques and forces (n, d)."""
        for row, value in zip(rows, values, strict=True):
            efforts = np.zeros(len(self.robots[row].dofs))
            efforts[list(columns)] = value
            self.robots[row].apply_efforts(efforts)

    def _driven(
        self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray
    ) -> Iterator[tuple[Joint, UsdPhysics.DriveAPI, float]]:
        for row, value in zip(rows, values, strict=True):
            for column, number in zip(columns, value.tolist(), strict=True):
                joint = self.robots[row].dofs[column]
                drive = drive_of(current_stage(), joint)
                if not drive:
                    raise BadValue(f"{joint.path} has no drive, so it has no target; set its position")
                yield joint, drive, number

    def _drives(self, name: str) -> np.ndarray:
        stage = current_stage()
        return np.array(
            [[getattr(read_drive(stage, joint), name) for joint in robot.dofs] for robot in self.robots], np.float32
        )
