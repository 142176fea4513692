"""The damping of the velocities of bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from usdsdg_physics.scene.records import Scene
from usdsdg_physics.world.halves import Halves

if TYPE_CHECKING:
    import newton


class Damping:
    """The damping of each body [1/s], with which the solver and `LinkDamping` reduce velocities."""

    def __init__(self, model: newton.Model, halves: Halves) -> None:
        self._model: Any = model
        self._halves = halves

    def set(self, index: int, linear: float, angular: float) -> None:
        """Set the damping of one body [1/s]."""
        for name, damping in (("linear", linear), ("angular", angular)):
            array = getattr(self._model.steel, f"rigid_body_{name}_damping")
            values = array.numpy().copy()
            values[: len(self._halves)][self._halves.whole == index] = damping
            array.assign(values)

    def set_least(self, scene: Scene, damping: float) -> None:
        """Give every body at least this linear and angular damping [1/s], or its own where that is more."""
        bodies = scene.bodies.values()
        for name, own in (
            ("linear", [body.linear_damping for body in bodies]),
            ("angular", [body.angular_damping for body in bodies]),
        ):
            getattr(self._model.steel, f"rigid_body_{name}_damping").assign(
                np.maximum(own, damping).astype(np.float32)[self._halves.whole]
            )
