"""The state of the simulation that `SimulationManager` and the wrappers of bodies share."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from pxr import Usd

from usdsdg.compat.carb.eventdispatcher import get_eventdispatcher
from usdsdg.compat.isaacsim.core.simulation_manager.isaac_events import IsaacEvents
from usdsdg.compat.isaacsim.core.simulation_manager.physics_scene import PhysicsScene
from usdsdg.compat.isaacsim.core.simulation_manager.simulation_event import SimulationEvent
from usdsdg.compat.isaacsim.core.simulation_manager.time_samples import TimeSamples
from usdsdg.session import engines, stage_context
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline

_READY_EVENTS = (
    SimulationEvent.SIMULATION_SETUP,
    IsaacEvents.PHYSICS_WARMUP,
    IsaacEvents.SIMULATION_VIEW_CREATED,
    IsaacEvents.PHYSICS_READY,
)


class Simulation:
    """Whether physics is ready, its time, and the callbacks of its steps."""

    def __init__(self) -> None:
        self.device, self.backend = "cpu", "numpy"
        self.samples = TimeSamples()
        self.scene_path: str | None = None
        self._step_callbacks: dict[int, tuple[bool, int, Callable[[float, Any], None]]] = {}
        self._held: dict[int, Callable[[], object]] = {}
        self._keys = itertools.count()
        self._begin_stage(stage_context.current_stage())
        get_timeline().subscribe(self._follow_timeline)
        stage_context.on_new_stage(self._begin_stage)
        engines.subscribe_step(lambda dt: self._call_back(dt, before=True), before=True)
        engines.subscribe_step(self._stepped)

    def _begin_stage(self, stage: Usd.Stage) -> None:
        self.ready, self.time, self.steps, self.scene_path = False, 0.0, 0, None
        self.samples.clear()
        self.release_all()

    def scenes(self) -> list[PhysicsScene]:
        """Return all PhysicsScenes; /PhysicsScene is defined when the stage has none."""
        return [PhysicsScene(path) for path in PhysicsScene.get_physics_scene_paths() or ("/PhysicsScene",)]

    def scene(self, path: str | None = None) -> PhysicsScene:
        """Return the PhysicsScene at a path, or the default one, or the first."""
        scenes = {scene.path: scene for scene in self.scenes()}
        return scenes.get(path or self.scene_path or "") or next(iter(scenes.values()))

    def initialize(self) -> None:
        """Begin to simulate and take the step with which PhysX warms up, once until the simulation stops."""
        if self.ready:
            return
        self.scenes()
        self.step()
        self._set_ready()

    def step(self) -> None:
        """Take one physics step, whether or not the timeline plays; its time stays."""
        physics = engines.physics()
        physics.play()
        physics.step(self.scene().get_dt())

    def invalidate(self) -> None:
        """Let the next `initialize` begin again."""
        self.ready = False

    def on_step(self, callback: Callable[[float, Any], None], *, before: bool, order: int = 0) -> Callable[[], bool]:
        """Call `callback(dt, context)` at every step once physics is ready, sorted by `order`; return what ends it."""
        key = next(self._keys)
        self._step_callbacks[key] = (before, order, callback)
        return lambda: self._step_callbacks.pop(key, None) is not None

    def hold(self, end: Callable[[], object]) -> int:
        """Keep what ends a callback under a number, until `release` or the next stage."""
        number = next(self._keys)
        self._held[number] = end
        return number

    def release(self, number: int) -> bool:
        """End a callback; return whether there was one."""
        end = self._held.pop(number, None)
        if end is not None:
            end()
        return end is not None

    def release_all(self) -> None:
        """End all callbacks."""
        for number in list(self._held):
            self.release(number)

    def _set_ready(self) -> None:
        self.ready = True
        for event in _READY_EVENTS:
            get_eventdispatcher().dispatch_event(event.value)

    def _stepped(self, dt: float) -> None:
        self.time, self.steps = self.time + dt, self.steps + 1
        self.samples.note(get_timeline().get_current_time(), self.time)
        self._call_back(dt, before=False)

    def _call_back(self, dt: float, *, before: bool) -> None:
        due = [
            (order, key) for key, (first, order, _) in self._step_callbacks.items() if first is before and self.ready
        ]
        for _, key in sorted(due):
            if key in self._step_callbacks:
                self._step_callbacks[key][2](dt, SimpleNamespace(simulation_id=0))

    def _follow_timeline(self, change: str) -> None:
        dispatch = get_eventdispatcher().dispatch_event
        if change == "play" and get_settings().get_as_bool("/app/player/playSimulations"):
            resumed, _ = self.ready, None if self.ready else self._set_ready()
            event = SimulationEvent.SIMULATION_RESUMED if resumed else SimulationEvent.SIMULATION_STARTED
            dispatch(event.value)
        elif change == "pause":
            dispatch(SimulationEvent.SIMULATION_PAUSED.value)
        elif change == "stop":
            self.ready, self.time, self.steps = False, 0.0, 0
            self.samples.clear()
            dispatch(SimulationEvent.SIMULATION_STOPPED.value)
            dispatch(IsaacEvents.TIMELINE_STOP.value)


def simulation() -> Simulation:
    """Return the simulation of the session."""
    return current().simulation
