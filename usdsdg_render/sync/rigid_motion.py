"""Rigid motion between two states of a scene, so that a moving thing blurs instead of showing a row of copies."""

from functools import cached_property
from typing import Any

import numpy as np

# Largest deviation of the relative linear part from a rotation for which motion counts as rigid.
RIGID = 1e-4


class RigidMotion:
    """The motion of instances from one state to another, which exposures look at in several places."""

    def __init__(self, before: np.ndarray, after: np.ndarray) -> None:
        """`before` and `after` are (N, 4, 4) float64 local-to-world, USD's row vectors."""
        self._before, self._after = before, after

    @cached_property
    def moves(self) -> np.ndarray:
        """Which instances move, (N,) bool."""
        return (self._before != self._after).any((1, 2))

    def at(self, fraction: float) -> np.ndarray:
        """Transforms at `fraction` of the way, 0 = before, 1 = after.

        Returns:
            (N, 4, 4) float64. Origins move on straight lines; linear parts turn at constant rate about a fixed axis
            where the motion is rigid, and are blended entry by entry where it is not (a scale that changed).
        """
        if fraction >= 1.0:
            return self._after
        mixed = self._before + (self._after - self._before) * fraction
        rows, rotations = self._turns
        if len(rows):
            part = type(rotations).from_rotvec(rotations.as_rotvec() * fraction).as_matrix().transpose(0, 2, 1)
            mixed[rows, :3, :3] = self._before[rows, :3, :3] @ part
        return mixed

    @cached_property
    def _turns(self) -> tuple[np.ndarray, Any]:
        """The rows whose motion is rigid, and the SciPy rotations by which they turn."""
        from scipy.spatial.transform import Rotation

        moving = np.flatnonzero(self.moves)
        turned = np.linalg.inv(_linear(self._before[moving])) @ _linear(self._after[moving])
        error = np.abs(turned @ turned.transpose(0, 2, 1) - np.eye(3)).max((1, 2), initial=0.0)
        rigid = (error < RIGID) & (np.linalg.det(turned) > 0)
        if not rigid.any():
            return moving[:0], None
        # A row-vector rotation is the transpose of the matrix that SciPy means.
        return moving[rigid], Rotation.from_matrix(turned[rigid].transpose(0, 2, 1))


def _linear(matrices: np.ndarray) -> np.ndarray:
    """The 3x3 part, with the identity where it cannot be inverted."""
    linear = matrices[:, :3, :3].copy()
    flat = ~np.isfinite(linear).all((1, 2)) | (np.abs(np.linalg.det(np.nan_to_num(linear))) < 1e-30)
    linear[flat] = np.eye(3)
    return linear
