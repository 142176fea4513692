"""Push bodies out of a static collider that is switched on, or moved, inside of them while the simulation runs."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from usdsdg_physics.scene.extents import half_thicknesses
from usdsdg_physics.scene.records import STATIC, Scene

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays

# Four updates of the app: as long as the tutorial scripts give a camera's collider to make room.
PUSH_TIME = 4.0 / 60.0  # s


class Depenetration:
    """Frees the center of a collider that appears inside bodies; otherwise a camera would look at their inside.

    PhysX pushes at the bodies' maxDepenetrationVelocity, 3 m/s, and in four updates gets a camera out of no body that
    is wider than 0.4 m. Here a body that contains the collider's center is pushed as fast as it takes, and keeps
    nothing of that speed; all others are pushed as in PhysX.
    """

    def __init__(
        self,
        scene: Scene,
        model: newton.Model,
        shape_index: dict[str, int],
        contacts: ContactArrays,
        free: wp.array,
        dof: wp.array,
    ) -> None:
        """Take for each body whether it is free to move by itself, and where its velocity is in joint_qd."""
        import warp as wp

        self._model, self._contacts = model, contacts
        # Whether the next step pushes at a collider; in all others nothing is launched.
        self.active = False
        colliders = scene.colliders.values()
        thickness = half_thicknesses(colliders, shape_index, len(shape_index))
        self._static = {shape_index[collider.path] for collider in colliders if collider.body == STATIC}
        limits = [body.max_depenetration_velocity for body in scene.bodies.values()]
        device = model.device
        self._time_left = wp.zeros(len(shape_index), dtype=wp.float32, device=device)
        self._any_left = wp.zeros(1, dtype=wp.int32, device=device)
        self._half_thickness = wp.array(thickness, dtype=wp.float32, device=device)
        self._authored_limits = wp.array(limits, dtype=wp.float32, device=device)
        self._free, self._dof = free, dof

    def activate(self, shapes: Collection[int]) -> None:
        """Begin to push at the static colliders, by shape index, that were switched on or moved."""
        self._set_time_left(self._static.intersection(shapes), PUSH_TIME)

    def deactivate(self, shapes: Collection[int]) -> None:
        """Stop pushing at colliders that were switched off."""
        if self.active:
            self._set_time_left(shapes, 0.0)

    def finish(self) -> None:
        """Find out whether the next step has something to push at, after one in which this was so."""
        self.active = bool(self._any_left.numpy()[0])

    def raise_velocities(self, state: newton.State) -> None:
        """Set each body's maximum depenetration velocity for the solver's next step."""
        import warp as wp

        from usdsdg_physics.corrections.overlaps.depenetration_kernels import raise_depenetration_velocity

        wp.launch(
            raise_depenetration_velocity,
            dim=self._contacts.shape0.size,
            inputs=[
                self._time_left,
                self._half_thickness,
                self._model.shape_body,
                state.body_q,
                self._contacts,
            ],
            outputs=[self._model.steel.rigid_body_max_depenetration_velocity],
            device=self._model.device,
        )

    def clamp_velocities(self, before: newton.State, after: newton.State, dt: float) -> None:
        """Take from the bodies the speed that depenetration gave them in the solver's step of `dt` seconds."""
        import warp as wp

        from usdsdg_physics.corrections.overlaps.depenetration_kernels import clamp_depenetration_velocity, count_down

        wp.launch(
            clamp_depenetration_velocity,
            dim=self._model.body_count,
            inputs=[self._any_left, self._free, self._dof, self._authored_limits, before.body_qd],
            outputs=[after.joint_qd, after.body_qd],
            device=self._model.device,
        )
        self._any_left.zero_()
        wp.launch(
            count_down,
            dim=self._time_left.size,
            inputs=[dt],
            outputs=[self._time_left, self._any_left],
            device=self._model.device,
        )
        wp.copy(self._model.steel.rigid_body_max_depenetration_velocity, self._authored_limits)

    def _set_time_left(self, shapes: Collection[int], seconds: float) -> None:
        if not shapes:
            return
        time_left = self._time_left.numpy().copy()
        time_left[list(shapes)] = seconds
        self._time_left.assign(time_left)
        self.active = bool((time_left > 0.0).any())
        self._any_left.fill_(int(self.active))
