"""The physics engine: play, advance, stop, step listeners, and scene queries on one stage."""

import math
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike
from pxr import Usd

from usdsdg.errors import PhysicsError
from usdsdg.listeners import Listeners
from usdsdg.stage.time_code import time_code_at
from usdsdg_physics.parse.scene import parse
from usdsdg_physics.parse.shapes.convex_hulls import HullCache
from usdsdg_physics.play import PlaySession, initial_poses
from usdsdg_physics.queries.scene_queries import SceneQueries
from usdsdg_physics.queries.stage_queries import StageQueries
from usdsdg_physics.scene.body_masses import BodyMasses
from usdsdg_physics.scene.events import ContactEvent, TriggerEvent
from usdsdg_physics.settling import settle
from usdsdg_physics.simulated_bodies import SimulatedBodies
from usdsdg_physics.stage_joints import StageJoints
from usdsdg_physics.world.compile_kernels import Progress

# Fraction of a step that may be missing from the elapsed time without delaying the step to the next call: scripts write
# 0.0333 for two steps of 1/60 s, and physics would stay a step behind animated prims. What is missing is not made up.
_MISSING = 2.5e-3


class NewtonEngine(StageQueries, StageJoints):
    """Simulates the rigid bodies of one stage with Newton.

    Whatever is written to the stage between two steps (velocities, transforms, switches, new prims) takes effect at the
    next, and every step writes its result back.
    """

    def __init__(
        self,
        stage: Usd.Stage,
        *,
        device: str | None = None,
        progress: Progress | None = None,
        writes_velocities: Callable[[], bool] = lambda: True,
    ) -> None:
        """Prepare to simulate a stage.

        Args:
            device: "cpu", "cuda:0" or None for Warp's default.
            progress: is called while kernels compile.
            writes_velocities: whether steps of a play write them to the stage, as they do poses; asked when it begins.
        """
        self._writes_velocities = writes_velocities
        self._stage, self._device, self._progress = stage, device, progress
        self._hulls = HullCache(progress=progress)
        self._listeners: Listeners[[float]] = Listeners()
        self._listeners_before: Listeners[[float]] = Listeners()
        self._trigger_listeners: Listeners[[TriggerEvent]] = Listeners()
        self._contact_listeners: Listeners[[list[ContactEvent]]] = Listeners()
        self._all_listeners = (
            self._listeners,
            self._listeners_before,
            self._trigger_listeners,
            self._contact_listeners,
        )
        self._is_unread = False  # within `stage_unread`: steps do not write their results to the stage
        self.step_seconds = 0.0  # wall-clock time of the latest step
        self._session: PlaySession | None = None
        self._elapsed = 0.0
        self._time = 0.0  # of the stage at the end of the latest step [s]

    @property
    def is_playing(self) -> bool:
        """Whether `play` was called, and not yet `stop`."""
        return self._session is not None

    @property
    def rigid_bodies(self) -> tuple[str, ...]:
        """Paths of the rigid bodies that are simulated; empty while stopped."""
        bodies = self._session.scene.bodies.items() if self._session else ()
        return tuple(path for path, body in bodies if not body.is_collider)

    def play(self, *, time: float | None = None) -> None:
        """Begin to simulate, and remember the authored poses and velocities; does nothing while playing.

        Args:
            time: where the stage is in time [s], for what time samples move; None: at its start.
        """
        if self._session is None:
            start = self._stage.GetStartTimeCode() / self._stage.GetTimeCodesPerSecond()
            self._time = start if time is None else time
            self._session = PlaySession(
                self._stage,
                self._hulls,
                time=self._time_code(),
                device=self._device,
                progress=self._progress,
                writes_velocities=self._writes_velocities(),
            )
            self._elapsed = 0.0

    def stop(self, *, restore: bool = True) -> None:
        """End the simulation and restore poses and velocities from before `play`, in the layers that were written.

        Without `restore` everything stays where it is, as if authored there.
        """
        if self._session is not None:
            self._session.end(restore=restore)
            self._session = None

    def reset(self, bodies: Collection[str] | None = None) -> None:
        """Restart from the poses and velocities before `play`: all bodies, or those at these paths; if it plays."""
        if self._session is None:
            return
        if bodies is not None:
            self._session.reset(bodies)
            return
        time = self._time
        self.stop()
        self.play(time=time)

    def read_edits(self) -> None:
        """Take what has changed on the stage into account now: queries find it, and links go where bases were put."""
        if self._session is not None:
            self._session.show_edits()

    def put_to_sleep(self, bodies: Collection[str]) -> None:
        """Zero the velocities of the bodies at these paths and hold them where they are, gravity or not.

        A body wakes when one that moves faster than its own sleepThreshold touches it, when one that it touches wakes,
        when its pose, velocity or gravity is set, and by `wake_up`. Kinematic bodies stay as they are.

        Raises:
            PhysicsError: `play` has not been called; bodies that sleep from the start have physics:startsAsleep.
        """
        self._bodies("put_to_sleep").put_to_sleep(bodies)

    def wake_up(self, bodies: Collection[str]) -> None:
        """Let the bodies at these paths move again, whether asleep or at rest.

        Raises:
            PhysicsError: `play` has not been called.
        """
        self._bodies("wake_up").wake_up(bodies)

    def settle(self, bodies: Collection[str] | None = None, *, max_time: float = 10.0) -> list[str]:
        """Move bodies that overlap apart, then simulate with strong damping until they rest; listeners hear nothing.

        Args:
            bodies: paths of the bodies to wait for; None: all.
            max_time: simulated seconds after which it ends in any case.

        Returns:
            The paths of the bodies that are still faster than 1 mm/s.

        Raises:
            PhysicsError: `play` has not been called, or the step rate is not positive.
        """
        return settle(self._playing("settle"), bodies, max_time, self._time_code())

    def apply_forces(
        self,
        bodies: Sequence[str],
        forces: ArrayLike | None = None,
        torques: ArrayLike | None = None,
        *,
        positions: ArrayLike | None = None,
    ) -> None:
        """Push the bodies at these paths during the next step; pushes add up, and kinematic bodies do not move.

        Args:
            forces: (N, 3), world, in the stage's units of mass, length and s⁻².
            torques: (N, 3), world, likewise in mass, length² and s⁻².
            positions: (N, 3) world points where the forces act [stage units]; None: the centers of mass.

        Raises:
            PhysicsError: `play` has not been called, or a path is no rigid body.
        """
        shape = (len(bodies), 3)
        given = [
            np.full(shape, missing) if rows is None else np.asarray(rows, np.float64).reshape(shape)
            for rows, missing in ((forces, 0.0), (torques, 0.0), (positions, np.nan))
        ]
        self._bodies("apply_forces").push(bodies, *given)

    @property
    def writes_velocities(self) -> bool:
        """Whether the stage has the velocities of the bodies; it has while stopped."""
        return self._session is None or self._session.writes_velocities

    def velocities(self, bodies: Sequence[str]) -> np.ndarray:
        """Return the velocities (N, 6) of the bodies at these paths: linear [stage units/s], angular [rad/s]; world.

        They are those after the latest step and what was set since, also where they are not written to the stage.

        Raises:
            PhysicsError: `play` has not been called, or a path is no rigid body.
        """
        return self._bodies("velocities").velocities(bodies)

    def mass_properties(self, bodies: Sequence[str]) -> BodyMasses:
        """Return masses, centers of mass and inertias of the bodies at these paths, authored or found from shapes.

        Raises:
            PhysicsError: `play` has not been called, or a path is no rigid body.
        """
        return self._bodies("mass_properties").mass_properties(bodies)

    def close(self) -> None:
        """Release the stage without writing to it."""
        self.stop(restore=False)

    def advance(self, seconds: float, *, until: float | None = None, write: bool = True) -> int:
        """Advance time and take every fixed step that is due; the remainder counts for the next call.

        A step is also due where less than 1/400 of it is missing. Its length is read from the stage before each step
        (physxScene:timeStepsPerSecond, 60 by default).

        Args:
            until: where the stage is in time [s] at the end, for what time samples move; None: further by `seconds`.
            write: whether the stage has the result; if not, it must not be read or edited before a call with `write`.

        Returns:
            The number of steps taken.

        Raises:
            PhysicsError: `play` has not been called, the step rate is not positive, or the time is negative or NaN.
        """
        self._playing("advance")
        if not 0.0 <= seconds < math.inf:
            raise PhysicsError(
                f"advance({seconds}): physics does not go back in time. Give a number of seconds from 0 on."
            )
        self._elapsed += seconds
        end = self._time + self._elapsed if until is None else until
        steps = 0
        # A listener may stop the simulation.
        while self._session is not None:
            dt = 1.0 / self._session.steps_per_second()
            if self._elapsed < dt * (1.0 - _MISSING):
                break
            self._elapsed = max(0.0, self._elapsed - dt)
            # Only listeners read the stage between two steps, so without them poses are written once, after the last.
            is_last = write and self._elapsed < dt * (1.0 - _MISSING)
            self._step(dt, until=end - self._elapsed, write=is_last or any(self._all_listeners))
            steps += 1
        if write:
            self._catch_up()
        return steps

    @contextmanager
    def stage_unread(self) -> Iterator[None]:
        """Leave the results of steps within off the stage, which has that of the last one at the end.

        That is for steps between which nobody reads bodies from the stage, listeners included: writing takes
        about as long as a step. Of bodies nothing but velocities may be set there until then.
        """
        before, self._is_unread = self._is_unread, True
        try:
            yield
        finally:
            self._is_unread = before
            self._catch_up()

    def _catch_up(self) -> None:
        if self._session is not None and not self._is_unread:
            self._session.catch_up()

    def step(self, dt: float, *, until: float | None = None) -> None:
        """Take one step of `dt` seconds, whatever the step rate; listeners are called before and after it.

        `until` is where the stage is in time [s] at its end; None: further by `dt`.

        Raises:
            PhysicsError: `play` has not been called, or `dt` is not positive.
        """
        self._playing("step")
        if not 0.0 < dt < math.inf:
            raise PhysicsError(f"step({dt}): a physics step takes some time. Give a positive number of seconds.")
        self._step(dt, until=until, write=True)

    def _step(self, dt: float, *, until: float | None, write: bool) -> None:
        self._listeners_before.call(dt)
        if self._session is None:  # a listener may stop the simulation
            return
        start = time.perf_counter()
        self._time = self._time + dt if until is None else until
        self._session.step(dt, self._time_code(), write=write and not self._is_unread)
        self.step_seconds = time.perf_counter() - start
        self._report_events()
        self._listeners.call(dt)

    def subscribe_step(
        self, listener: Callable[[float], None], *, before: bool = False, heard: Callable[[], bool] | None = None
    ) -> Callable[[], None]:
        """Call `listener(dt)` after every step, when its result is on the stage; return the unsubscribe function.

        Args:
            before: whether it is called before the step, which takes what it writes to the stage into account.
            heard: of a listener that passes on what it hears, whether there is anybody to pass it to. Without anybody
                who listens, the stage has the result of the last step of `advance` alone.
        """
        return (self._listeners_before if before else self._listeners).subscribe(listener, heard=heard)

    def subscribe_triggers(
        self, listener: Callable[[TriggerEvent], None], *, heard: Callable[[], bool] | None = None
    ) -> Callable[[], None]:
        """Call `listener(event)` for each collider that entered or left a PhysxTriggerAPI in a step, after the step.

        Return the unsubscribe function. Triggers report before the listeners of the step are called. `heard` is as of
        `subscribe_step`.
        """
        return self._trigger_listeners.subscribe(listener, heard=heard)

    def subscribe_contacts(
        self, listener: Callable[[list[ContactEvent]], None], *, heard: Callable[[], bool] | None = None
    ) -> Callable[[], None]:
        """Call `listener(events)` after each step in which colliders with a PhysxContactReportAPI touch.

        Return the unsubscribe function. Contacts are reported before the listeners of the step are called. `heard` is
        as of `subscribe_step`.
        """
        return self._contact_listeners.subscribe(listener, heard=heard)

    @property
    def contacts(self) -> list[ContactEvent]:
        """The contacts of the latest step that are reported; none while stopped."""
        return list(self._session.contact_events) if self._session else []

    def _report_events(self) -> None:
        """Tell listeners what happened in the step that was just taken."""
        session = self._session
        if session is None:
            return
        triggers, contacts = session.trigger_events, session.contact_events
        session.trigger_events = []
        if contacts:
            self._contact_listeners.call(contacts)
        for event in triggers:
            self._trigger_listeners.call(event)

    def _queries(self) -> tuple[SceneQueries, np.ndarray]:
        """Return scene queries and body poses: those of the last step, or of a stopped stage as it is authored."""
        if self._session is not None:
            return self._session.queries, self._session.poses
        scene = parse(self._stage, self._hulls, time=self._time_code())
        return SceneQueries(scene), initial_poses(scene)

    def _playing(self, caller: str) -> PlaySession:
        if self._session is None:
            raise PhysicsError(f"the simulation is stopped; call play() before {caller}()")
        return self._session

    def _bodies(self, caller: str) -> SimulatedBodies:
        return SimulatedBodies(self._playing(caller))

    def _time_code(self) -> Usd.TimeCode:
        """Return the time of the latest step on the stage."""
        return time_code_at(self._time, self._stage)
