"""The matrices of the pose ops of all bodies, from their rigid frames and what stays constant while they move."""

import numpy as np

from usdsdg_physics.scene.rigid_frames import pose_matrix
from usdsdg_physics.writeback.pose_ops import PoseOps

# Relative difference of the lengths of axes up to which a scale is called even.
_EVEN = 1e-3


class PoseMatrices:
    """The matrix of the pose ops of a body is `left @ frame @ right`, where `frame` is its rigid frame (see `PoseOps`).

    `left` = after⁻¹ · body_from_prim, `right` = parent_to_world⁻¹ · before⁻¹. Bodies are rows; those that are never set
    have matrices without a meaning.
    """

    def __init__(self, body_from_prim: np.ndarray, meters_per_unit: float) -> None:
        """`body_from_prim` (N, 4, 4) is from local space [stage units] to the rigid frame [m]."""
        self._meters_per_unit = meters_per_unit
        self._body_from_prim = body_from_prim / meters_per_unit
        self._body_from_prim[:, 3, 3] = 1.0
        # (N,) whether a body has a scale of zero; it is never set, and its rotation must not be divided by its length.
        self.is_flat = np.abs(np.linalg.det(self._body_from_prim)) < 1e-30
        self._body_from_prim[self.is_flat] = np.eye(4)
        count = len(body_from_prim)
        self._before, self._after, self._parent_to_world, self.between = (
            np.tile(np.eye(4), (count, 1, 1)) for _ in range(4)
        )
        self._nested: dict[int, tuple[int, np.ndarray]] = {}  # by row: row of the ancestor, parent_from_ancestor

    def set(self, row: int, ops: PoseOps, parent_to_world: np.ndarray) -> None:
        """Set what is constant around the pose ops of a body."""
        self._before[row], self._after[row], self.between[row] = ops.before, ops.after, ops.between
        self._parent_to_world[row] = parent_to_world

    def set_ancestor(self, row: int, ancestor: int, parent_from_ancestor: np.ndarray) -> None:
        """Let the parent of a body follow another body."""
        self._nested[row] = ancestor, parent_from_ancestor

    def finish(self) -> None:
        """Compute the products, when all bodies are set."""
        self._before_inverse = np.linalg.inv(self._before)
        self._left = np.linalg.inv(self._after) @ self._body_from_prim
        self._right = np.linalg.inv(self._parent_to_world) @ self._before_inverse
        self._between_inverse = np.linalg.inv(self.between[:, :3, :3])
        self._deformed = np.flatnonzero(self.deforms)

    def move_in_ancestor(self, row: int, parent_from_ancestor: np.ndarray) -> None:
        """Set where the parent of a body is now in the body that it follows."""
        self._nested[row] = self._nested[row][0], parent_from_ancestor

    def move_parent(self, row: int, parent_to_world: np.ndarray) -> None:
        """Set where the parent of a body is now."""
        self._right[row] = np.linalg.inv(parent_to_world) @ self._before_inverse[row]

    @property
    def deforms(self) -> np.ndarray:
        """(N,) whether the axes of a body are scaled unevenly after they are turned, so that its shape changes."""
        axes = (self.between @ self._before @ self._parent_to_world)[:, :3, :3]
        products = axes @ np.swapaxes(axes, 1, 2)
        size = np.trace(products, axis1=1, axis2=2)[:, None, None] / 3.0
        return (np.abs(products - size * np.eye(3)) > _EVEN * size).any(axis=(1, 2))

    def of_poses(self, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the matrices (N, 4, 4) of the pose ops for poses (N, 7) [m], and the rotations (N, 3, 3) in them."""
        frames = pose_matrix(poses, self._meters_per_unit)
        for row, (ancestor, parent_from_ancestor) in self._nested.items():
            parent = parent_from_ancestor @ self._body_from_prim[ancestor] @ frames[ancestor]
            self._right[row] = np.linalg.inv(parent) @ self._before_inverse[row]
        matrices = self._left @ frames @ self._right
        rotations = matrices[:, :3, :3] @ self._between_inverse
        rotations /= np.linalg.norm(rotations, axis=2, keepdims=True)
        if len(self._deformed):
            u, _, v = np.linalg.svd(rotations[self._deformed])
            rotations[self._deformed] = u @ v  # the nearest ones
        return matrices, rotations

    def translations(self, matrices: np.ndarray, rotations: np.ndarray) -> np.ndarray:
        """Return the translations (N, 3) that bring the origins of the bodies to where the matrices have them.

        Of a body that is drawn deformed the rotation cannot make the matrix, which shows where it has a pivot.
        """
        found, rows = matrices[:, 3, :3] - self.between[:, 3, :3], self._deformed
        if len(rows):
            missing = matrices[rows, :3, :3] - rotations[rows] @ self.between[rows, :3, :3]
            found[rows] += (self._after[rows, 3:, :3] @ missing)[:, 0]
        return found

    def follow_ancestors(self, changed: np.ndarray) -> None:
        """Mark in `changed` (N,) the bodies below a body that is marked."""
        for row, (ancestor, _) in self._nested.items():
            changed[row] |= changed[ancestor]
