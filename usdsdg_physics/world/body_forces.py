"""The forces of the next step: gravity that is switched off for single bodies, and what pushes them."""

# Newton declares the arrays of models and states optional; after `finalize` all are there.
# pyright: reportOptionalMemberAccess=false, reportArgumentType=false

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.records import Scene
from usdsdg_physics.world.halves import Halves

if TYPE_CHECKING:
    import newton

    from usdsdg_physics.model.build import BuiltModel
    from usdsdg_physics.world.body_states import Indices


class BodyForces:
    """What `body_f` of both states holds; bodies without gravity get the opposite force."""

    def __init__(
        self, scene: Scene, built: BuiltModel, states: tuple[newton.State, newton.State], halves: Halves
    ) -> None:
        bodies = scene.bodies.values()
        self._states, self._halves, self._mass = states, halves, built.mass
        self._dynamic = np.array([not body.kinematic for body in bodies], bool)
        # (N + halves,) whether gravity acts on a body.
        self.gravity_enabled = np.array([body.gravity and not body.kinematic for body in bodies], bool)
        self._gravity = np.asarray(scene.gravity, np.float64)
        self._wrenches: np.ndarray | None = None  # (N + halves, 6) of the next step

    @property
    def push(self) -> bool:
        """Whether wrenches push bodies during the next step."""
        return self._wrenches is not None

    def set_gravity(self, gravity: np.ndarray) -> None:
        """Set the scene's gravity (3,) [m/s²]."""
        self._gravity = gravity
        self.apply()

    def enable_gravity(self, enabled: Mapping[int, bool]) -> None:
        """Switch gravity on or off for single bodies; it never acts on kinematic ones."""
        for index, on in enabled.items():
            self.gravity_enabled[self._halves.whole == index] = on and self._dynamic[index]
        self.apply()

    def add_wrenches(self, indices: Indices, wrenches: np.ndarray) -> None:
        """Push bodies during the next step: force [N] and torque about the center of mass [N m] (n, 6), world."""
        if not len(indices):
            return
        if self._wrenches is None:
            self._wrenches = np.zeros((len(self._halves), 6))
        np.add.at(self._wrenches, indices, wrenches)
        self._wrenches[~self._dynamic] = 0.0

    def wrenches(self) -> dict[int, np.ndarray]:
        """Return what pushes bodies during the next step (6,), by index."""
        if self._wrenches is None:
            return {}
        return {int(row): self._wrenches[row] for row in np.flatnonzero(self._wrenches.any(axis=1))}

    def forget_wrenches(self) -> None:
        """Let what pushed during a step end with it."""
        if self._wrenches is not None:
            self._wrenches = None
            self.apply()

    def apply(self) -> None:
        """Write the forces to both states, which keep them."""
        force = np.zeros((len(self._halves), 6)) if self._wrenches is None else self._wrenches.copy()
        weightless = ~self.gravity_enabled & self._dynamic
        force[weightless, :3] -= self._mass[weightless, None] * self._gravity
        for state in self._states:
            state.body_f.assign(force.astype(np.float32))
