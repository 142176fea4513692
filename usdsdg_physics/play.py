"""One play of a stage, from `play` to `stop`: everything that is derived from the stage meanwhile."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from pxr import Usd

from usdsdg.errors import PhysicsError, warn_once
from usdsdg.stage.changes import ChangeTracker
from usdsdg_physics.edits.apply_edits import apply_edits
from usdsdg_physics.edits.edit_reader import EditReader, Edits
from usdsdg_physics.model.compile_kernels import Progress
from usdsdg_physics.parse.attributes import value
from usdsdg_physics.parse.convex_hulls import HullCache
from usdsdg_physics.parse.scene import Units, parse
from usdsdg_physics.queries.scene_queries import Queries
from usdsdg_physics.scene.records import Scene
from usdsdg_physics.world.world import World
from usdsdg_physics.writeback.restore import Backup
from usdsdg_physics.writeback.stage_writer import Writer

STEPS_PER_SECOND = 60.0


class Session:
    """Reads the stage once, then only what changes; writes every step back. The solver is built at the first step."""

    def __init__(
        self, stage: Usd.Stage, hulls: HullCache, *, device: str | None = None, progress: Progress | None = None
    ) -> None:
        self._stage, self._hulls, self._device, self._progress = stage, hulls, device, progress
        self._tracker = ChangeTracker(stage)
        self._backup = Backup()
        # Room for contacts, as a multiple of what scenes usually need.
        self._capacity = 1.0
        self._outgrown = False
        self.world: World | None = None
        self._asleep: set[str] = set()  # of bodies, for when the world is built
        self._met: set[str] = set()  # bodies that have been simulated
        self._read_stage()

    def step(self, dt: float) -> None:
        """Take over what users changed, advance by `dt` seconds, show the result on the stage."""
        world = self._world_as_edited()
        if not world.bodies:
            return
        world.step(dt)
        self._look_after(world)
        self._show(world)

    def put_to_sleep(self, bodies: Collection[str]) -> None:
        """Take the speed of bodies, here and on the stage, and hold them until something that moves touches them."""
        world = self._world_as_edited()
        rows = [world.body_index[path] for path in bodies if path in world.body_index]
        if rows:
            world.put_to_sleep(rows)
            self._show(world)

    def wake_up(self, bodies: Collection[str]) -> None:
        """Let bodies that sleep or rest move again."""
        world = self._world_as_edited()
        world.wake([world.body_index[path] for path in bodies if path in world.body_index])

    def reset(self, bodies: Collection[str]) -> None:
        """Give bodies the poses and velocities back that they had before this play; takes effect at the next step."""
        self._backup.put_back(bodies)

    def steps_per_second(self) -> float:
        """The PhysicsScene's step rate, as it is now.

        Raises:
            PhysicsError: it is not positive.
        """
        if not self.scene.scene_path:
            return STEPS_PER_SECOND
        prim = self._stage.GetPrimAtPath(self.scene.scene_path)
        rate = float(value(prim, "physxScene:timeStepsPerSecond", STEPS_PER_SECOND)) if prim else STEPS_PER_SECOND
        if not rate > 0.0:
            raise PhysicsError(
                f"{self.scene.scene_path}: physxScene:timeStepsPerSecond is {rate:g}; set a positive number of steps"
            )
        return rate

    def end(self, *, restore: bool) -> None:
        """Stop listening; with `restore`, every attribute that was written says again what it said at the start."""
        self._tracker.close()
        if restore:
            self._backup.restore()

    def _world_as_edited(self) -> World:
        self._take_edits()
        if self.world is None:
            self.world = World(self.scene, device=self._device, capacity=self._capacity, progress=self._progress)
            self.world.put_to_sleep([self.world.body_index[path] for path in self._asleep & self.scene.bodies.keys()])
            self._met |= self.scene.bodies.keys()
        return self.world

    def _show(self, world: World) -> None:
        self.poses = world.poses()
        with self._tracker.muted():
            self._writer.write(self.poses, world.velocities())

    def _read_stage(self) -> None:
        self._units = Units.of(self._stage)
        self.scene = parse(self._stage, self._hulls)
        new = {path for path, body in self.scene.bodies.items() if body.starts_asleep and path not in self._met}
        self._asleep = new | set(self.world.asleep() if self.world is not None else ())
        self._tracker.take()
        self._reader = EditReader(self._stage, self.scene, self._hulls)
        self.queries = Queries(self.scene)
        self.poses = initial_poses(self.scene)
        self.world = None
        self._make_writer()

    def _make_writer(self) -> None:
        with self._tracker.muted():
            self._writer = Writer(self._stage, self.scene.bodies, self._backup, meters_per_unit=self._units.meters)
        if self.world is not None:
            self._writer.set_known(self.world.poses(), self.world.velocities())

    def _take_edits(self) -> None:
        changes = self._tracker.take()
        edits = self._reader.read(changes) if changes else Edits()
        if edits.rebuild or self._outgrown or (edits and self.world is None):
            self._outgrown = False
            self._read_stage()
            return
        if edits and self.world is not None:
            apply_edits(edits, self.world, self.scene, self.queries)
            self.poses = self.world.poses()
            self._writer.set_known(self.poses, self.world.velocities())
        if self._writer.is_stale(changes):
            self._make_writer()

    def _look_after(self, world: World) -> None:
        """What a long run has to survive: bodies that broke are named, and room for contacts grows."""
        for path in world.take_broken():
            warn_once(
                f"{path}: the solver gave a pose that is not a number, so the body was stopped where it was. Look for "
                "an extreme mass, velocity or scale on it, or for colliders that start deep inside each other.",
            )
        if world.lost_contacts:
            self._capacity *= 2.0
            self._outgrown = True


def initial_poses(scene: Scene) -> np.ndarray:
    """(N, 7) poses of the bodies as they were read."""
    return np.array([body.pose for body in scene.bodies.values()]).reshape(-1, 7)
