"""Drives of the joints of articulations, as arrays with one row per robot.

Targets are in rad and stage units; stiffness and damping per rad or stage unit. What is set while physics plays acts
until it stops, as in PhysX, which puts back what the stage had.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import UsdPhysics

from usdsdg.articulations.articulation import read_drive
from usdsdg.articulations.joint_tree import drive_of
from usdsdg.compat.used_stage import current_stage
from usdsdg.compat.wrappers.joints.rows import JointRows
from usdsdg.compat.wrappers.runtime_values import keep_joint_until_stop
from usdsdg.errors import warn_once
from usdsdg.stage.physics.joints import Joint

_MODES = ("position", "velocity", "effort")


class JointDrives:
    """Reads and sets the drives of joints. Gains give a joint a drive; its targets wait until then."""

    def __init__(self, joints: JointRows) -> None:
        self._joints = joints
        self._waiting: dict[tuple[str, str], float] = {}  # targets of joints without a drive
        self._usual: tuple[np.ndarray, np.ndarray] | None = None

    # --- targets ---
    def targets(self) -> np.ndarray:
        """Return target positions (N, D) float32."""
        return self._targets("target", "TargetPosition")

    def velocity_targets(self) -> np.ndarray:
        """Return target velocities (N, D) float32."""
        return self._targets("target_velocity", "TargetVelocity")

    def set_targets(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set target positions (n, d)."""
        self._set_targets("TargetPosition", rows, columns, values)

    def set_velocity_targets(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set target velocities (n, d)."""
        self._set_targets("TargetVelocity", rows, columns, values)

    # --- gains ---
    def gains(self) -> tuple[np.ndarray, np.ndarray]:
        """Return stiffness and damping (N, D) float32."""
        return self._read("stiffness"), self._read("damping")

    def usual_gains(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the stiffness and damping (N, D) that `switch_mode` returns to: the first, or those set."""
        if self._usual is None:
            self._usual = self.gains()
        return self._usual

    def set_gains(
        self,
        rows: Sequence[int],
        columns: Sequence[int],
        stiffness: np.ndarray | None,
        damping: np.ndarray | None,
        *,
        usual: bool = True,
        on_stage: bool = False,
    ) -> None:
        """Set stiffness and damping (n, d); None keeps them.

        usual: let `switch_mode` return to them. on_stage: they stay after physics has stopped.
        """
        for number, values in enumerate((stiffness, damping)):
            if values is None:
                continue
            table, name = self.usual_gains()[number], "Damping" if number else "Stiffness"
            for row, column, joint, value in self._joints.chosen(rows, columns, values):
                self._set(self._drive(joint), joint, name, value * joint.unit, on_stage=on_stage)
                if usual:
                    table[row, column] = value

    def restore_gains(self) -> None:
        """Give drives their usual gains again, where they have others."""
        now, usual = self.gains(), self.usual_gains()
        if not all(map(np.array_equal, now, usual)):
            self.set_gains(range(len(usual[0])), range(usual[0].shape[1]), *usual, usual=False)

    def switch_mode(self, mode: str, rows: Sequence[int], columns: Sequence[int]) -> None:
        """Let drives pull to positions, or to velocities (no stiffness), or not at all ("effort").

        Raises:
            ValueError: there is no such mode.
        """
        if mode not in _MODES:
            raise ValueError(f"there is no control mode {mode!r}; give one of {', '.join(_MODES)}")
        stiffness, damping = (table[np.ix_(rows, columns)] for table in self.usual_gains())
        stiffness = stiffness if mode == "position" else np.zeros_like(stiffness)
        damping = np.zeros_like(damping) if mode == "effort" else damping
        self.set_gains(rows, columns, stiffness, damping, usual=False)

    # --- limits and types ---
    def max_efforts(self) -> np.ndarray:
        """Return the largest torques and forces (N, D) float32."""
        return self._read("max_force")

    def set_max_efforts(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set the largest torques and forces (n, d)."""
        for _, _, joint, number in self._joints.chosen(rows, columns, values):
            self._set(self._drive(joint), joint, "MaxForce", number)

    def types(self) -> list[list[str]]:
        """Return "force" or "acceleration" of each joint (N, D); "acceleration" without a drive."""
        return [[self._type(joint) for joint in robot.dofs] for robot in self._joints.robots]

    def numbered_types(self) -> np.ndarray:
        """Return (N, D) uint8: 0 without a drive, 1 for "force", 2 for "acceleration"."""
        stage = current_stage()

        def number(joint: Joint) -> int:
            return 0 if not drive_of(stage, joint) else 1 if self._type(joint) == "force" else 2

        return self._joints.of_joints(number).astype(np.uint8)

    def set_types(self, rows: Sequence[int], columns: Sequence[int], kinds: np.ndarray) -> None:
        """Set "force" or "acceleration" (n, d).

        Raises:
            ValueError: there is no such type.
        """
        for _, _, joint, kind in self._joints.chosen(rows, columns, kinds):
            if kind not in ("force", "acceleration"):
                raise ValueError(f"{joint.path}: a drive is of the type 'force' or 'acceleration', not {kind!r}")
            self._drive(joint).CreateTypeAttr().Set(kind)

    def _type(self, joint: Joint) -> str:
        drive = drive_of(current_stage(), joint)
        return str(drive.GetTypeAttr().Get()) if drive else "acceleration"

    def _read(self, name: str) -> np.ndarray:
        stage = current_stage()
        return self._joints.of_joints(lambda joint: getattr(read_drive(stage, joint), name))

    def _targets(self, name: str, attribute: str) -> np.ndarray:
        stage = current_stage()

        def read(joint: Joint) -> float:
            waiting = self._waiting.get((joint.path, attribute))
            return getattr(read_drive(stage, joint), name) if waiting is None else waiting

        return self._joints.of_joints(read)

    def _set_targets(self, name: str, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        for _, _, joint, number in self._joints.chosen(rows, columns, values):
            drive = drive_of(current_stage(), joint)
            if drive:
                self._set(drive, joint, name, number / joint.unit)
                continue
            self._waiting[joint.path, name] = number
            if number:
                warn_once(f"{joint.path} has no drive, so its targets have no effect until set_gains gives it one")

    def _drive(self, joint: Joint) -> UsdPhysics.DriveAPI:
        """Return the drive of a joint, which gets one, and the targets that wait for it, if it has none."""
        stage = current_stage()
        drive = drive_of(stage, joint)
        if not drive:
            drive = UsdPhysics.DriveAPI.Apply(stage.GetPrimAtPath(joint.path), joint.drive)
        for name in ("TargetPosition", "TargetVelocity"):
            waiting = self._waiting.pop((joint.path, name), None)
            if waiting is not None:
                self._set(drive, joint, name, waiting / joint.unit)
        return drive

    def _set(
        self, drive: UsdPhysics.DriveAPI, joint: Joint, name: str, value: float, *, on_stage: bool = False
    ) -> None:
        """Set an attribute of a drive, such as "MaxForce"."""
        if not on_stage:
            attribute = f"drive:{joint.drive}:physics:{name[0].lower()}{name[1:]}"
            keep_joint_until_stop(drive.GetPrim(), attribute)
        getattr(drive, f"Create{name}Attr")().Set(value)
