"""`ArticulationSubset`: some joints of a robot, in an order of their own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdsdg.compat.isaacsim.core.prims import SingleArticulation
from usdsdg.compat.isaacsim.core.utils.types import ArticulationAction, JointsState


class ArticulationSubset:
    """The joints `joint_names` (K,) of a robot; numbers of joints are (K,) in this order."""

    def __init__(self, articulation: SingleArticulation, joint_names: Sequence[str]) -> None:
        self.articulation, self.joint_names = articulation, joint_names

    @property
    def is_initialized(self) -> bool:
        return self.articulation.handles_initialized

    @property
    def num_joints(self) -> int:
        return len(self.joint_names)

    @property
    def joint_indices(self) -> np.ndarray:
        """Return the columns (K,) of the joints among all of the robot.

        Raises:
            KeyError: the robot has no joint of a name.
        """
        return np.array([self.articulation.get_dof_index(name) for name in self.joint_names], int)

    def get_joint_subset_indices(self) -> np.ndarray:
        return self.joint_indices

    def get_joint_positions(self) -> np.ndarray:
        return self.articulation.get_joint_positions(self.joint_indices)

    def get_joint_velocities(self) -> np.ndarray:
        return self.articulation.get_joint_velocities(self.joint_indices)

    def get_applied_joint_efforts(self) -> np.ndarray:
        return self.articulation.get_applied_joint_efforts(self.joint_indices)

    def set_joint_positions(self, positions: np.ndarray) -> None:
        self.articulation.set_joint_positions(positions, self.joint_indices)

    def set_joint_velocities(self, velocities: np.ndarray) -> None:
        self.articulation.set_joint_velocities(velocities, self.joint_indices)

    def set_joint_efforts(self, efforts: np.ndarray) -> None:
        self.articulation.set_joint_efforts(efforts, self.joint_indices)

    def map_to_articulation_order(self, joint_values: np.ndarray) -> np.ndarray:
        """Return values (K,) or (N, K) at the places of their joints among all, None at the others: (D,) or (N, D)."""
        values = np.asarray(joint_values)
        found = np.full((*values.shape[:-1], self.articulation.num_dof), None)
        found[..., self.joint_indices] = values
        return found

    def make_articulation_action(
        self, joint_positions: np.ndarray | None, joint_velocities: np.ndarray | None
    ) -> ArticulationAction:
        """Return the action that gives these joints targets."""
        return ArticulationAction(joint_positions, joint_velocities, joint_indices=self.joint_indices)

    def apply_action(
        self, joint_positions: np.ndarray | None = None, joint_velocities: np.ndarray | None = None
    ) -> None:
        """Give these joints targets."""
        self.articulation.apply_action(self.make_articulation_action(joint_positions, joint_velocities))

    def get_applied_action(self) -> ArticulationAction:
        """Return the targets of these joints, and the efforts that were set last."""
        action, columns = self.articulation.get_applied_action(), self.joint_indices
        rows = (action.joint_positions, action.joint_velocities, action.joint_efforts)
        return ArticulationAction(*(np.asarray(row)[columns] for row in rows), joint_indices=columns)

    def get_joints_state(self) -> JointsState:
        """Return positions and velocities."""
        return JointsState(self.get_joint_positions(), self.get_joint_velocities(), None)
