"""Axes of the world along which bodies do not move, and about which they do not turn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.records import Scene

if TYPE_CHECKING:
    import newton
    import warp as wp


class LockedAxes:
    """Takes from bodies, after each step of the solver, the motion along and about their locked axes."""

    def __init__(self, scene: Scene, model: newton.Model, coordinate: wp.array, dof: wp.array) -> None:
        """Take for each body where it is in joint_q and joint_qd; no axes of links are locked."""
        import warp as wp

        self._model, self._coordinate, self._dof = model, coordinate, dof
        dynamic = np.array([not body.kinematic for body in scene.bodies.values()])
        position, rotation = (
            np.array([getattr(body, f"locked_{kind}") for body in scene.bodies.values()], np.int32) * dynamic
            for kind in ("position", "rotation")
        )
        self._position, self._rotation = (
            wp.array(masks.astype(np.int32), dtype=wp.int32, device=model.device) for masks in (position, rotation)
        )

    def begin(self, state: newton.State) -> None:
        """Take velocities that users set along and about locked axes from the state before a step."""
        import warp as wp

        from usdsdg_physics.corrections.bodies.locked_axes_kernels import lock_velocities

        wp.launch(
            lock_velocities,
            dim=self._model.body_count,
            inputs=[self._position, self._rotation, self._dof],
            outputs=[state.joint_qd, state.body_qd],
            device=self._model.device,
        )

    def apply(self, before: newton.State, after: newton.State) -> None:
        """Correct the state `after` the solver's step."""
        import warp as wp

        from usdsdg_physics.corrections.bodies.locked_axes_kernels import lock_axes

        wp.launch(
            lock_axes,
            dim=self._model.body_count,
            inputs=[
                self._position,
                self._rotation,
                self._coordinate,
                self._dof,
                self._model.body_com,
                before.body_q,
            ],
            outputs=[after.joint_q, after.joint_qd, after.body_q, after.body_qd],
            device=self._model.device,
        )
