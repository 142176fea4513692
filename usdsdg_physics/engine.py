"""The whole cycle: what users changed → substeps → poses and velocities on the stage → step listeners."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np
from pxr import Usd

from usdsdg.errors import PhysicsError, warn_once
from usdsdg.stage.changes import ChangeTracker
from usdsdg_physics.apply import apply_edits
from usdsdg_physics.approximation import HullCache
from usdsdg_physics.attributes import value
from usdsdg_physics.backup import Backup
from usdsdg_physics.edits import EditReader, Edits
from usdsdg_physics.parse import Units, parse
from usdsdg_physics.queries import Overlap, Queries, RayHit
from usdsdg_physics.records import Scene
from usdsdg_physics.warmup import Progress
from usdsdg_physics.world import World
from usdsdg_physics.writeback import Writer

STEPS_PER_SECOND = 60.0
# Time that binary fractions lose in an update must not delay its step to the next.
_ROUNDING = 1e-6


class NewtonEngine:
    """Simulates the rigid bodies of one stage. The stage stays the truth: whatever is written there between two steps
    (velocities, transforms, switches, new prims) takes effect at the next, and every step writes its result back."""

    def __init__(self, stage: Usd.Stage, *, device: str | None = None, progress: Progress | None = None) -> None:
        """`device` is "cpu", "cuda:0" or None for Warp's default; `progress` hears about kernels being compiled."""
        self._stage, self._device, self._progress = stage, device, progress
        self._hulls = HullCache()
        self._backup = Backup()
        self._listeners: dict[int, Callable[[float], None]] = {}
        self._keys = itertools.count()
        self._tracker: ChangeTracker | None = None
        self._scene: Scene | None = None
        self._world: World | None = None
        self._elapsed = 0.0

    @property
    def is_built(self) -> bool:
        """Whether kernels are compiled and bodies are in the solver."""
        return self._world is not None

    @property
    def is_playing(self) -> bool:
        return self._tracker is not None

    @property
    def rigid_bodies(self) -> tuple[str, ...]:
        """Paths of the bodies that are simulated; empty before `play`."""
        return tuple(self._scene.bodies) if self._scene else ()

    def play(self) -> None:
        """Remember poses and velocities as they are authored. Again while playing (after a pause) does nothing."""
        if self.is_playing:
            return
        self._tracker = ChangeTracker(self._stage)
        self._elapsed = 0.0
        self._read_stage()

    def stop(self) -> None:
        """Put poses and velocities back to what they were before `play`, in the layers that were written."""
        if self._tracker is None:
            return
        self._tracker.close()
        self._tracker = self._scene = self._world = None
        self._backup.restore()

    def release(self) -> None:
        """End the simulation and leave everything where it is."""
        if self._tracker is not None:
            self._tracker.close()
        self._tracker = self._scene = self._world = None
        self._backup = Backup()

    def advance(self, seconds: float) -> int:
        """Let time pass; take every fixed step that is due.

        The step length is read from the stage before each step (physxScene:timeStepsPerSecond, 60 by default).

        Returns:
            how many steps were taken.

        Raises:
            PhysicsError: `play` has not been called, or the step rate is not positive.
        """
        if self._tracker is None:
            raise PhysicsError("the simulation is stopped; call play() before advance()")
        self._elapsed += seconds
        steps = 0
        while self._elapsed * (rate := self._rate()) >= 1.0 - _ROUNDING:
            self._elapsed = max(0.0, self._elapsed - 1.0 / rate)
            self._step(1.0 / rate)
            steps += 1
        return steps

    def subscribe_step(self, listener: Callable[[float], None]) -> Callable[[], None]:
        """Call `listener(dt)` after every step, when the stage shows its result; returns the unsubscribe function."""
        key = next(self._keys)
        self._listeners[key] = listener
        return lambda: self._listeners.pop(key, None) and None

    def overlap_box(
        self, half_extent: Sequence[float], origin: Sequence[float], rotation_xyzw: Sequence[float] = (0, 0, 0, 1)
    ) -> list[Overlap]:
        """Switched-on colliders that share a point with a box [stage units], sorted by collider path."""
        queries, poses = self._asked()
        return queries.overlap_box(poses, self._meters(half_extent), self._meters(origin), rotation_xyzw)

    def overlap_sphere(self, radius: float, origin: Sequence[float]) -> list[Overlap]:
        """Switched-on colliders that share a point with a sphere [stage units], sorted by collider path."""
        queries, poses = self._asked()
        return queries.overlap_sphere(poses, radius * self._units.meters, self._meters(origin))

    def raycast(self, origin: Sequence[float], direction: Sequence[float], distance: float) -> RayHit | None:
        """The nearest switched-on collider along a ray [stage units], None when there is none within `distance`."""
        queries, poses = self._asked()
        meters = self._units.meters
        hit = queries.raycast(poses, self._meters(origin), direction, distance * meters)
        return hit and hit.scaled(1.0 / meters)

    def _read_stage(self) -> None:
        """Parse everything and get ready to write; the solver is built when the first step is due."""
        assert self._tracker is not None
        self._units = Units.of(self._stage)
        self._scene = parse(self._stage, self._hulls)
        self._tracker.take()
        self._reader = EditReader(self._stage, self._scene, self._hulls)
        self._queries = Queries(self._scene)
        self._world = None
        self._poses = np.array([body.pose for body in self._scene.bodies.values()]).reshape(-1, 7)
        self._make_writer()

    def _make_writer(self) -> None:
        assert self._tracker is not None
        assert self._scene is not None
        with self._tracker.muted():
            self._writer = Writer(self._stage, self._scene.bodies, self._backup, meters_per_unit=self._units.meters)
        if self._world is not None:
            self._writer.set_known(self._world.poses(), self._world.velocities())

    def _step(self, dt: float) -> None:
        world = self._current_world()
        if world.bodies:
            world.step(dt)
            self._warn_of_broken(world.take_broken())
            self._poses, velocities = world.poses(), world.velocities()
            with self._tracker.muted():
                self._writer.write(self._poses, velocities)
        for listener in list(self._listeners.values()):
            listener(dt)

    def _current_world(self) -> World:
        """The world with everything in it that users changed since the last step."""
        self._take_edits()
        if self._world is None:
            self._world = World(self._scene, device=self._device, progress=self._progress)
        elif not self._writer.is_current:
            self._make_writer()
        return self._world

    def _take_edits(self) -> None:
        changes = self._tracker.take()
        edits = self._reader.read(changes) if changes else Edits()
        if edits.rebuild or (edits and self._world is None):
            self._read_stage()
            return
        if edits:
            apply_edits(edits, self._world, self._scene, self._queries)
            self._poses = self._world.poses()
            self._writer.set_known(self._poses, self._world.velocities())
        moved = any(name.startswith("xformOp") for names in changes.changed.values() for name in names)
        if moved or changes.resynced or self._writer.lost_attributes(str(path) for path in changes.changed):
            self._make_writer()

    def _asked(self) -> tuple[Queries, np.ndarray]:
        """What a query looks at: bodies as the last step left them, or a stopped stage as it is authored."""
        if self.is_playing:
            return self._queries, self._poses
        self._units = Units.of(self._stage)
        scene = parse(self._stage, self._hulls)
        return Queries(scene), np.array([body.pose for body in scene.bodies.values()]).reshape(-1, 7)

    def _meters(self, vector: Sequence[float]) -> np.ndarray:
        return np.array([float(component) for component in vector]) * self._units.meters

    def _rate(self) -> float:
        prim = self._stage.GetPrimAtPath(self._scene.scene_path) if self._scene.scene_path else None
        rate = float(value(prim, "physxScene:timeStepsPerSecond", STEPS_PER_SECOND)) if prim else STEPS_PER_SECOND
        if not rate > 0.0:
            raise PhysicsError(
                f"{self._scene.scene_path}: physxScene:timeStepsPerSecond is {rate:g}; set a positive number of steps"
            )
        return rate

    @staticmethod
    def _warn_of_broken(paths: list[str]) -> None:
        for path in paths:
            warn_once(
                f"{path}: the solver gave a pose that is not a number, so the body was stopped where it was. Look for "
                "an extreme mass, velocity or scale on it, or for colliders that start deep inside each other.",
            )
