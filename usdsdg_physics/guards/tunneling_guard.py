"""Keep bodies from being pushed through static boxes such as walls and floors."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.stage.poses.rotations import matrix_from_quat
from usdsdg_physics.scene.extents import body_boxes
from usdsdg_physics.scene.records import STATIC, Scene, Shape

if TYPE_CHECKING:
    import newton

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


# Distance of an origin from a body, in diagonals of its box, up to which the body is where its origin is.
AT_BODY = 0.1


class TunnelingGuard:
    """Remembers, for every pair of a static box and a shape in contact, the face by which the shape leaves the box.

    Without it, bodies that start across a wall or are squeezed more than half way into it are lost: PhysX, like every
    solver that resolves a contact along the minimum penetration depth, pushes them out on the far side.
    """

    def __init__(self, scene: Scene, model: newton.Model, shape_index: dict[str, int], contacts: ContactArrays) -> None:
        import warp as wp

        self._model, self._contacts = model, contacts
        count = len(shape_index)
        box_index, half, center = np.full(count, -1, np.int32), np.zeros((count, 3)), np.zeros((count, 3))
        boxes = 0
        for collider in scene.colliders.values():
            index, shape = shape_index[collider.path], collider.shape
            center[index] = _center(shape)
            if collider.body == STATIC and shape.kind == "box":
                box_index[index], half[index] = boxes, shape.size
                boxes += 1
        device = model.device
        self._box_index = wp.array(box_index, dtype=wp.int32, device=device)
        self._half_extent = wp.array(half, dtype=wp.vec3, device=device)
        self._center = wp.array(center, dtype=wp.vec3, device=device)
        self._exit_face = wp.full((boxes, count), -1, dtype=wp.int32, device=device)
        anchors = np.zeros((model.body_count, 3))
        anchors[: len(scene.bodies)] = _anchors(body_boxes(scene.bodies, scene.colliders.values()))
        self._anchor = wp.array(anchors, dtype=wp.vec3, device=device)
        # Bodies whose pose was set since the last step: the side of such a body's anchor decides its exit face.
        self.teleported = wp.zeros(model.body_count, dtype=wp.int32, device=device)
        self._step = wp.zeros(1, dtype=wp.int32, device=device)

    def mark_teleported(self, bodies: Sequence[int] | np.ndarray) -> None:
        """Let the side of a body's anchor decide its exit face at the next contact, since its pose was set."""
        teleported = self.teleported.numpy().copy()
        teleported[bodies] = 1
        self.teleported.assign(teleported)

    def redirect_contacts(self, state: newton.State, visited: int) -> None:
        """Correct the contacts that the pipeline just found, at most `visited`, before the solver's step."""
        import warp as wp

        from usdsdg_physics.guards.tunneling_guard_kernels import count_step, redirect_contacts

        if not len(self._exit_face):
            return
        wp.launch(count_step, dim=1, outputs=[self._step], device=self._model.device)
        wp.launch(
            redirect_contacts,
            dim=visited,
            inputs=[
                self._box_index,
                self._half_extent,
                self._model.shape_transform,
                self._model.shape_body,
                self._center,
                self._anchor,
                state.body_q,
                self.teleported,
                self._step,
            ],
            outputs=[self._contacts, self._exit_face],
            device=self._model.device,
        )
        self.teleported.zero_()


def _anchors(boxes: np.ndarray) -> np.ndarray:
    """Return the points (N, 3) that tell on which side of a wall bodies are, in their frames; `boxes` (N, 2, 3) too.

    These are the origins, at which assets are placed, of bodies that have it in or at them, and the middles of others,
    such as assets that are modeled at their places in a room.
    """
    lower, upper = boxes[:, 0], boxes[:, 1]
    nearest = np.clip(0.0, lower, upper)
    is_at = np.linalg.norm(nearest, axis=1) <= AT_BODY * np.linalg.norm(upper - lower, axis=1)
    return np.where(is_at[:, None], nearest, (lower + upper) / 2.0)


def _center(shape: Shape) -> np.ndarray:
    """Return the center of a shape in its body's frame [m]."""
    if shape.solid is None:
        return np.array(shape.position)
    return (shape.solid.centroid * shape.size) @ matrix_from_quat(shape.rotation) + shape.position
