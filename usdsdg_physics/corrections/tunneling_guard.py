"""Which side of each static box a body belongs to, so that none is pushed through a wall."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.stage.poses.transforms import matrix_from_quat
from usdsdg_physics.scene.records import STATIC, Scene, Shape

if TYPE_CHECKING:
    import newton


class Sides:
    """Remembers, for every static box and shape in contact, the face on which the contact began.

    PhysX, like every solver that takes the shortest way out, loses bodies that start across a wall or are squeezed
    more than half way into it.
    """

    def __init__(self, scene: Scene, model: newton.Model, shape_index: dict[str, int]) -> None:
        import warp as wp

        self._model = model
        count = len(shape_index)
        rows, half, center = np.full(count, -1, np.int32), np.zeros((count, 3)), np.zeros((count, 3))
        boxes = 0
        for collider in scene.colliders.values():
            index, shape = shape_index[collider.path], collider.shape
            center[index] = _center(shape)
            if collider.body == STATIC and shape.kind == "box":
                rows[index], half[index] = boxes, shape.size
                boxes += 1
        where = model.device
        self._rows = wp.array(rows, dtype=wp.int32, device=where)
        self._half_extent = wp.array(half, dtype=wp.vec3, device=where)
        self._center = wp.array(center, dtype=wp.vec3, device=where)
        self._side = wp.full((boxes, count), -1, dtype=wp.int32, device=where)
        self._placed = wp.zeros(model.body_count, dtype=wp.int32, device=where)
        self._step = 0

    def place(self, bodies: Sequence[int] | np.ndarray) -> None:
        """Bodies that somebody put where they are: the side of their origin counts at the next contact."""
        placed = self._placed.numpy().copy()
        placed[bodies] = 1
        self._placed.assign(placed)

    def apply(self, contacts: newton.Contacts, state: newton.State) -> None:
        """Correct the contacts that were just found."""
        import warp as wp

        from usdsdg_physics.corrections.tunneling_guard_kernels import keep_sides

        if not len(self._side):
            return
        self._step += 1
        wp.launch(
            keep_sides,
            dim=contacts.rigid_contact_max,
            inputs=[
                self._rows,
                self._half_extent,
                self._model.shape_transform,
                self._model.shape_body,
                self._center,
                state.body_q,
                self._placed,
                contacts.rigid_contact_count,
                contacts.rigid_contact_shape0,
                contacts.rigid_contact_shape1,
                contacts.rigid_contact_margin0,
                contacts.rigid_contact_margin1,
                self._step,
            ],
            outputs=[
                contacts.rigid_contact_point0,
                contacts.rigid_contact_point1,
                contacts.rigid_contact_normal,
                self._side,
            ],
            device=self._model.device,
        )
        self._placed.zero_()


def _center(shape: Shape) -> np.ndarray:
    """Centre of a shape in its body's frame [m]."""
    if shape.solid is None:
        return np.array(shape.position)
    return (shape.solid.centroid * shape.size) @ matrix_from_quat(shape.rotation) + shape.position
