"""The physics engine and the renderer of the current stage, and the protocols that they implement.

Each engine is created on first use, and only then are newton and warp imported.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike
from pxr import Usd

from usdsdg.listeners import Listeners
from usdsdg.session.devices.choice import physics_device
from usdsdg.session.progress import report
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.geometry.pixel_masks import PixelMasks
from usdsdg.warp_start import quiet_warp

if TYPE_CHECKING:
    from usdsdg.parallel import Later
    from usdsdg.stage.world_values import WorldValues
    from usdsdg_physics.queries.scene_queries import Overlap, RayHit
    from usdsdg_physics.scene.body_masses import BodyMasses
    from usdsdg_physics.scene.events import ContactEvent, TriggerEvent
    from usdsdg_render.labels.label_batch import LabelBatch
    from usdsdg_render.labels.sight import SurfacePoints
    from usdsdg_render.path.film import Film
    from usdsdg_render.settings import PathSettings, ToneSettings


class PhysicsEngine(Protocol):
    """Simulates a stage; see `usdsdg_physics.engine` for the meaning of each call."""

    @property
    def is_playing(self) -> bool: ...

    def play(self, *, time: float | None = None) -> None: ...

    def stop(self, *, restore: bool = True) -> None: ...

    def close(self) -> None: ...

    def advance(self, seconds: float, *, until: float | None = None) -> int: ...

    def reset(self, bodies: Collection[str] | None = None) -> None: ...

    def read_edits(self) -> None: ...

    def put_to_sleep(self, bodies: Collection[str]) -> None: ...

    def wake_up(self, bodies: Collection[str]) -> None: ...

    def apply_forces(
        self,
        bodies: Sequence[str],
        forces: ArrayLike | None = None,
        torques: ArrayLike | None = None,
        *,
        positions: ArrayLike | None = None,
    ) -> None: ...

    @property
    def writes_velocities(self) -> bool: ...

    def velocities(self, bodies: Sequence[str]) -> np.ndarray: ...

    @property
    def rigid_bodies(self) -> tuple[str, ...]: ...

    def mass_properties(self, bodies: Sequence[str]) -> BodyMasses: ...

    @property
    def joints(self) -> tuple[str, ...]: ...

    def joint_positions(self, joints: Sequence[str]) -> np.ndarray: ...

    def joint_velocities(self, joints: Sequence[str]) -> np.ndarray: ...

    def set_joint_state(
        self, joints: Sequence[str], positions: ArrayLike | None = None, velocities: ArrayLike | None = None
    ) -> None: ...

    def apply_joint_efforts(self, joints: Sequence[str], efforts: ArrayLike) -> None: ...

    def joint_forces(self, joints: Sequence[str]) -> np.ndarray: ...

    @property
    def step_seconds(self) -> float: ...

    def step(self, dt: float, *, until: float | None = None) -> None: ...

    def stage_unread(self) -> AbstractContextManager[None]: ...

    def subscribe_step(
        self, listener: Callable[[float], None], *, before: bool = False, heard: Callable[[], bool] | None = None
    ) -> Callable[[], None]: ...

    def subscribe_triggers(
        self, listener: Callable[[TriggerEvent], None], *, heard: Callable[[], bool] | None = None
    ) -> Callable[[], None]: ...

    def subscribe_contacts(
        self, listener: Callable[[list[ContactEvent]], None], *, heard: Callable[[], bool] | None = None
    ) -> Callable[[], None]: ...

    @property
    def contacts(self) -> list[ContactEvent]: ...

    def overlap_box(
        self, half_extent: Sequence[float], origin: Sequence[float], rotation_xyzw: Sequence[float]
    ) -> list[Overlap]: ...

    def overlap_sphere(self, radius: float, origin: Sequence[float]) -> list[Overlap]: ...

    def raycast(self, origin: Sequence[float], direction: Sequence[float], distance: float) -> RayHit | None: ...

    def raycast_all(
        self, origin: Sequence[float], direction: Sequence[float], distance: float, *, both_sides: bool = True
    ) -> list[RayHit]: ...

    def sweep_sphere(
        self,
        radius: float,
        origin: Sequence[float],
        direction: Sequence[float],
        distance: float,
        *,
        both_sides: bool = True,
    ) -> list[RayHit]: ...

    def sweep_box(
        self,
        half_extent: Sequence[float],
        origin: Sequence[float],
        rotation_xyzw: Sequence[float],
        direction: Sequence[float],
        distance: float,
        *,
        both_sides: bool = True,
    ) -> list[RayHit]: ...


class Renderer(Protocol):
    """Renders a stage through cameras; see `usdsdg_render.renderer` for the meaning of each call."""

    @property
    def glass_labels(self) -> str: ...

    @glass_labels.setter
    def glass_labels(self, value: str) -> None: ...

    @property
    def gprims(self) -> tuple[str, ...]: ...

    @property
    def device(self) -> str: ...

    @property
    def time(self) -> Usd.TimeCode: ...

    def look_at_files(self) -> None: ...

    def sync(self, time: Usd.TimeCode | None = None) -> None: ...

    def place_between(self, fraction: float) -> None: ...

    def labels_of(
        self,
        views: Sequence[CameraView],
        aovs: Collection[str],
        *,
        faces: Mapping[int, np.ndarray] = ...,
        fetched: bool = ...,
    ) -> list[dict[str, Any]]: ...

    def labels_and_masks(
        self,
        views: Sequence[CameraView],
        aovs: Collection[str],
        groups: Sequence[Sequence[int]],
        *,
        faces: Mapping[int, np.ndarray] = ...,
        fetched: bool = ...,
    ) -> tuple[list[dict[str, Any]], list[PixelMasks]]: ...

    @property
    def local_to_world(self) -> np.ndarray: ...

    def coverage_around(
        self, view: CameraView, groups: Sequence[Sequence[int]], *, faces: Mapping[int, np.ndarray] = ...
    ) -> np.ndarray: ...

    def surface_points(self, aovs: Mapping[str, np.ndarray]) -> SurfacePoints: ...

    def follow(self, points: SurfacePoints, view: CameraView) -> tuple[np.ndarray, np.ndarray]: ...

    def first_hits(
        self,
        origins: np.ndarray,
        directions: np.ndarray,
        first: np.ndarray,
        last: np.ndarray,
        *,
        faces: Mapping[int, np.ndarray] = ...,
    ) -> tuple[np.ndarray, np.ndarray]: ...

    def place_worlds(self, values: WorldValues, time: Usd.TimeCode | None = None) -> Any: ...

    def world_labels(self, view: CameraView, aovs: Collection[str]) -> LabelBatch: ...

    def world_pictures(
        self, view: CameraView, *, samples: int, settings: PathSettings, tone: ToneSettings
    ) -> dict[str, Any]: ...

    def new_film(self, width: int, height: int) -> Film: ...

    def new_films(self, count: int, width: int, height: int) -> list[Film]: ...

    def accumulate_all(
        self, films: Sequence[Film], views: Sequence[CameraView], *, samples: int, settings: PathSettings
    ) -> None: ...

    def develop(self, film: Film, tone: ToneSettings | None = None, *, fetched: bool = ...) -> dict[str, Any]: ...

    def develop_all(
        self, films: Sequence[Film], tone: ToneSettings | None = None, *, fetched: bool = ...
    ) -> list[dict[str, Any]]: ...

    def later(self, work: Callable[[], None]) -> Later: ...

    def finish(self) -> None: ...


class Engines:
    """The engines that have been created, and the devices and step listeners, which outlive them."""

    def __init__(self) -> None:
        self.device: str | None = None  # of the renderer; None: CUDA if available
        self.physics_device = "cpu"
        self.physics: PhysicsEngine | None = None
        self.renderer: Renderer | None = None
        self.step_listeners: Listeners[[float]] = Listeners()
        self.step_listeners_before: Listeners[[float]] = Listeners()
        self.trigger_listeners: Listeners[[TriggerEvent]] = Listeners()
        self.contact_listeners: Listeners[[list[ContactEvent]]] = Listeners()

    def follow_timeline(self, event: str) -> None:
        """Play or stop physics when the timeline plays or stops."""
        if event == "play":
            physics().play(time=current().timeline.get_current_time())
        elif event == "stop" and self.physics is not None:
            self.physics.stop()

    def reset(self) -> None:
        """Close both engines, so that new ones are created for the next stage; step listeners stay."""
        if self.physics is not None:
            self.physics.close()
        if self.renderer is not None:
            self.renderer.finish()
        self.physics = self.renderer = None


def physics() -> PhysicsEngine:
    """Return the physics engine of the current stage; create it if there is none."""
    engines = current().engines
    if engines.physics is None:
        quiet_warp()
        from usdsdg_physics.engine import NewtonEngine

        engines.physics = NewtonEngine(
            current_stage(), device=physics_device(), progress=report, writes_velocities=_wants_velocities_written
        )
        made = engines.physics
        after, before = engines.step_listeners, engines.step_listeners_before
        triggers, contacts = engines.trigger_listeners, engines.contact_listeners
        made.subscribe_step(after.call, heard=after.__bool__)
        made.subscribe_step(before.call, before=True, heard=before.__bool__)
        made.subscribe_triggers(triggers.call, heard=triggers.__bool__)
        made.subscribe_contacts(contacts.call, heard=contacts.__bool__)
    return engines.physics


def physics_if_made() -> PhysicsEngine | None:
    """Return the physics engine, or None if it has not been created yet."""
    return current().engines.physics


def _wants_velocities_written() -> bool:
    return current().settings.get_as_bool("/physics/updateVelocitiesToUsd")


def renderer() -> Renderer:
    """Return the renderer of the current stage; create it if there is none."""
    engines = current().engines
    if engines.renderer is None:
        engines.renderer = new_renderer(current_stage())
    return engines.renderer


def new_renderer(stage: Usd.Stage) -> Renderer:
    """Return a renderer of any stage, on the device that `use_device` has chosen."""
    quiet_warp()
    from usdsdg_render.renderer import WarpRenderer

    return WarpRenderer(stage, device=current().engines.device, progress=report)


def compile_renderer_beside() -> None:
    """Begin to compile the kernels of the renderer for CUDA, if need be, while the CPU's are compiled for physics."""
    quiet_warp()
    from usdsdg_render.device.precompile import precompile_beside
    from usdsdg_render.renderer import chosen_device

    precompile_beside(chosen_device(current().engines.device), report)


