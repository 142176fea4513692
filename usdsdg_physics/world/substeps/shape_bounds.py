"""Where the shapes of a world are: spheres around those of bodies, boxes around static ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from usdsdg.stage.poses.rotations import matrix_from_quat, rotated

if TYPE_CHECKING:
    import newton


class ShapeBounds:
    """Bounds of the shapes of a model, with the distance at which they touch."""

    def __init__(self, model: newton.Model) -> None:
        import newton

        self._model = model
        body = _numbers(model.shape_body)
        lower, upper = _numbers(model.shape_collision_aabb_lower), _numbers(model.shape_collision_aabb_upper)
        half, middle = (upper - lower) / 2.0, (upper + lower) / 2.0
        moving = np.flatnonzero(body >= 0)
        self._statics, self.body = np.flatnonzero(body < 0), body[moving]
        local = _numbers(model.shape_transform)[moving].astype(np.float64)
        self._center = rotated(local[:, 3:], middle[moving]) + local[:, :3]
        reach = _numbers(model.shape_gap) + _numbers(model.shape_margin)
        # Of the shapes of bodies, (M,): their bodies are `body`.
        self.radius = np.linalg.norm(half, axis=1)[moving] + reach[moving]
        self.arm = np.linalg.norm(self._center, axis=1) + self.radius  # from the origin of the body
        self._half, self._middle = half[self._statics] + reach[self._statics, None], middle[self._statics]
        # Of the static shapes, (S,).
        self.endless = _numbers(model.shape_type)[self._statics] == int(newton.GeoType.PLANE)
        self.update_static()

    def update_static(self) -> None:
        """Read where static colliders are: the boxes around them, middle and half extents (S, 3), world."""
        pose = _numbers(self._model.shape_transform)[self._statics].astype(np.float64).reshape(-1, 7)
        axes = matrix_from_quat(pose[:, 3:])
        middle = np.where(self.endless[:, None], 0.0, self._middle)
        half = np.where(self.endless[:, None], 0.0, self._half)
        half = np.einsum("nij,ni->nj", np.abs(axes), half) + np.where(self.endless[:, None], np.inf, 0.0)
        self.static_boxes = np.einsum("nij,ni->nj", axes, middle) + pose[:, :3], half

    def centers(self, poses: np.ndarray) -> np.ndarray:
        """Return the centers (M, 3) of the spheres for poses (N, 7) of the bodies."""
        return rotated(poses[self.body, 3:], self._center) + poses[self.body, :3]


def _numbers(array: object) -> np.ndarray:
    return array.numpy()  # pyright: ignore[reportAttributeAccessIssue]
