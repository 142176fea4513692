"""Velocities that the stage told, for plays whose steps do not write velocities there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from usdsdg.stage.changes import Changes
from usdsdg_physics.edits.edit_reader import velocities_set
from usdsdg_physics.scene.records import Body
from usdsdg_physics.world.world import World


class ToldVelocities:
    """Tells what a user has set on the stage since it was read from what is only out of date there."""

    def __init__(self) -> None:
        self._told: dict[str, np.ndarray] = {}  # by path of a body: (6,) m/s, rad/s

    def note(self, velocities: Mapping[str, np.ndarray]) -> None:
        """Note velocities (6,) of bodies that were read from the stage."""
        self._told.update(velocities)

    def go_on(self, bodies: dict[str, Body], world: World | None, changes: Changes) -> None:
        """Give bodies that were read from the stage again the velocities that they have in the world.

        Not one that was set on the stage since: that is among the changes, or not what was read before.
        """
        told = {
            path: np.array([*body.velocity, *body.angular_velocity])
            for path, body in bodies.items()
            if not body.kinematic
        }
        if world is not None:
            moving = world.velocities().astype(np.float64)
            # What was kinematic has velocities of its own now.
            for path in told.keys() & self._told.keys() & world.body_index.keys():
                is_set = velocities_set(path, changes) | (told[path] != self._told[path])
                linear, angular = np.where(is_set, told[path], moving[world.body_index[path]]).reshape(2, 3).tolist()
                bodies[path] = replace(bodies[path], velocity=tuple(linear), angular_velocity=tuple(angular))
        self.note(told)