def renderer_aovs() -> dict[str, np.dtype]:
    """Return the NumPy dtype of each AOV of the renderer, by name, without color images, which have annotator names."""
    quiet_warp()
    from usdsdg_render.labels.aov import AOVS

    return {name: np.dtype(aov.dtype) for name, aov in AOVS.items()}


def subscribe_step(listener: Callable[[float], None], *, before: bool = False, order: int = 0) -> Callable[[], None]:
    """Call `listener(dt)` after every physics step, on this and later stages; return the unsubscriber.

    With `before` it is called before each step, which takes what it writes to the stage into account. Listeners of a
    lower `order` are called earlier, and those of the same one as they subscribed.
    """
    engines = current().engines
    told = engines.step_listeners_before if before else engines.step_listeners
    return told.subscribe(listener, order=order)


def subscribe_triggers(listener: Callable[[TriggerEvent], None]) -> Callable[[], None]:
    """Call `listener(event)` for what enters and leaves triggers, on this and later stages; return the unsubscriber."""
    return current().engines.trigger_listeners.subscribe(listener)


def subscribe_contacts(listener: Callable[[list[ContactEvent]], None]) -> Callable[[], None]:
    """Call `listener(events)` after steps with contacts that are reported, on this and later stages.

    Return the unsubscriber.
    """
    return current().engines.contact_listeners.subscribe(listener)
