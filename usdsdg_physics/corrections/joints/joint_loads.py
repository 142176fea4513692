"""What the load of joints does: those with a break force or torque break, friction grows with it."""

# Warp vectors are no classes to a type checker.
# pyright: reportArgumentType=false

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import newton
    import warp as wp


class JointLoads:
    """Looks, after each step of the solver, at the force and torque that joints pass on to their child bodies."""

    def __init__(
        self,
        model: newton.Model,
        breakable: Sequence[tuple[int, float, float]],
        rubbing: Sequence[tuple[int, int, float, float]],
    ) -> None:
        """Take joints by Newton's numbers.

        Args:
            breakable: of joints that break: number, force [N] and torque [N m].
            rubbing: of axes with friction: joint, number of the axis in joint_qd, friction [N, N m], and friction per
                load. The solver has a drive to no velocity for each, whose strength is the friction.
        """
        import warp as wp

        device = model.device
        self._model = model
        self._breakable = wp.array([row[0] for row in breakable], dtype=wp.int32, device=device)
        self._limits = wp.array([row[1:] for row in breakable], dtype=wp.vec2, device=device)
        self._broken = wp.zeros(len(breakable), dtype=wp.int32, device=device)
        self._rubbing = wp.array([row[:2] for row in rubbing], dtype=wp.vec2i, device=device)
        self._friction = wp.array([row[2:] for row in rubbing], dtype=wp.vec2, device=device)
        self._more = wp.zeros(model.body_count, dtype=wp.spatial_vector, device=device)
        self._has_more = False

    def add(self, wrenches: np.ndarray | None) -> None:
        """Add forces [N] and torques [N m] (N, 6) to those that the solver tells of in the next step; None for none."""
        if wrenches is not None:
            self._more.assign(wrenches.astype(np.float32))
        elif self._has_more:
            self._more.zero_()
        self._has_more = wrenches is not None

    def apply(self, before: newton.State, wrench: wp.array) -> None:
        """Note which joints break under the `wrench` (N,) at each body's center of mass, and set friction by it.

        before: the state at the begin of the solver's step, where its forces act.
        """
        import warp as wp

        from usdsdg_physics.corrections.joints.joint_loads_kernels import note_broken, set_friction

        wp.launch(
            note_broken,
            dim=self._broken.size,
            inputs=[
                self._breakable,
                self._limits,
                self._model.joint_child,
                self._model.joint_X_c,
                self._model.body_com,
                before.body_q,
                wrench,
                self._more,
            ],
            outputs=[self._broken],
            device=self._model.device,
        )
        wp.launch(
            set_friction,
            dim=self._rubbing.size,
            inputs=[self._rubbing, self._friction, self._model.joint_child, wrench, self._more],
            outputs=[self._model.joint_effort_limit],
            device=self._model.device,
        )

    def broken(self) -> np.ndarray:
        """Return the rows of `breakable` that have broken."""
        return np.flatnonzero(self._broken.numpy())
