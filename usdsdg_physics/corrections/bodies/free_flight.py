"""Move bodies that touch nothing by whole steps, however many substeps these have."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


class FreeFlight:
    """Which bodies touch nothing during a step, and where they end.

    PhysX advances a body by the velocity that it has at the end of the step: in free fall, by g dt² n(n+1)/2 after n
    steps. The substeps of the solver, which contacts need, would leave it g dt² n/2 (1 - 1/k) higher with k of them.
    """

    def __init__(self, model: newton.Model, free: wp.array, coordinate: wp.array, contacts: ContactArrays) -> None:
        """Take for each body whether it is free to move by itself, and where its pose is in joint_q."""
        import warp as wp

        self._model, self._free, self._coordinate, self._contacts = model, free, coordinate, contacts
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
