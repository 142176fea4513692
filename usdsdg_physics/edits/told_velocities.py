"""Velocities that the stage told, for bodies whose velocities steps do not write there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from usdsdg.stage.changes import Changes
from usdsdg_physics.edits.edit_reader import velocities_set
from usdsdg_physics.scene.records import Body


class ToldVelocities:
    """Tells what a user has set on the stage since it was read from what is only out of date there."""

    def __init__(self) -> None:
        self._told: dict[str, np.ndarray] = {}  # by path of a body: (6,) m/s, rad/s

    def note(self, velocities: Mapping[str, np.ndarray]) -> None:
        """Note velocities (6,) of bodies that were read from the stage."""
        self._told.update(velocities)

    def go_on(
        self,
        bodies: dict[str, Body],
        velocities: Mapping[str, np.ndarray],
        changes: Changes,
        *,
        is_unwritten: Callable[[str], bool] = lambda _: True,
        is_same: Callable[[str], bool] = lambda _: True,
    ) -> None:
        """Give bodies that were read from the stage again the `velocities` (6,) that the simulation has.

        Not one that was set on the stage since: that is among the changes, or not what was read before.

        Args:
            is_unwritten: whether steps leave the velocities of a body off the stage.
            is_same: whether the body that was simulated at a path is the one that was read.
        """
        told = {
            path: np.array([*body.velocity, *body.angular_velocity])
            for path, body in bodies.items()
            if not body.kinematic and is_unwritten(path)
        }
        # What was kinematic has velocities of its own now.
        for path in filter(is_same, told.keys() & self._told.keys() & velocities.keys()):
            is_set = velocities_set(path, changes) | (told[path] != self._told[path])
            linear, angular = np.where(is_set, told[path], velocities[path]).reshape(2, 3).tolist()
            bodies[path] = replace(bodies[path], velocity=tuple(linear), angular_velocity=tuple(angular))
        self.note(told)
