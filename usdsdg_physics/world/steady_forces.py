"""Forces that act on bodies at every step."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from usdsdg.stage.poses.rotations import matrix_from_quat
from usdsdg_physics.scene.records import Force


class SteadyForces:
    """The forces of one scene, as wrenches for the pose and the mass properties of each body."""

    def __init__(
        self, body_index: Mapping[str, int], mass: np.ndarray, center: np.ndarray, inertia: np.ndarray
    ) -> None:
        """`inertia` (N, 3, 3) [kg m²] is about the center of mass, in the body's frame."""
        self._body_index, self._mass, self._center, self._inertia = body_index, mass, center, inertia
        self._forces: list[Force] = []

    def set(self, forces: Iterable[Force]) -> None:
        """Set all forces; those of bodies that are not simulated are left out."""
        self._forces = [force for force in forces if force.enabled and force.body in self._body_index]

    def __bool__(self) -> bool:
        return bool(self._forces)

    def wrenches(self, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the indices of bodies (F,) and their wrenches about the center of mass (F, 6) [N, N m], world."""
        rows = np.array([self._body_index[force.body] for force in self._forces], int)
        wrenches = np.array(
            [self._wrench(force, row, poses[row].astype(np.float64)) for force, row in zip(self._forces, rows)]
        )
        return rows, wrenches.reshape(-1, 6)

    def _wrench(self, force: Force, row: int, pose: np.ndarray) -> np.ndarray:
        rotation = matrix_from_quat(pose[3:])
        push, turn = np.asarray(force.force), np.asarray(force.torque)
        if force.local:
            push, turn = push @ rotation, turn @ rotation
        if force.acceleration:
            push, turn = push * self._mass[row], turn @ (rotation.T @ self._inertia[row] @ rotation)
        if force.point is not None:
            turn = turn + np.cross((np.asarray(force.point) - self._center[row]) @ rotation, push)
        return np.concatenate([push, turn])
