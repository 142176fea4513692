"""Bodies that moved until they became kinematic or were disabled: they stand from then on."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from usdsdg.stage.changes import Changes
from usdsdg_physics.edits.edit_reader import velocities_set
from usdsdg_physics.scene.records import Body

_STILL = (0.0, 0.0, 0.0)


class StoppedBodies:
    """Bodies whose velocity on the stage is what they had when they were stopped, and is none of theirs any more.

    A velocity that a user sets on a kinematic body moves its surface, so it must not be taken for one.
    """

    def __init__(self) -> None:
        self._paths: set[str] = set()

    def stop(
        self,
        bodies: dict[str, Body],
        before: Mapping[str, Body],
        simulated: Collection[str],
        changes: Changes,
    ) -> list[str]:
        """Take the velocity from `bodies`, as they were read after `changes`, that are or were stopped.

        Args:
            before: the bodies until now.
            simulated: those that have been in a world.

        Returns:
            The paths of those that moved until now.
        """
        moving = {path for path, body in bodies.items() if not body.kinematic}
        new = {path for path, body in before.items() if not body.kinematic and path in simulated} - moving
        new = {path for path in new if not velocities_set(path, changes).any()}
        self._paths |= new
        for path in self._paths & bodies.keys():
            bodies[path] = replace(bodies[path], velocity=_STILL, angular_velocity=_STILL)
        self._paths -= moving
        return sorted(new)

    def note(self, changes: Changes) -> None:
        """Let bodies have the velocities that users have set."""
        self._paths = {path for path in self._paths if not velocities_set(path, changes).any()}
