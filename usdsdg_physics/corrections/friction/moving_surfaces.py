"""Surfaces that move relative to their bodies, or with static colliders, and carry what touches them."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false, reportArgumentType=false

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.records import Scene, SurfaceVelocity

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


class MovingSurfaces:
    """The surface velocities of the bodies of one scene, and those of the contacts that follow from them."""

    def __init__(
        self,
        scene: Scene,
        model: newton.Model,
        contacts: newton.Contacts,
        arrays: ContactArrays,
        rest_time: wp.array,
    ) -> None:
        """`rest_time` (N,) [s] becomes zero for bodies that lie on a moving surface, which must not be held at rest."""
        import warp as wp

        self._model, self._contacts, self._rest_time = model, arrays, rest_time
        # The solver reads this array of the contacts, which the pipeline does not fill.
        self.velocity = wp.zeros(arrays.shape0.size, dtype=wp.vec3, device=model.device)
        contacts.rigid_contact_surface_velocity = self.velocity
        count = len(scene.bodies)
        self._linear, self._angular = np.zeros((count, 3), np.float32), np.zeros((count, 3), np.float32)
        self._local = np.zeros(count, np.int32)
        self._device = (
            wp.zeros(count, dtype=wp.vec3, device=model.device),
            wp.zeros(count, dtype=wp.vec3, device=model.device),
            wp.zeros(count, dtype=wp.int32, device=model.device),
        )
        shapes = model.shape_count
        self._shapes = wp.zeros(shapes, dtype=wp.spatial_vector, device=model.device)
        self._motion = np.zeros((shapes, 6), np.float32)
        self.set_velocities({row: body.surface for row, body in enumerate(scene.bodies.values())})

    def set_velocities(self, surfaces: Mapping[int, SurfaceVelocity | None]) -> None:
        """Set the velocities of the surfaces of bodies, by index."""
        for row, surface in surfaces.items():
            still = SurfaceVelocity((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
            each = surface or still
            self._linear[row], self._angular[row], self._local[row] = each.linear, each.angular, each.local
        for array, numbers in zip(self._device, (self._linear, self._angular, self._local)):
            array.assign(numbers)

    def set_motion(self, motion: Mapping[int, np.ndarray]) -> None:
        """Set the motion (6,) of static shapes, by index; all others do not move.

        It is the velocity of the point at the world's origin [m/s], and the angular velocity [rad/s].
        """
        if motion or self._motion.any():
            self._motion[:] = 0.0
            for shape, velocity in motion.items():
                self._motion[shape] = velocity
            self._shapes.assign(self._motion)

    def update_contacts(self, state: newton.State) -> None:
        """Set the surface velocities of the contacts that the collision pipeline just found."""
        import warp as wp

        from usdsdg_physics.corrections.friction.moving_surfaces_kernels import set_surface_velocities

        wp.launch(
            set_surface_velocities,
            dim=self.velocity.size,
            inputs=[self._model.shape_body, self._shapes, *self._device, state.body_q, self._contacts],
            outputs=[self.velocity, self._rest_time],
            device=self._model.device,
        )
