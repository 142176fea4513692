"""`ArticulationDrives`: targets, gains and control modes of robots, which `Articulation` has."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.compat.isaacsim.core.experimental.prims.articulation_joints import ArticulationJoints
from usdsdg.compat.wrappers.arrays import chosen

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values


class ArticulationDrives(ArticulationJoints):
    """The drives that move joints to targets. What is set is authored on the stage, where joints get drives."""

    # --- targets ---
    def get_dof_position_targets(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return the targets (N, D) of the drives."""
        return self._part(self._drives.targets(), indices, dof_indices)

    def set_dof_position_targets(
        self, positions: Values, *, indices: Indices = None, dof_indices: Indices = None
    ) -> None:
        """Set the targets (N, D) that drives move their joints to; they have no effect on joints without a drive."""
        self._set(self._drives.set_targets, positions, indices, dof_indices)

    def get_dof_velocity_targets(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return the target velocities (N, D) of the drives."""
        return self._part(self._drives.velocity_targets(), indices, dof_indices)

    def set_dof_velocity_targets(
        self, velocities: Values, *, indices: Indices = None, dof_indices: Indices = None
    ) -> None:
        """Set the velocities (N, D) that drives give their joints; see `set_dof_position_targets`."""
        self._set(self._drives.set_velocity_targets, velocities, indices, dof_indices)

    # --- gains and control modes ---
    def set_dof_gains(
        self,
        stiffnesses: Values | None = None,
        dampings: Values | None = None,
        *,
        indices: Indices = None,
        dof_indices: Indices = None,
        update_default_gains: bool = True,
    ) -> None:
        """Set stiffness and damping (N, D) of the drives.

        Args:
            update_default_gains: Whether `switch_dof_control_mode` returns to them.

        Raises:
            AssertionError: neither is given.
        """
        if stiffnesses is None and dampings is None:
            raise AssertionError("give stiffnesses or dampings")
        where, columns, (stiff, damped) = self._given((stiffnesses, dampings), indices, dof_indices)
        self._drives.set_gains(where, columns, stiff, damped, usual=update_default_gains)

    def get_dof_gains(self, *, indices: Indices = None, dof_indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return stiffness and damping (N, D) of the drives."""
        stiffness, damping = self._drives.gains()
        return self._part(stiffness, indices, dof_indices), self._part(damping, indices, dof_indices)

    def switch_dof_control_mode(self, mode: str, *, indices: Indices = None, dof_indices: Indices = None) -> None:
        """Set the gains of "position" (those of `set_dof_gains`), "velocity" (no stiffness) or "effort" (none) control.

        Raises:
            ValueError: there is no such mode.
        """
        self._drives.switch_mode(mode, chosen(indices, len(self)), chosen(dof_indices, self.num_dofs))

    # --- types and limits ---
    def get_dof_drive_types(self, *, indices: Indices = None, dof_indices: Indices = None) -> list[list[str]]:
        """Return "force" or "acceleration" of each joint (N, D); "acceleration" without a drive."""
        types, columns = self._drives.types(), chosen(dof_indices, self.num_dofs)
        return [[types[row][column] for column in columns] for row in chosen(indices, len(self))]

    def set_dof_drive_types(
        self, types: str | Sequence[Sequence[str]], *, indices: Indices = None, dof_indices: Indices = None
    ) -> None:
        """Let gains mean forces ("force"), or forces per mass ("acceleration"): one for all, or (N, D).

        Raises:
            ValueError: there is no such type.
        """
        where, columns = chosen(indices, len(self)), chosen(dof_indices, self.num_dofs)
        kinds = np.broadcast_to(np.array(types, object), (len(where), len(columns)))
        self._drives.set_types(where, columns, kinds)

    def get_dof_max_efforts(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return the largest torques, and forces of prismatic joints, (N, D) of the drives."""
        return self._part(self._drives.max_efforts(), indices, dof_indices)

    def set_dof_max_efforts(self, max_efforts: Values, *, indices: Indices = None, dof_indices: Indices = None) -> None:
        """Set the largest torques, and forces of prismatic joints, (N, D) of the drives."""
        self._set(self._drives.set_max_efforts, max_efforts, indices, dof_indices)
