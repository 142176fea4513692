"""`SimulationManager`: physics steps under a script's own control."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from usdsdg.compat.carb.eventdispatcher import get_eventdispatcher
from usdsdg.compat.isaacsim.core.simulation_manager.isaac_events import IsaacEvents
from usdsdg.compat.isaacsim.core.simulation_manager.manager_interface import InterfaceAttribute
from usdsdg.compat.isaacsim.core.simulation_manager.physics_scene import PhysicsScene
from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.isaacsim.core.simulation_manager.simulation_event import SimulationEvent
from usdsdg.compat.wrappers import bodies
from usdsdg.compat.wrappers.arrays import known_device
from usdsdg.errors import Unsupported, warn_once
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline
from usdsdg.warp_start import quiet_warp

_STEPS = {
    SimulationEvent.PHYSICS_PRE_STEP: True, IsaacEvents.PRE_PHYSICS_STEP: True,
    SimulationEvent.PHYSICS_POST_STEP: False, IsaacEvents.POST_PHYSICS_STEP: False,
}  # fmt: skip
_DEFAULT_ENGINE = "/exts/isaacsim.core.simulation_manager/default_engine"
_DELETIONS = (SimulationEvent.PRIM_DELETED, IsaacEvents.PRIM_DELETION)


class SimulationManager:
    """Class methods only: there is one simulation."""

    _simulation_manager_interface = InterfaceAttribute()

    # --- steps ---
    @classmethod
    def setup_simulation(cls, dt: float | None = None, device: str | None = None) -> None:
        """Define a PhysicsScene if there is none, and set its step [s] and the device of arrays."""
        for scene in simulation().scenes():
            if dt is not None:
                scene.set_dt(dt)
        if device is not None:
            cls.set_device(device)

    @classmethod
    def initialize_physics(cls) -> None:
        """Begin to simulate the stage: one step is taken, as when PhysX warms up; nothing if it has begun already."""
        simulation().initialize()

    @classmethod
    def invalidate_physics(cls) -> None:
        """Let the next `initialize_physics` begin again."""
        simulation().invalidate()

    @classmethod
    def step(
        cls,
        *,
        steps: int = 1,
        callback: Callable[[int, int], bool | None] | None = None,
        update_fabric: bool = False,
    ) -> None:
        """Take physics steps; the timeline stays. Poses are on the stage after each, as with `update_fabric`.

        Args:
            callback: Called with (number of the step from 1, `steps`) after each step; False ends the loop.
        """
        for number in range(1, steps + 1):
            simulation().step()
            if callback is not None and callback(number, steps) is False:
                return

    @classmethod
    def get_simulation_time(cls) -> float:
        """Return the simulated time [s] since the simulation last stopped."""
        return simulation().time

    @classmethod
    def get_num_physics_steps(cls) -> int:
        """Return the number of steps since the simulation last stopped."""
        return simulation().steps

    @classmethod
    def is_simulating(cls) -> bool:
        return bodies.is_simulating()

    @classmethod
    def is_paused(cls) -> bool:
        return not (get_timeline().is_playing() or get_timeline().is_stopped())

    @classmethod
    def get_physics_sim_view(cls) -> object | None:
        """Return an object once physics is ready, else None; it has no members, as there are no tensor views."""
        return simulation() if simulation().ready else None

    get_physics_simulation_view = get_physics_sim_view

    # --- scenes ---
    @classmethod
    def get_physics_scenes(cls) -> list[PhysicsScene]:
        return [PhysicsScene(path) for path in PhysicsScene.get_physics_scene_paths()]

    @classmethod
    def set_physics_dt(cls, dt: float = 1.0 / 60.0, physics_scene: str | None = None) -> None:
        """Set the length of a step [s] of one PhysicsScene or of all; 1/dt is rounded down to whole steps per second.

        Raises:
            RuntimeError: the timeline plays.
            ValueError: `dt` is not within 0 and 1.
        """
        if get_timeline().is_playing():
            raise RuntimeError("set_physics_dt: the timeline plays; stop it first")
        scenes = [simulation().scene(physics_scene)] if physics_scene else simulation().scenes()
        for scene in scenes:
            scene.set_dt(dt)

    @classmethod
    def get_physics_dt(cls, physics_scene: str | None = None) -> float:
        """Return the length of a step [s]."""
        return simulation().scene(physics_scene).get_dt()

    @classmethod
    def set_default_physics_scene(cls, physics_scene_prim_path: str) -> None:
        """Set the scene whose values are returned where none is named.

        Raises:
            ValueError: there is no such PhysicsScene.
        """
        if physics_scene_prim_path not in PhysicsScene.get_physics_scene_paths():
            raise ValueError(f"there is no PhysicsScene at {physics_scene_prim_path}")
        simulation().scene_path = physics_scene_prim_path

    @classmethod
    def get_default_physics_scene(cls) -> str | None:
        return simulation().scene_path

    # --- device and arrays ---
    @classmethod
    def set_device(cls, device: str) -> None:
        """Set where wrappers put their arrays, "cpu" or "cuda:N"; `--physics-device` of `usdsdg run` is for bodies."""
        simulation().device = known_device(str(device))

    set_physics_sim_device = set_device

    @classmethod
    def get_device(cls) -> Any:
        """Return the device as Warp's object."""
        quiet_warp()
        import warp as wp

        return wp.get_device(simulation().device)

    @classmethod
    def get_physics_sim_device(cls) -> str:
        return simulation().device

    @classmethod
    def set_backend(cls, val: str) -> None:
        """Set the arrays that `isaacsim.core.prims` returns: "numpy", "torch" or "warp"."""
        simulation().backend = val

    @classmethod
    def get_backend(cls) -> str:
        return simulation().backend

    # --- engine ---
    @classmethod
    def get_active_physics_engine(cls) -> str:
        """Return "newton"."""
        return "newton"

    @classmethod
    def get_default_engine(cls) -> str:
        """Return the engine that a setting of Isaac Sim names; where it names none, "newton"."""
        return str(get_settings().get(_DEFAULT_ENGINE) or cls.get_active_physics_engine())

    @classmethod
    def get_available_physics_engines(cls, verbose: bool = False) -> list[tuple[str, bool]]:
        """Return [("newton", True)]: (name, is active)."""
        return [("newton", True)]

    @classmethod
    def switch_physics_engine(cls, engine_name: str, verbose: bool = False) -> bool:
        """Return whether this is the engine here, Newton; a warning says that PhysX is not."""
        if engine_name.lower() != "newton":
            warn_once(f"switch_physics_engine({engine_name!r}): bodies are simulated by Newton")
        return engine_name.lower() == "newton"

    @classmethod
    def enable_fabric(cls, enable: bool) -> None:
        """Do nothing: there is no Fabric, and every step writes its result to the stage."""

    @classmethod
    def is_fabric_enabled(cls) -> bool:
        return False

    @classmethod
    def enable_usd_notice_handler(cls, flag: bool) -> None:
        """Do nothing: changes of the stage are read at the next step."""

    # --- settings of PhysX, which are kept on the stage ---
    @classmethod
    def enable_ccd(cls, flag: bool, physics_scene: str | None = None) -> None:
        cls._set(physics_scene, "EnableCCD", bool(flag))

    @classmethod
    def is_ccd_enabled(cls, physics_scene: str | None = None) -> bool:
        return simulation().scene(physics_scene).get_enabled_ccd()

    @classmethod
    def enable_gpu_dynamics(cls, flag: bool, physics_scene: str | None = None) -> None:
        cls._set(physics_scene, "EnableGPUDynamics", bool(flag))

    @classmethod
    def is_gpu_dynamics_enabled(cls, physics_scene: str | None = None) -> bool:
        return simulation().scene(physics_scene).get_enabled_gpu_dynamics()

    @classmethod
    def set_broadphase_type(cls, val: str, physics_scene: str | None = None) -> None:
        cls._set(physics_scene, "BroadphaseType", val)

    @classmethod
    def get_broadphase_type(cls, physics_scene: str | None = None) -> str:
        return simulation().scene(physics_scene).get_broadphase_type()

    @classmethod
    def set_solver_type(cls, solver_type: str, physics_scene: str | None = None) -> None:
        cls._set(physics_scene, "SolverType", solver_type)

    @classmethod
    def get_solver_type(cls, physics_scene: str | None = None) -> str:
        return simulation().scene(physics_scene).get_solver_type()

    @classmethod
    def enable_stablization(cls, flag: bool, physics_scene: str | None = None) -> None:
        cls._set(physics_scene, "EnableStabilization", bool(flag))

    @classmethod
    def is_stablization_enabled(cls, physics_scene: str | None = None) -> bool:
        return simulation().scene(physics_scene).get_enabled_stabilization()

    @classmethod
    def _set(cls, physics_scene: str | None, name: str, value: Any) -> None:
        scenes = [simulation().scene(physics_scene)] if physics_scene else simulation().scenes()
        for scene in scenes:
            scene.set(name, value)

    # --- callbacks ---
    @classmethod
    def register_callback(
        cls, callback: Callable[..., Any], event: SimulationEvent | IsaacEvents, *, order: int = 0, **_: object
    ) -> int:
        """Call `callback(event)` at each event, `callback(dt, context)` at each step; return its number.

        Raises:
            Unsupported: deletions of prims.
            ValueError: it is no event.
        """
        if not isinstance(event, (SimulationEvent, IsaacEvents)):
            raise ValueError(f"register_callback: {event!r} is neither a SimulationEvent nor one of IsaacEvents")
        if event in _DELETIONS:
            raise Unsupported(f"register_callback: {event} is not sent; ask prim.IsValid() when you need it")
        if event in _STEPS:
            return simulation().hold(simulation().on_step(callback, before=_STEPS[event], order=order))
        observer = get_eventdispatcher().observe_event(order=order, event_name=event.value, on_event=callback)
        return simulation().hold(observer.reset)

    @classmethod
    def deregister_callback(cls, uid: int) -> bool:
        """End the calls of a callback; return whether there is one with this number."""
        if simulation().release(uid):
            return True
        warn_once(f"deregister_callback({uid}): there is no such callback any more")
        return False

    @classmethod
    def deregister_all_callbacks(cls) -> None:
        simulation().release_all()

    @classmethod
    def assets_loading(cls) -> bool:
        """Return False: loading is synchronous."""
        return False

    @classmethod
    def enable_all_default_callbacks(cls, enable: bool = True) -> None:
        """Do nothing: there are no callbacks between the timeline and physics to turn off."""
