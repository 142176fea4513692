"""`ArticulationGripper`: the fingers of a robot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdsdg.compat.isaacsim.core.api.controllers import ArticulationController
from usdsdg.compat.isaacsim.core.prims import SingleArticulation
from usdsdg.compat.isaacsim.core.utils.types import ArticulationAction


class ArticulationGripper:
    """The joints `gripper_dof_names` (K,) of a robot, with positions where it is open and closed."""

    def __init__(
        self,
        gripper_dof_names: Sequence[str],
        gripper_open_position: np.ndarray | None = None,
        gripper_closed_position: np.ndarray | None = None,
    ) -> None:
        self._names = list(gripper_dof_names)
        self.open_position, self.closed_position = gripper_open_position, gripper_closed_position

    def initialize(self, root_prim_path: str, articulation_controller: ArticulationController) -> None:
        """Take the robot at a path, and what controls it.

        Raises:
            KeyError: the robot has no joint of a name.
        """
        self._robot = SingleArticulation(root_prim_path, reset_xform_properties=False)
        self._controller = articulation_controller
        self.dof_indices = np.array([self._robot.get_dof_index(name) for name in self._names], int)

    def get_positions(self) -> np.ndarray:
        """Return (K,)."""
        return self._robot.get_joint_positions(self.dof_indices)

    def get_velocities(self) -> np.ndarray:
        """Return (K,)."""
        return self._robot.get_joint_velocities(self.dof_indices)

    def set_positions(self, positions: np.ndarray) -> None:
        """Move the joints at once (K,), and let drives hold them there."""
        self._robot.set_joint_positions(positions, self.dof_indices)
        self.apply_action(ArticulationAction(joint_positions=positions))

    def set_velocities(self, velocities: np.ndarray) -> None:
        """Set velocities (K,), and those that drives give the joints."""
        self._robot.set_joint_velocities(velocities, self.dof_indices)
        self.apply_action(ArticulationAction(joint_velocities=velocities))

    def apply_action(self, action: ArticulationAction) -> None:
        """Apply an action to the joints of the gripper."""
        action.joint_indices = self.dof_indices
        self._controller.apply_action(action)
