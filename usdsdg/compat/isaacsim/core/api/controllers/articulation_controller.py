"""`ArticulationController`: targets, efforts and gains of one robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.compat.isaacsim.core.utils.types import ArticulationAction, ArticulationActions
from usdsdg.compat.wrappers.arrays import as_numpy, chosen

if TYPE_CHECKING:
    from usdsdg.compat.isaacsim.core.prims import Articulation
    from usdsdg.compat.wrappers.arrays import Indices, Values


class ArticulationController:
    """Controls the joints of the robot that `initialize` is given; D is their number."""

    _robots: Articulation | None = None

    def initialize(self, articulation_view: Articulation) -> None:
        """Take the robot, which is the first of a view."""
        self._robots = articulation_view

    @property
    def is_initialized(self) -> bool:
        """Whether it has a robot."""
        return self._robots is not None

    def apply_action(self, control_actions: ArticulationAction) -> None:
        """Set targets of drives and efforts of joints; NaN and None leave a joint as it is.

        Raises:
            RuntimeError: `initialize` has not been called.
            PhysicsError: efforts are given, and physics does not play.
        """
        view, now = self._view, self.get_applied_action()
        columns = chosen(control_actions.joint_indices, view.num_dof)
        wanted = [
            _filled(getattr(control_actions, name), getattr(now, name), columns)
            for name in ("joint_positions", "joint_velocities", "joint_efforts")
        ]
        view.apply_action(ArticulationActions(*wanted, joint_indices=columns), [0])

    def get_applied_action(self) -> ArticulationAction:
        """Return the targets of the drives, and the efforts that were set last (D,)."""
        applied = self._view.get_applied_actions()
        return ArticulationAction(
            *(each[0] for each in (applied.joint_positions, applied.joint_velocities, applied.joint_efforts))  # pyright: ignore
        )

    # --- gains and limits ---
    def set_gains(self, kps: Values | None = None, kds: Values | None = None, save_to_usd: bool = False) -> None:
        """Set stiffness and damping (D,) of the drives: until physics stops where it plays, unless `save_to_usd`."""
        self._view.set_gains(kps, kds, save_to_usd=save_to_usd)

    def get_gains(self) -> tuple[np.ndarray, np.ndarray]:
        """Return stiffness and damping (D,)."""
        stiffness, damping = self._view.get_gains()
        return stiffness[0], damping[0]

    def switch_control_mode(self, mode: str) -> None:
        """Set the gains of "position", "velocity" or "effort" control; see `Articulation.switch_control_mode`."""
        self._view.switch_control_mode(mode)

    def switch_dof_control_mode(self, dof_index: int, mode: str) -> None:
        """Do what `switch_control_mode` does for one joint."""
        self._view.switch_dof_control_mode(mode, dof_index)

    def set_max_efforts(self, values: Values, joint_indices: Indices = None) -> None:
        """Set the largest torques, and forces of prismatic joints, (D,) of the drives."""
        self._view.set_max_efforts(values, joint_indices=joint_indices)

    def get_max_efforts(self) -> np.ndarray:
        """Return the largest torques, and forces of prismatic joints, (D,) of the drives."""
        return self._view.get_max_efforts()[0]

    def set_effort_modes(self, mode: str, joint_indices: Indices = None) -> None:
        """Let gains mean forces ("force"), or forces per mass ("acceleration")."""
        self._view.set_effort_modes(mode, joint_indices=joint_indices)

    def get_effort_modes(self) -> list[str]:
        """Return "force" or "acceleration" of each joint."""
        return self._view.get_effort_modes()[0]

    def get_joint_limits(self) -> np.ndarray:
        """Return lower and upper limits (D, 2)."""
        return self._view.get_dof_limits()[0]

    @property
    def _view(self) -> Articulation:
        if self._robots is None:
            raise RuntimeError("this ArticulationController has no robot: call the robot's initialize() first")
        return self._robots


def _filled(wanted: Values | Sequence[float | None] | None, now: Values, columns: Sequence[int]) -> np.ndarray | None:
    """Return what is wanted (1, K) with the present values in place of NaN and None."""
    if wanted is None:
        return None
    numbers = as_numpy(wanted).astype(np.float64).reshape(-1)  # pyright: ignore[reportArgumentType]
    return np.where(np.isnan(numbers), as_numpy(now)[list(columns)], numbers)[None]
