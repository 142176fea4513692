"""`ArticulationDrives`: gains, control modes and actions of several robots, which `Articulation` has."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from usdsdg.compat.isaacsim.core.prims.articulation_joints import ArticulationJoints
from usdsdg.compat.isaacsim.core.utils.types import ArticulationActions
from usdsdg.compat.wrappers.arrays import chosen, grid
from usdsdg.errors import warn_once

if TYPE_CHECKING:
    from usdsdg.compat.isaacsim.core.prims.articulation_joints import Names
    from usdsdg.compat.wrappers.arrays import Indices, Values


class ArticulationDrives(ArticulationJoints):
    """The drives that move joints to targets. What is set is authored on the stage, where joints get drives."""

    _paused: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    # --- gains and control modes ---
    def set_gains(
        self,
        kps: Values | None = None,
        kds: Values | None = None,
        indices: Indices = None,
        joint_indices: Indices = None,
        joint_names: Names = None,
        save_to_usd: bool = False,
    ) -> None:
        """Set stiffness and damping (N, D) of the drives: until physics stops where it plays, unless `save_to_usd`."""
        where, which = chosen(indices, self.count), self._columns(joint_indices, joint_names)
        stiffness, damping = (None if each is None else grid(each, (len(where), len(which))) for each in (kps, kds))
        self._drives.set_gains(where, which, stiffness, damping, on_stage=save_to_usd)

    def get_gains(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None, clone: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return stiffness and damping (N, D) of the drives."""
        stiffness, damping = (self._part(each, indices, joint_indices, joint_names) for each in self._drives.gains())
        return stiffness, damping

    def switch_control_mode(
        self, mode: str, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None
    ) -> None:
        """Set the gains of "position" (those of `set_gains`), "velocity" (no stiffness) or "effort" (none) control.

        Raises:
            ValueError: there is no such mode.
        """
        which = self._columns(joint_indices, joint_names)
        self._drives.switch_mode(mode, chosen(indices, self.count), which)

    def switch_dof_control_mode(self, mode: str, dof_index: int, indices: Indices = None) -> None:
        """Do what `switch_control_mode` does for one joint."""
        self.switch_control_mode(mode, indices, [dof_index])

    def set_max_efforts(
        self, values: Values, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None
    ) -> None:
        """Set the largest torques, and forces of prismatic joints, (N, D) of the drives."""
        self._set(self._drives.set_max_efforts, values, indices, joint_indices, joint_names)

    def get_max_efforts(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None, clone: bool = True
    ) -> np.ndarray:
        """Return the largest torques, and forces of prismatic joints, (N, D) of the drives."""
        return self._part(self._drives.max_efforts(), indices, joint_indices, joint_names)

    def set_effort_modes(
        self, mode: str, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None
    ) -> None:
        """Let gains mean forces ("force"), or forces per mass ("acceleration").

        Raises:
            ValueError: there is no such mode.
        """
        where, which = chosen(indices, self.count), self._columns(joint_indices, joint_names)
        self._drives.set_types(where, which, np.full((len(where), len(which)), mode, object))

    def get_effort_modes(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None
    ) -> list[list[str]]:
        """Return "force" or "acceleration" of each joint (N, D); "acceleration" without a drive."""
        types, which = self._drives.types(), self._columns(joint_indices, joint_names)
        return [[types[row][column] for column in which] for row in chosen(indices, self.count)]

    def get_drive_types(self) -> np.ndarray:
        """Return (N, D): 0 without a drive, 1 for "force", 2 for "acceleration"."""
        return self._out(self._drives.numbered_types())[0]

    # --- actions ---
    def apply_action(self, control_actions: ArticulationActions, indices: Indices = None) -> None:
        """Set targets and efforts (N, K).

        Raises:
            PhysicsError: efforts are given, and physics does not play.
        """
        columns, names = control_actions.joint_indices, control_actions.joint_names
        self.set_joint_position_targets(control_actions.joint_positions, indices, columns, names)
        self.set_joint_velocity_targets(control_actions.joint_velocities, indices, columns, names)
        self.set_joint_efforts(control_actions.joint_efforts, indices, columns, names)

    def get_applied_actions(self, clone: bool = True) -> ArticulationActions:
        """Return the targets of the drives, and the efforts that were set last (N, D)."""
        positions, velocities = self._out(self._drives.targets(), self._drives.velocity_targets())
        return ArticulationActions(positions, velocities, self.get_applied_joint_efforts())

    def pause_motion(self) -> None:
        """Stop joints and let drives hold them where they are, until `resume_motion`."""
        positions, where = self._joints.positions(), range(self.count)
        self._paused = self._drives.targets(), self._drives.velocity_targets(), self._joints.velocities()
        still, which = np.zeros_like(positions), range(self.num_dof)
        self._joints.set_velocities(where, which, still)
        self._drives.set_targets(where, which, positions)
        self._drives.set_velocity_targets(where, which, still)

    def resume_motion(self) -> None:
        """Give back what `pause_motion` took."""
        if self._paused is None:
            warn_once(f"{self.name}: resume_motion does nothing before pause_motion")
            return
        where, which = range(self.count), range(self.num_dof)
        self._drives.set_targets(where, which, self._paused[0])
        self._drives.set_velocity_targets(where, which, self._paused[1])
        self._joints.set_velocities(where, which, self._paused[2])
        self._paused = None
