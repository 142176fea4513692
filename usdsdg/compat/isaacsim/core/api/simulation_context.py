"""`SimulationContext`: the clock of a stage, its physics, and callbacks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from pxr import Usd, UsdGeom

from usdsdg.app.app import App, get_app
from usdsdg.compat.carb.eventdispatcher import APP_UPDATE, get_eventdispatcher
from usdsdg.compat.isaacsim.core.api.physics_context import PhysicsContext
from usdsdg.compat.isaacsim.core.simulation_manager import SimulationManager
from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.isaacsim.core.utils.stage import clear_stage
from usdsdg.errors import warn_once
from usdsdg.session import stage_context
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline

_PLAY_SIMULATIONS = "/app/player/playSimulations"


class SimulationContext:
    """The one simulation of the session; a second call returns the first object, with a warning."""

    _is_set_up = False

    def __new__(cls, *_: object, **__: object) -> SimulationContext:
        if current().simulation_context is None:
            current().simulation_context = super().__new__(cls)
        return current().simulation_context

    def __init__(
        self,
        physics_dt: float | None = None,
        rendering_dt: float | None = None,
        stage_units_in_meters: float | None = None,
        physics_prim_path: str = "/physicsScene",
        sim_params: Mapping[str, Any] | None = None,
        set_defaults: bool = True,
        backend: str = "numpy",
        device: str | None = None,
        stage: Usd.Stage | None = None,
    ) -> None:
        """Set up the current stage: Z up, a PhysicsScene, and the lengths of physics steps and app updates [s].

        Args:
            stage_units_in_meters: by default 1 with `set_defaults`, else that of the stage.
            rendering_dt: by default 1/60 s with `set_defaults`, else the stage's time code.
            backend: Arrays of `isaacsim.core.prims`: "numpy", "torch" or "warp".
            device: Where they are: "cpu" or "cuda:N".
        """
        if self._is_set_up:
            warn_once("there is a SimulationContext or World already, which is returned; arguments are ignored")
            return
        if stage is not None:
            stage_context.set_stage(stage)
        state, current_stage = simulation(), stage_context.current_stage()
        get_timeline().stop()
        state.backend = backend
        if device is not None:
            SimulationManager.set_device(device)
        UsdGeom.SetStageUpAxis(current_stage, UsdGeom.Tokens.z)
        if stage_units_in_meters is not None or set_defaults:
            UsdGeom.SetStageMetersPerUnit(current_stage, float(stage_units_in_meters or 1.0))
        self._physics_context = PhysicsContext(physics_dt, physics_prim_path, sim_params, set_defaults)
        usual = 1.0 / 60.0 if set_defaults else 1.0 / current_stage.GetTimeCodesPerSecond()
        self.set_simulation_dt(rendering_dt=usual if rendering_dt is None else rendering_dt)
        self._callbacks: dict[str, dict[str, Callable[[], object]]] = {}
        self._forget_with_stage = stage_context.on_new_stage(self._on_new_stage)
        self._is_set_up = True

    @classmethod
    def instance(cls) -> SimulationContext | None:
        """Return the one object, or None."""
        return current().simulation_context

    @classmethod
    def clear_instance(cls) -> None:
        """Forget the one object, so that another can be made."""
        held: SimulationContext | None = current().simulation_context
        if held is not None and held._is_set_up:
            held.clear_all_callbacks()
            held._forget_with_stage()
        current().simulation_context = None
        simulation().backend, simulation().device = "numpy", "cpu"

    def _on_new_stage(self, stage: Usd.Stage) -> None:
        type(self).clear_instance()

    # --- state ---
    @property
    def app(self) -> App:
        return get_app()

    @property
    def stage(self) -> Usd.Stage:
        return stage_context.current_stage()

    @property
    def current_time(self) -> float:
        """Return the simulated time [s] since the simulation last stopped."""
        return simulation().time

    @property
    def current_time_step_index(self) -> int:
        """Return the number of physics steps since the simulation last stopped."""
        return simulation().steps

    @property
    def backend(self) -> str:
        return simulation().backend

    @property
    def device(self) -> str:
        return simulation().device

    @property
    def physics_sim_view(self) -> object | None:
        return SimulationManager.get_physics_sim_view()

    def get_physics_context(self) -> PhysicsContext:
        return self._physics_context

    def is_simulating(self) -> bool:
        """Whether physics is ready to step."""
        return simulation().ready

    def is_playing(self) -> bool:
        return get_timeline().is_playing()

    def is_stopped(self) -> bool:
        return get_timeline().is_stopped()

    # --- lengths of steps ---
    def set_simulation_dt(self, physics_dt: float | None = None, rendering_dt: float | None = None) -> None:
        """Set the lengths of physics steps and app updates [s]; what is not given stays.

        With `physics_dt` 0 `step` takes no physics steps. With `rendering_dt` 0 updates leave the timeline where it is,
        and `step` takes one physics step.

        Raises:
            ValueError: a length is negative.
        """
        if physics_dt is not None:
            self._physics_context.set_physics_dt(physics_dt)
        if rendering_dt is None:
            return
        if rendering_dt < 0:
            raise ValueError(f"rendering_dt {rendering_dt} is negative")
        get_app().set_seconds_of_update(None if rendering_dt > 0 else 0.0)
        if rendering_dt > 0:
            get_timeline().set_time_codes_per_second(1.0 / rendering_dt)

    def get_physics_dt(self) -> float:
        return self._physics_context.get_physics_dt()

    def get_rendering_dt(self) -> float:
        return get_app().seconds_of_update()

    # --- the clock ---
    def initialize_physics(self) -> None:
        """Begin to simulate: one physics step is taken, as when PhysX warms up."""
        SimulationManager.initialize_physics()

    def play(self) -> None:
        """Play the timeline, and run an app update without physics."""
        get_timeline().play()
        self.render()

    def pause(self) -> None:
        """Pause the timeline, and run an app update without physics."""
        get_timeline().pause()
        self.render()

    def stop(self) -> None:
        """Stop the timeline, which restores bodies, and run an app update without physics."""
        get_timeline().stop()
        self.render()

    def reset(self, soft: bool = False) -> None:
        """Stop, then play, and take the step with which PhysX warms up; nothing if `soft`."""
        if soft:
            return
        if not self.is_stopped():
            self.stop()
        self.initialize_physics()
        self.play()

    def step(self, render: bool = True, update_fabric: bool = False) -> None:
        """Run an app update with its physics; without `render` take one physics step if the timeline plays.

        Where the length of physics steps was set to 0, there is none; where that of updates was, there is one step
        before the update.
        """
        simulates, updates_simulate = self.get_physics_dt() > 0.0, self.get_rendering_dt() > 0.0
        if render and simulates and updates_simulate:
            get_app().update()
            return
        if simulates and self.is_playing() and not (render and updates_simulate):
            simulation().step()
        if render:
            self.render()

    def render(self) -> None:
        """Run an app update without physics."""
        with _physics_held():
            get_app().update()

    def clear(self) -> None:
        """Remove all prims but PhysicsScenes, /World and those of the renderer."""
        keep = {"/World", *(scene.path for scene in SimulationManager.get_physics_scenes())}
        clear_stage(lambda path: path not in keep and not path.startswith("/Render"))

    # --- the clock, awaited ---
    async def initialize_simulation_context_async(self) -> None:
        await get_app().next_update_async()

    async def play_async(self) -> None:
        get_timeline().play()
        await self.render_async()

    async def pause_async(self) -> None:
        get_timeline().pause()
        await self.render_async()

    async def stop_async(self) -> None:
        get_timeline().stop()
        await self.render_async()

    async def reset_async(self, soft: bool = False) -> None:
        """Do what `reset` does, and wait for its updates."""
        if soft:
            return
        if not self.is_stopped():
            await self.stop_async()
        self.initialize_physics()
        await self.play_async()

    async def render_async(self) -> None:
        """Wait for an app update without physics."""
        with _physics_held():
            await get_app().next_update_async()

    # --- callbacks ---
    def add_physics_callback(self, callback_name: str, callback_fn: Callable[[float], Any]) -> None:
        """Call `callback_fn(dt)` before each physics step."""
        self._add("physics", callback_name, lambda: simulation().on_step(lambda dt, _: callback_fn(dt), before=True))

    def add_render_callback(self, callback_name: str, callback_fn: Callable[[Any], Any]) -> None:
        """Call `callback_fn(event)` at each app update."""
        self._add("render", callback_name, lambda: _observed([APP_UPDATE], callback_fn))

    def add_timeline_callback(self, callback_name: str, callback_fn: Callable[[Any], Any]) -> None:
        """Call `callback_fn(event)` at the events of the timeline, with types of `TimelineEventType`."""
        stream = get_timeline().get_timeline_event_stream()
        self._add("timeline", callback_name, lambda: stream.create_subscription_to_pop(callback_fn).unsubscribe)

    def add_stage_callback(self, callback_name: str, callback_fn: Callable[[Any], Any]) -> None:
        """Call `callback_fn(event)` at the events of the stage, with types of `omni.usd.StageEventType`."""
        stream = current().stage_events.stage
        self._add("stage", callback_name, lambda: stream.create_subscription_to_pop(callback_fn).unsubscribe)

    def remove_physics_callback(self, callback_name: str) -> None:
        self._remove("physics", callback_name)

    def remove_render_callback(self, callback_name: str) -> None:
        self._remove("render", callback_name)

    def remove_timeline_callback(self, callback_name: str) -> None:
        self._remove("timeline", callback_name)

    def remove_stage_callback(self, callback_name: str) -> None:
        self._remove("stage", callback_name)

    def physics_callback_exists(self, callback_name: str) -> bool:
        return callback_name in self._callbacks.get("physics", {})

    def render_callback_exists(self, callback_name: str) -> bool:
        return callback_name in self._callbacks.get("render", {})

    def timeline_callback_exists(self, callback_name: str) -> bool:
        return callback_name in self._callbacks.get("timeline", {})

    def stage_callback_exists(self, callback_name: str) -> bool:
        return callback_name in self._callbacks.get("stage", {})

    def clear_physics_callbacks(self) -> None:
        self._clear("physics")

    def clear_render_callbacks(self) -> None:
        self._clear("render")

    def clear_timeline_callbacks(self) -> None:
        self._clear("timeline")

    def clear_stage_callbacks(self) -> None:
        self._clear("stage")

    def clear_all_callbacks(self) -> None:
        for kind in list(getattr(self, "_callbacks", {})):
            self._clear(kind)

    def _add(self, kind: str, name: str, subscribe: Callable[[], Callable[[], object]]) -> None:
        held = self._callbacks.setdefault(kind, {})
        if name in held:
            warn_once(f"there is a {kind} callback {name!r} already, which stays")
            return
        held[name] = subscribe()

    def _remove(self, kind: str, name: str) -> None:
        end = self._callbacks.get(kind, {}).pop(name, None)
        if end is None:
            warn_once(f"there is no {kind} callback {name!r} to remove")
            return
        end()

    def _clear(self, kind: str) -> None:
        for name in list(self._callbacks.get(kind, {})):
            self._remove(kind, name)


@contextmanager
def _physics_held() -> Iterator[None]:
    """Turn off what app updates do to physics; it is on afterward, as in Isaac Sim, whatever it was before."""
    get_settings().set(_PLAY_SIMULATIONS, False)
    try:
        yield
    finally:
        get_settings().set(_PLAY_SIMULATIONS, True)


def _observed(names: list[str], callback: Callable[[Any], Any]) -> Callable[[], object]:
    """Call `callback` at these events; return what ends it."""
    observers = [get_eventdispatcher().observe_event(event_name=name, on_event=callback) for name in names]
    return lambda: [observer.reset() for observer in observers]
