"""The two engines behind their interfaces, made when first needed, for the current stage.

Neither newton nor warp is imported before.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Sequence
from typing import Any, Protocol

import numpy as np

from usdsdg.session.progress import report
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.geometry.pixel_masks import Outlines


class PhysicsEngine(Protocol):
    """A stage in motion; see `usdsdg_physics.engine` for the meaning of each call."""

    def play(self) -> None: ...

    def stop(self) -> None: ...

    def advance(self, seconds: float) -> int: ...

    def reset(self, bodies: Collection[str] | None = None) -> None: ...

    def put_to_sleep(self, bodies: Collection[str]) -> None: ...

    def wake_up(self, bodies: Collection[str]) -> None: ...

    def subscribe_step(self, listener: Callable[[float], None]) -> Callable[[], None]: ...

    def overlap_box(self, half_extent: Any, origin: Any, rotation_xyzw: Any) -> list[Any]: ...

    def overlap_sphere(self, radius: float, origin: Any) -> list[Any]: ...

    def raycast(self, origin: Any, direction: Any, distance: float) -> Any: ...


class Renderer(Protocol):
    """A stage seen by cameras; see `usdsdg_render.renderer` for the meaning of each call."""

    glass_labels: str

    @property
    def gprims(self) -> tuple[str, ...]: ...

    @property
    def time(self) -> Any: ...

    def sync(self, time: Any = None) -> None: ...

    def place_between(self, fraction: float) -> None: ...

    def labels_of(self, views: Sequence[CameraView], aovs: Collection[str]) -> list[dict[str, np.ndarray]]: ...

    def outlined(
        self, views: Sequence[CameraView], aovs: Collection[str], groups: Sequence[Sequence[int]]
    ) -> tuple[list[dict[str, np.ndarray]], list[Outlines]]: ...

    def new_film(self, width: int, height: int) -> Any: ...

    def accumulate_all(
        self, films: Sequence[Any], views: Sequence[CameraView], *, samples: int, settings: Any
    ) -> None: ...

    def develop(self, film: Any, tone: Any) -> dict[str, np.ndarray]: ...


_device: str | None = None
_physics: Any = None
_renderer: Any = None
_step_listeners: list[Callable[[float], None]] = []


def use_device(device: str | None) -> None:
    """ "cpu", "cuda:0", or None for CUDA where there is one.

    Raises:
        RenderError: there is no such device.
    """
    global _device
    if device not in (None, "cpu"):
        hush_warp()
        from usdsdg_render.renderer import chosen_device

        chosen_device(device)
    _device = device
    reset()


def physics() -> Any:
    """The physics engine of the current stage."""
    global _physics
    if _physics is None:
        hush_warp()
        from usdsdg_physics.engine import NewtonEngine

        _physics = NewtonEngine(current_stage(), device=physics_device(), progress=report)
        _physics.subscribe_step(_tell_step)
    return _physics


def physics_device() -> str:
    """Physics of one scene is a chain of small steps: a CPU core is faster for it than a GPU unless asked for."""
    return _device or "cpu"


def physics_if_made() -> Any | None:
    """The physics engine, or None when nothing has needed it yet."""
    return _physics


def renderer() -> Any:
    """The renderer of the current stage."""
    global _renderer
    if _renderer is None:
        hush_warp()
        from usdsdg_render.renderer import WarpRenderer

        _renderer = WarpRenderer(current_stage(), device=_device, progress=report)
    return _renderer


def hush_warp() -> None:
    """Warp tells of every module that it loads; our own progress says what a person wants to know of it."""
    import warp

    warp.config.log_level = logging.WARNING


def subscribe_step(listener: Callable[[float], None]) -> Callable[[], None]:
    """Call `listener(dt)` after every physics step of whatever stage is current; returns what ends it."""
    _step_listeners.append(listener)
    return lambda: _step_listeners.remove(listener) if listener in _step_listeners else None


def _tell_step(dt: float) -> None:
    for listener in list(_step_listeners):
        listener(dt)


def reset() -> None:
    """A new stage gets new engines; subscriptions to steps stay."""
    global _physics, _renderer
    for engine in (_physics, _renderer):
        if hasattr(engine, "close"):
            engine.close()
    _physics = _renderer = None
