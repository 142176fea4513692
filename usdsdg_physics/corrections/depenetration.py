"""Static colliders that a script switches on, or moves, around bodies while the simulation runs."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.extents import half_thickness
from usdsdg_physics.scene.records import STATIC, Scene

if TYPE_CHECKING:
    import newton

# Four updates of the app: as long as the tutorial scripts give a camera's collider to make room.
PUSH_TIME = 4.0 / 60.0  # s


class Intruders:
    """Frees the middle of a collider that appears inside bodies; otherwise a camera would look at their inside.

    PhysX pushes at the bodies' maxDepenetrationVelocity, 3 m/s, and in four updates gets a camera out of no body that
    is wider than 0.4 m. Here a body that holds the collider's middle is pushed as fast as it takes, and keeps nothing
    of that speed; all others are pushed as in PhysX.
    """

    def __init__(self, scene: Scene, model: newton.Model, shape_index: dict[str, int]) -> None:
        import warp as wp

        self._model = model
        self._time_left = np.zeros(len(shape_index), np.float32)
        reach = np.zeros(len(shape_index), np.float32)
        self._static = set()
        for collider in scene.colliders.values():
            reach[shape_index[collider.path]] = half_thickness(collider.shape)
            if collider.body == STATIC:
                self._static.add(shape_index[collider.path])
        limits = [body.max_depenetration_velocity for body in scene.bodies.values()]
        where = model.device
        self._reach = wp.array(reach, dtype=wp.float32, device=where)
        self._limits = wp.array(limits, dtype=wp.float32, device=where)
        self._dynamic = wp.array([not body.kinematic for body in scene.bodies.values()], dtype=wp.int32, device=where)

    def appear(self, shapes: Collection[int]) -> None:
        """Colliders that were switched on or moved, by shape index."""
        self._time_left[list(self._static.intersection(shapes))] = PUSH_TIME

    def vanish(self, shapes: Collection[int]) -> None:
        self._time_left[list(shapes)] = 0.0

    @property
    def any(self) -> bool:
        return bool((self._time_left > 0.0).any())

    def push(self, contacts: newton.Contacts, state: newton.State) -> None:
        """Set how fast each body may be pushed out of what it is in, before the solver's step."""
        import warp as wp

        from usdsdg_physics.corrections.depenetration_kernels import hurry_out

        speed = self._model.steel.rigid_body_max_depenetration_velocity
        wp.copy(speed, self._limits)
        wp.launch(
            hurry_out,
            dim=contacts.rigid_contact_max,
            inputs=[
                wp.array(self._time_left, dtype=wp.float32, device=self._model.device),
                self._reach,
                self._model.shape_body,
                state.body_q,
                contacts.rigid_contact_count,
                contacts.rigid_contact_shape0,
                contacts.rigid_contact_shape1,
                contacts.rigid_contact_point0,
                contacts.rigid_contact_point1,
                contacts.rigid_contact_normal,
                contacts.rigid_contact_margin0,
                contacts.rigid_contact_margin1,
            ],
            outputs=[speed],
            device=self._model.device,
        )

    def calm(self, before: newton.State, after: newton.State, dt: float) -> None:
        """Take from the bodies what speed the push gave them, after the solver's step of `dt` seconds."""
        import warp as wp

        from usdsdg_physics.corrections.depenetration_kernels import calm_down

        wp.launch(
            calm_down,
            dim=self._model.body_count,
            inputs=[self._dynamic, self._limits, before.body_qd],
            outputs=[after.joint_qd, after.body_qd],
            device=self._model.device,
        )
        self._time_left = np.maximum(self._time_left - dt, 0.0)
        self._time_left[self._time_left < 1e-4] = 0.0
        if not self.any:
            wp.copy(self._model.steel.rigid_body_max_depenetration_velocity, self._limits)
