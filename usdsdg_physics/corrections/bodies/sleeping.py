"""Hold bodies that were put to sleep where they are, until a moving body touches them."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import newton
    import warp as wp

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


class Sleeping:
    """Which bodies are asleep. The solver moves them like all others; `Stabilization` then reverts their motion."""

    def __init__(
        self, model: newton.Model, contacts: ContactArrays, inertia_per_mass: wp.array, sleep_threshold: wp.array
    ) -> None:
        import warp as wp

        self._model, self._contacts = model, contacts
        self._inertia_per_mass, self._sleep_threshold = inertia_per_mass, sleep_threshold
        self.asleep = wp.zeros(model.body_count, dtype=wp.int32, device=model.device)
        self._was_asleep, self._woke = wp.zeros_like(self.asleep), wp.zeros(1, dtype=wp.int32, device=model.device)
        # Whether a body is asleep; in steps without one nothing is launched.
        self.any = False

    def set_asleep(self, bodies: Sequence[int] | np.ndarray, asleep: bool) -> None:
        """Put bodies to sleep, or wake them."""
        if not asleep and not self.any:
            return
        flags = self.asleep.numpy().copy()
        flags[bodies] = asleep
        self.asleep.assign(flags)
        self.any = bool(flags.any())

    def indices(self) -> np.ndarray:
        """Return the indices of the bodies that are asleep."""
        return np.flatnonzero(self.asleep.numpy()) if self.any else np.zeros(0, np.int64)

    def wake_touched(self, state: newton.State, dt: float) -> None:
        """Wake the bodies that a moving body will touch in the next `dt` seconds, before the solver's step."""
        import warp as wp

        from usdsdg_physics.corrections.bodies.sleeping_kernels import wake_touched_bodies

        def wake() -> None:
            self._woke.zero_()
            wp.launch(
                wake_touched_bodies,
                dim=self._contacts.shape0.size,
                inputs=[
                    self._model.shape_body,
                    self._was_asleep,
                    state.body_q,
                    state.body_qd,
                    self._model.body_com,
                    self._inertia_per_mass,
                    self._sleep_threshold,
                    self._contacts,
                    dt,
                ],
                outputs=[self.asleep, self._woke],
                device=self._model.device,
            )

        wp.copy(self._was_asleep, self.asleep)
        # A body that has just been woken wakes its neighbors.
        self._woke.fill_(1)
        wp.capture_while(self._woke, wake)

    def finish(self) -> None:
        """Find out whether a body is still asleep, after a step in which this was so."""
        self.any = bool(self.asleep.numpy().any())
