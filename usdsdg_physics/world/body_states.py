"""Where bodies are and how fast they move, in every array that the solver and the collision pipeline read."""

# Newton declares the arrays of models and states optional; after `finalize` all are there.
# pyright: reportOptionalMemberAccess=false, reportArgumentType=false

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.world.halves import Halves

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.model.build import BuiltModel
    from usdsdg_physics.world.joints import Joints

Indices = Sequence[int] | np.ndarray


class BodyStates:
    """Poses and velocities of bodies in the state that steps begin and end with."""

    def __init__(self, state: newton.State, halves: Halves, built: BuiltModel, joints: Joints | None) -> None:
        self._state, self._halves, self._joints = state, halves, joints
        self._coordinate, self._dof = built.coordinate, built.dof
        self._paths = list(built.body_index)

    def poses(self) -> np.ndarray:
        """Return (N + halves, 7) float32, with the second halves of bodies that were cut."""
        return self._state.body_q.numpy().reshape(-1, 7).copy()

    def velocities(self) -> np.ndarray:
        """Return (N + halves, 6) float32, likewise."""
        return self._state.body_qd.numpy().reshape(-1, 6).copy()

    def set_poses(self, indices: Indices, poses: np.ndarray) -> Indices:
        """Set poses of bodies and of their second halves; return the indices of both."""
        q = self.poses()
        q[indices] = poses
        indices = self._halves.follow(q, indices)
        # The solver reads joint coordinates, the collision pipeline body poses.
        self._state.body_q.assign(q)
        _assign_rows(self._state.joint_q, self._coordinate, q)
        if self._joints is not None:
            self._joints.teleport(self._state, {self._paths[index]: q[index] for index in indices})
        return indices

    def set_velocities(self, indices: Indices, velocities: np.ndarray) -> Indices:
        """Set velocities of bodies and of their second halves; return the indices of both."""
        qd = self.velocities()
        qd[indices] = velocities
        indices = self._halves.follow(qd, indices)
        self._state.body_qd.assign(qd)
        _assign_rows(self._state.joint_qd, self._dof, qd)
        if self._joints is not None:
            self._joints.push(self._state, {self._paths[index]: qd[index] for index in indices})
        return indices


def _assign_rows(array: wp.array, starts: np.ndarray, rows: np.ndarray) -> None:
    """Write rows (N, K) to where each starts in a flat array; rows that start below zero are left out."""
    numbers = array.numpy().copy()
    chosen = np.flatnonzero(starts >= 0)
    numbers[starts[chosen, None] + np.arange(rows.shape[1])] = rows[chosen]
    array.assign(numbers)
