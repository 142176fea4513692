"""Turn and move bodies that touch nothing: as far as they spin, and by whole steps, however many substeps."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


class FreeFlight:
    """Which bodies touch nothing during a step, and where they end.

    PhysX advances a body by the velocity that it has at the end of the step: in free fall, by g dt² n(n+1)/2 after n
    steps. The substeps of the solver, which contacts need, would leave it g dt² n/2 (1 - 1/k) higher with k of them.
    Newton's solver integrates rotations linearly, by twice the arctangent of half the angle: 2 % too little at 60 rad/s
    and 120 substeps a second, and the angular momentum of uneven bodies sways.
    """

    def __init__(
        self, model: newton.Model, free: wp.array, coordinate: wp.array, dof: wp.array, contacts: ContactArrays
    ) -> None:
        """Take for each body whether it is free to move by itself, and where it is in joint_q and joint_qd."""
        import warp as wp

        self._model, self._free, self._coordinate, self._contacts = model, free, coordinate, contacts
        self._dof = dof
        self.touched = wp.zeros(model.body_count, dtype=wp.int32, device=model.device)
        self._start = wp.zeros(model.body_count, dtype=wp.transform, device=model.device)

    def begin(self, state: newton.State) -> None:
        """Remember where the bodies are at the begin of a step."""
        import warp as wp

        assert state.body_q is not None
        self.touched.zero_()
        wp.copy(self._start, state.body_q)

    def note_contacts(self, visited: int) -> None:
        """Note which bodies the contacts belong to that the pipeline just found, at most `visited`."""
        import warp as wp

        from usdsdg_physics.corrections.bodies.free_flight_kernels import note_touched

        wp.launch(
            note_touched,
            dim=visited,
            inputs=[self._model.shape_body, self._contacts],
            outputs=[self.touched],
            device=self._model.device,
        )

    def turn(self, before: newton.State, after: newton.State, dt: float) -> None:
        """Turn bodies that touch nothing for a substep of `dt` seconds, so that they keep their angular momentum."""
        import warp as wp

        from usdsdg_physics.corrections.bodies.free_flight_kernels import turn_bodies

        model: Any = self._model
        wp.launch(
            turn_bodies,
            dim=model.body_count,
            inputs=[
                self._free,
                self._coordinate,
                self._dof,
                model.body_com,
                model.body_inv_inertia,
                model.steel.rigid_body_angular_damping,
                self.touched,
                before.body_f,
                before.body_q,
                before.body_qd,
                dt,
            ],
            outputs=[after.joint_q, after.joint_qd, after.body_q, after.body_qd],
            device=model.device,
        )

    def finish(self, state: newton.State, dt: float) -> None:
        """Move the centers of mass of all other bodies to where `dt` seconds at their velocity bring them."""
        import warp as wp

        from usdsdg_physics.corrections.bodies.free_flight_kernels import move_untouched

        wp.launch(
            move_untouched,
            dim=self._model.body_count,
            inputs=[self._free, self._coordinate, self._model.body_com, self.touched, self._start, state.body_qd, dt],
            outputs=[state.joint_q, state.body_q],
            device=self._model.device,
        )
