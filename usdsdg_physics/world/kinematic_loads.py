"""What joints bear because the kinematic bodies that carry them get faster or slower."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from usdsdg.stage.poses.rotations import matrix_from_quat

if TYPE_CHECKING:
    from usdsdg_physics.model.build import BuiltModel


class KinematicLoads:
    """Forces and torques that are not in the solver's: to it what kinematic bodies carry has their speed already."""

    def __init__(self, built: BuiltModel) -> None:
        index = built.body_index
        self._mass, self._inertia, self._center = built.mass, built.inertia, built.center
        # Of trees with a base: rows of parent and child, those farthest from the base first.
        self._branches = [
            (index[branch.parent], index[branch.child])
            for tree in built.joints.trees
            if tree.root
            for branch in reversed(tree.branches)
        ]

    def wrenches(self, poses: np.ndarray, before: np.ndarray, after: np.ndarray, dt: float) -> np.ndarray:
        """Return (N, 6) force [N] and torque about the center of mass [N m] of the joint that holds each body.

        They are the means over a step of `dt` seconds whose begin changes velocities (N, 6), at poses (N, 7).
        """
        turn = matrix_from_quat(poses[:, 3:])
        centers = poses[:, :3] + np.einsum("ni,nij->nj", self._center, turn)
        change = (after - before).astype(np.float64) / dt
        force = self._mass[:, None] * change[:, :3]
        torque = np.einsum("nji,njk,nkl,nl->ni", turn, self._inertia, turn, change[:, 3:])
        for parent, child in self._branches:
            force[parent] += force[child]
            torque[parent] += torque[child] + np.cross(centers[child] - centers[parent], force[child])
        return np.hstack([force, torque])
