"""`BaseTask`: what a world sets up, observes and resets; scripts derive from it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation

if TYPE_CHECKING:
    from usdsdg.compat.isaacsim.core.api.scenes import Scene


class BaseTask:
    """A task; methods that a script does not override do nothing, or raise where a result is asked for."""

    def __init__(self, name: str, offset: Sequence[float] | None = None) -> None:
        """Give the task a name, and an offset (3,) [stage units] that it may add to its objects."""
        self._name = name
        self._offset = np.zeros(3) if offset is None else np.asarray(offset)
        self._scene: Scene | None = None
        self._task_objects: dict[str, Any] = {}

    @property
    def name(self) -> str:
        return self._name

    @property
    def scene(self) -> Scene | None:
        return self._scene

    @property
    def device(self) -> str:
        return simulation().device

    def set_up_scene(self, scene: Scene) -> None:
        """Remember the scene; a script adds its objects."""
        self._scene = scene

    def get_task_objects(self) -> dict[str, Any]:
        return self._task_objects

    def get_observations(self) -> dict[str, Any]:
        raise NotImplementedError(f"{type(self).__name__}.get_observations: define it in your task")

    def calculate_metrics(self) -> dict[str, Any]:
        raise NotImplementedError(f"{type(self).__name__}.calculate_metrics: define it in your task")

    def is_done(self) -> bool:
        raise NotImplementedError(f"{type(self).__name__}.is_done: define it in your task")

    def pre_step(self, time_step_index: int, simulation_time: float) -> None:
        """Do nothing: a script may override it."""

    def post_reset(self) -> None:
        """Do nothing: a script may override it."""

    def cleanup(self) -> None:
        """Do nothing: a script may override it."""

    def get_description(self) -> str:
        return ""

    def get_params(self) -> dict[str, Any]:
        raise NotImplementedError(f"{type(self).__name__}.get_params: define it in your task")

    def set_params(self, *args: Any, **kwargs: Any) -> None:
        raise NotImplementedError(f"{type(self).__name__}.set_params: define it in your task")
