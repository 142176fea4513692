"""Joint positions, velocities, drives and limits of articulations, as arrays with one row per robot.

Angles are in rad, distances in stage units; stiffness and damping per rad or stage unit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdsdg.articulations.articulation import Articulation, limits_of, read_drive
from usdsdg.articulations.articulations import get_articulations
from usdsdg.articulations.joint_tree import drive_of
from usdsdg.errors import BadValue
from usdsdg.session.stage_context import current_stage

WHY = (
    "joints follow the positions, velocities and drive targets that are set; forces, masses and contacts of joints are "
    "not simulated"
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
        for row, value in zip(rows, values, strict=True):
            for column, number in zip(columns, value.tolist(), strict=True):
                joint = self.robots[row].dofs[column]
                drive = drive_of(current_stage(), joint)
                if not drive:
                    raise BadValue(f"{joint.path} has no drive, so it has no target; set its position")
                drive.CreateTargetPositionAttr().Set(number / joint.unit)

    def _drives(self, name: str) -> np.ndarray:
        stage = current_stage()
        return np.array(
            [[getattr(read_drive(stage, joint), name) for joint in robot.dofs] for robot in self.robots], np.float32
        )
