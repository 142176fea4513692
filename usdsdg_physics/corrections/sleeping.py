"""Bodies that somebody put to sleep: held where they are until something that moves touches them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import newton
    import warp as wp


class Sleepers:
    """Which bodies sleep. The solver moves them as all others; `kernels.settle` takes that back for those here."""

    def __init__(self, model: newton.Model, gyration: wp.array, sleep_threshold: wp.array) -> None:
        import warp as wp

        self._model, self._gyration, self._threshold = model, gyration, sleep_threshold
        self.asleep = wp.zeros(model.body_count, dtype=wp.int32, device=model.device)
        self._any = False

    def put(self, bodies: Sequence[int] | np.ndarray, *, asleep: bool) -> None:
        """Let bodies sleep, or wake them."""
        if not asleep and not self._any:
            return
        flags = self.asleep.numpy().copy()
        flags[bodies] = asleep
        self.asleep.assign(flags)
        self._any = bool(flags.any())

    def indices(self) -> np.ndarray:
        """Who sleeps now."""
        return np.flatnonzero(self.asleep.numpy()) if self._any else np.zeros(0, np.int64)

    def rouse(self, contacts: newton.Contacts, state: newton.State, dt: float) -> None:
        """Wake those that something moving will touch in the next `dt` seconds, before the solver's step."""
        import warp as wp

        from usdsdg_physics.corrections.sleeping_kernels import wake_touched

        if not self._any:
            return
        slept = wp.clone(self.asleep)
        before, left = -1, len(self.indices())
        # Who has just been woken wakes its neighbours.
        while left != before:
            wp.launch(
                wake_touched,
                dim=contacts.rigid_contact_max,
                inputs=[
                    self._model.shape_body,
                    slept,
                    state.body_q,
                    state.body_qd,
                    self._gyration,
                    self._threshold,
                    contacts.rigid_contact_count,
                    contacts.rigid_contact_shape0,
                    contacts.rigid_contact_shape1,
                    contacts.rigid_contact_point0,
                    contacts.rigid_contact_point1,
                    contacts.rigid_contact_normal,
                    contacts.rigid_contact_margin0,
                    contacts.rigid_contact_margin1,
                    dt,
                ],
                outputs=[self.asleep],
                device=self._model.device,
            )
            before, left = left, len(self.indices())
        self._any = left > 0
