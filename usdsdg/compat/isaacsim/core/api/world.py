"""`World`: a simulation with a scene of objects and tasks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from usdsdg.compat.carb.eventdispatcher import get_eventdispatcher
from usdsdg.compat.isaacsim.core.api.loggers import DataLogger
from usdsdg.compat.isaacsim.core.api.scenes import Scene
from usdsdg.compat.isaacsim.core.api.simulation_context import SimulationContext
from usdsdg.compat.isaacsim.core.simulation_manager import IsaacEvents

if TYPE_CHECKING:
    from usdsdg.compat.isaacsim.core.api.tasks import BaseTask


class World(SimulationContext):
    """The one world of the process; see `SimulationContext`."""

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
    ) -> None:
        """Set up the current stage: see `SimulationContext`."""
        super().__init__(
            physics_dt,
            rendering_dt,
            stage_units_in_meters,
            physics_prim_path,
            sim_params,
            set_defaults,
            backend,
            device,
        )
        if not hasattr(self, "_scene"):
            self._scene = Scene()
            self._tasks: dict[str, BaseTask] = {}
            self._tasks_are_set_up = False
            self._data_logger = DataLogger()

    @property
    def scene(self) -> Scene:
        return self._scene

    # --- the clock ---
    def reset(self, soft: bool = False) -> None:
        """Set up tasks, stop and play, initialize the objects of the scene, and give them their default poses.

        `soft` only resets objects and tasks.
        """
        self._set_up_tasks()
        if not soft:
            self.stop()
        for task in self._tasks.values():
            task.cleanup()
        super().reset(soft)
        self._post_reset(soft)

    async def reset_async(self, soft: bool = False) -> None:
        """Do what `reset` does, and wait for its updates."""
        self._set_up_tasks()
        if not soft:
            await self.stop_async()
        for task in self._tasks.values():
            task.cleanup()
        await super().reset_async(soft)
        self._post_reset(soft)

    def step(self, render: bool = True, step_sim: bool = True, update_fabric: bool = False) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Prepare tasks, then step: see `SimulationContext.step`; without `step_sim` nothing else."""
        self._prepare_tasks()
        if step_sim:
            super().step(render, update_fabric)
        self._measure()

    def step_async(self, step_size: float | None = None) -> None:
        """Do what `step` does beside the step itself: scripts let it be called before physics steps of a timeline.

        `world.add_physics_callback("tasks", world.step_async)` is the usual way. It is no coroutine in spite of its
        name.
        """
        self._prepare_tasks()
        self._measure()

    def _prepare_tasks(self) -> None:
        for task in self._tasks.values() if self._tasks_are_set_up else ():
            task.pre_step(self.current_time_step_index, self.current_time)

    def _measure(self) -> None:
        self._data_logger.measure(self._tasks, self._scene, self.current_time_step_index, self.current_time)

    def clear(self) -> None:
        """Forget objects and tasks, and remove their prims and all others."""
        self._scene.clear()
        self._tasks, self._tasks_are_set_up = {}, False
        self._data_logger = DataLogger()
        super().clear()

    def _set_up_tasks(self) -> None:
        for task in self._tasks.values() if not self._tasks_are_set_up else ():
            task.set_up_scene(self._scene)
        self._tasks_are_set_up = True

    def _post_reset(self, soft: bool) -> None:
        if not soft:
            self._scene.initialize()
        get_eventdispatcher().dispatch_event(IsaacEvents.POST_RESET.value)
        self._scene.post_reset()
        for task in self._tasks.values():
            task.post_reset()

    # --- tasks ---
    def add_task(self, task: BaseTask) -> None:
        """Add a task, which the next `reset` sets up.

        Raises:
            ValueError: there is a task of its name.
        """
        if task.name in self._tasks:
            raise ValueError(f"the world has a task named {task.name!r} already; give another name")
        self._tasks[task.name] = task

    def is_tasks_scene_built(self) -> bool:
        return self._tasks_are_set_up

    def get_current_tasks(self) -> dict[str, BaseTask]:
        return self._tasks

    def get_task(self, name: str) -> BaseTask:
        """Return the task of a name.

        Raises:
            KeyError: there is none.
        """
        if name not in self._tasks:
            raise KeyError(f"the world has no task {name!r}; it has {', '.join(self._tasks) or 'none'}")
        return self._tasks[name]

    def get_observations(self, task_name: str | None = None) -> dict[str, Any]:
        return self._merged("get_observations", task_name)

    def calculate_metrics(self, task_name: str | None = None) -> dict[str, Any]:
        return self._merged("calculate_metrics", task_name)

    def is_done(self, task_name: str | None = None) -> bool:
        tasks = self._tasks.values() if task_name is None else [self.get_task(task_name)]
        return all(task.is_done() for task in tasks)

    def _merged(self, method: str, task_name: str | None) -> dict[str, Any]:
        merged: dict[str, Any] = {}
        for task in self._tasks.values() if task_name is None else [self.get_task(task_name)]:
            merged.update(getattr(task, method)())
        return merged

    def get_data_logger(self) -> DataLogger:
        """Return the logger that keeps what a function of the script measures at each step."""
        return self._data_logger
