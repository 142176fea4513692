"""The rigid bodies of a running simulation, which scripts read, push, and put to sleep."""

from collections.abc import Collection, Sequence

import numpy as np

from usdsdg.errors import PhysicsError
from usdsdg.stage.poses.rotations import rotated
from usdsdg_physics.play import PlaySession
from usdsdg_physics.scene.body_masses import BodyMasses


class SimulatedBodies:
    """Reads and pushes bodies by path; a PhysicsError names a path that is no rigid body which is simulated."""

    def __init__(self, session: PlaySession) -> None:
        """The edits of the stage are applied before."""
        self._session, self._world = session, session.current_world()

    def put_to_sleep(self, bodies: Collection[str]) -> None:
        """Zero the velocities of bodies, here and on the stage, and hold them until a moving body touches them.

        Paths of others are left alone.
        """
        rows = [self._world.body_index[path] for path in bodies if path in self._world.body_index]
        if rows:
            self._world.put_to_sleep(rows)
            self._session.write()

    def wake_up(self, bodies: Collection[str]) -> None:
        """Let bodies move again that are asleep or at rest; paths of others are left alone."""
        self._world.wake([self._world.body_index[path] for path in bodies if path in self._world.body_index])

    def push(self, bodies: Sequence[str], forces: np.ndarray, torques: np.ndarray, points: np.ndarray) -> None:
        """Push bodies during the next step; see `NewtonEngine.apply_forces`."""
        rows, units = self._rows(bodies), self._session.units
        newtons, meters = units.kilograms * units.meters, units.meters
        poses = self._world.poses().astype(np.float64)[rows]
        centers = rotated(poses[:, 3:], self._world.center[rows]) + poses[:, :3]
        arms = np.where(np.isnan(points), 0.0, points * meters - centers)
        force = forces * newtons
        self._world.add_wrenches(rows, np.hstack([force, torques * newtons * meters + np.cross(arms, force)]))

    def velocities(self, bodies: Sequence[str]) -> np.ndarray:
        """Return the velocities (N, 6) of bodies; see `NewtonEngine.velocities`."""
        found = self._world.velocities().astype(np.float64)[self._rows(bodies)].reshape(-1, 6)
        found[:, :3] /= self._session.units.meters
        return found

    def mass_properties(self, bodies: Sequence[str]) -> BodyMasses:
        """Return the mass properties of bodies."""
        rows, units, world = self._rows(bodies), self._session.units, self._world
        return BodyMasses(
            world.mass[rows] / units.kilograms, world.center[rows] / units.meters, world.inertia[rows] / units.inertia
        )

    def _rows(self, bodies: Sequence[str]) -> np.ndarray:
        known = self._world.body_index
        if unknown := [path for path in bodies if path not in known]:
            raise PhysicsError(f"{unknown[0]} is not a simulated rigid body")
        return np.array([known[path] for path in bodies], int)
