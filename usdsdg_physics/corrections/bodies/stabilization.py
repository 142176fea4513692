"""Clamp velocities, hold bodies at rest or asleep, and revert steps that are not finite."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.records import Scene

if TYPE_CHECKING:
    import newton
    import warp as wp

# PhysX's wake counter.
REST_DELAY = 0.4  # s
# Fraction of the speed that gravity adds in one substep below which a body may be at rest.
REST_GRAVITY_FRACTION = 0.25


class Stabilization:
    """What happens to the bodies after each step of the solver."""

    def __init__(
        self,
        scene: Scene,
        model: newton.Model,
        inertia_per_mass: wp.array,
        sleep_threshold: wp.array,
        free: wp.array,
        coordinate: wp.array,
        dof: wp.array,
    ) -> None:
        """Take for each body whether it is free to move by itself, and where it is in joint_q and joint_qd."""
        import warp as wp

        bodies, device = list(scene.bodies.values()), model.device
        self._model = model
        self._inertia_per_mass, self._sleep_threshold = inertia_per_mass, sleep_threshold
        self._free, self._coordinate, self._dof = free, coordinate, dof
        self._max_velocity = wp.array([body.max_velocity for body in bodies], dtype=wp.float32, device=device)
        self._max_angular_velocity = wp.array(
            [body.max_angular_velocity for body in bodies], dtype=wp.float32, device=device
        )
        self.gravity_enabled = wp.zeros(len(bodies), dtype=wp.int32, device=device)
        self.rest_time = wp.zeros(len(bodies), dtype=wp.float32, device=device)
        self.nonfinite_steps = wp.zeros(len(bodies), dtype=wp.int32, device=device)
        self._gravity = wp.zeros(1, dtype=wp.float64, device=device)  # m/s²

    def set_gravity(self, gravity: np.ndarray) -> None:
        """Set the scene's gravity (3,) [m/s²]."""
        self._gravity.fill_(float(np.linalg.norm(gravity)))

    def set_gravity_enabled(self, enabled: np.ndarray) -> None:
        """Say of each body (N,) whether gravity acts on it; one without gravity is never held at rest."""
        self.gravity_enabled.assign(enabled.astype(np.int32))

    def wake(self, bodies: Sequence[int] | np.ndarray | None = None) -> None:
        """Let bodies at rest move again; None: all."""
        if bodies is None:
            self.rest_time.zero_()
            return
        rest_time = self.rest_time.numpy().copy()
        rest_time[bodies] = 0.0
        self.rest_time.assign(rest_time)

    def apply(
        self,
        before: newton.State,
        after: newton.State,
        dt: float,
        *,
        asleep: wp.array,
        squeezed: wp.array,
        neighbors: wp.array,
    ) -> None:
        """Correct the state `after` the solver's step of `dt` seconds.

        `asleep` (N,) marks the bodies to hold, `squeezed` (N,) those that are not at rest however slow they are, and
        `neighbors` (N,) counts the free bodies that touch each.
        """
        import warp as wp

        from usdsdg_physics.corrections.bodies.stabilization_kernels import stabilize_bodies

        wp.launch(
            stabilize_bodies,
            dim=self._model.body_count,
            inputs=[
                self._free,
                self._coordinate,
                self._dof,
                self.gravity_enabled,
                self._inertia_per_mass,
                self._sleep_threshold,
                asleep,
                squeezed,
                neighbors,
                self._max_velocity,
                self._max_angular_velocity,
                before.body_q,
                self._gravity,
                dt,
                REST_GRAVITY_FRACTION,
                REST_DELAY,
            ],
            outputs=[
                after.joint_q,
                after.joint_qd,
                after.body_q,
                after.body_qd,
                self.rest_time,
                self.nonfinite_steps,
            ],
            device=self._model.device,
        )

    def take_nonfinite(self) -> np.ndarray:
        """Return the indices of the bodies with a step that was not finite since the last call."""
        nonfinite = np.flatnonzero(self.nonfinite_steps.numpy())
        if len(nonfinite):
            self.nonfinite_steps.zero_()
        return nonfinite
