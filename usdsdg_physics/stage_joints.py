"""The joints of a stage, which a physics engine reads and drives while it plays."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from usdsdg_physics.play import PlaySession
from usdsdg_physics.simulated_joints import SimulatedJoints


class StageJoints(ABC):
    """Joints by path, in rad and stage units; a subclass says what plays."""

    _session: PlaySession | None

    @abstractmethod
    def _playing(self, caller: str) -> PlaySession:
        """Return what plays; raise a PhysicsError, which names the caller, where nothing does."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Paths of the revolute and prismatic joints that are simulated; empty while stopped."""
        return SimulatedJoints(self._session).paths if self._session else ()

    def joint_positions(self, joints: Sequence[str]) -> np.ndarray:
        """Return the positions (N,) of joints: angles [rad], distances [stage units].

        Raises:
            PhysicsError: `play` has not been called, or a path is not among `joints`.
        """
        return self._joints("joint_positions").state(joints)[0]

    def joint_velocities(self, joints: Sequence[str]) -> np.ndarray:
        """Return the velocities (N,) of joints [rad/s, stage units/s].

        Raises:
            PhysicsError: `play` has not been called, or a path is not among `joints`.
        """
        return self._joints("joint_velocities").state(joints)[1]

    def set_joint_state(
        self, joints: Sequence[str], positions: ArrayLike | None = None, velocities: ArrayLike | None = None
    ) -> None:
        """Move joints at once (N,) [rad, stage units], and set their velocities (N,); bodies follow, here and there.

        Raises:
            PhysicsError: `play` has not been called, or a path is not among `joints`.
        """
        self._joints("set_joint_state").set_state(joints, positions, velocities)

    def apply_joint_efforts(self, joints: Sequence[str], efforts: ArrayLike) -> None:
        """Push joints during the next step (N,), in stage units: torques, and forces of prismatic joints.

        Raises:
            PhysicsError: `play` has not been called, or a path is not among `joints`.
        """
        self._joints("apply_joint_efforts").add_efforts(joints, np.asarray(efforts, np.float64))

    def joint_forces(self, joints: Sequence[str]) -> np.ndarray:
        """Return what body 0 of joints exerts on body 1, the mean over the latest step: forces and torques (N, 6).

        They are those of PhysX's articulations: with what drives, limits and efforts do, along the joint's frame at
        body 1 and about its origin, in the stage's units of mass, length and s⁻². A joint that fixes a base has zeros.

        Raises:
            PhysicsError: `play` has not been called, or a path is no joint of an articulation.
        """
        return self._joints("joint_forces").forces(joints)

    def _joints(self, caller: str) -> SimulatedJoints:
        return SimulatedJoints(self._playing(caller))
