"""`omni.usd`: the USD context and its stage."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from typing import Any

from pxr import Gf, Usd, UsdGeom

from usdsdg.app.app import get_app
from usdsdg.compat import stage_events as events
from usdsdg.compat.carb import Double3
from usdsdg.compat.carb.events import IEvent, IEventStream
from usdsdg.compat.material_shaders import create_material_input, get_shader_from_material
from usdsdg.compat.prim_arcs import get_composed_payloads_from_prim, get_composed_references_from_prim
from usdsdg.compat.prim_copies import duplicate_prim
from usdsdg.compat.stage_events import (
    StageEventType,
    StageRenderingEventType,
    StageState,
    stage_event_name,
    stage_event_type,
    stage_events,
)
from usdsdg.compat.wrappers.bounds import aligned, bbox_cache
from usdsdg.compat.wrappers.prim_paths import existing_prim
from usdsdg.errors import Unsupported
from usdsdg.session import stage_context
from usdsdg.session.session import current
from usdsdg.session.timeline import Timeline, get_timeline
from usdsdg.stage.paths import next_free_path
from usdsdg.stage.poses.rotations import decompose, euler_xyz_from_quat
from usdsdg.stage.time_code import current_time

__all__ = [
    "Selection", "StageEventType", "StageRenderingEventType", "StageState", "UsdContext", "create_material_input",
    "duplicate_prim", "get_composed_payloads_from_prim", "get_composed_references_from_prim", "get_context",
    "get_local_transform_SRT", "get_local_transform_matrix", "get_prim_at_path",
    "get_shader_from_material", "get_stage_next_free_path", "get_world_transform_matrix", "stage_event_name",
    "stage_event_type",
]  # fmt: skip


class Selection:
    """The paths of the selected prims, in the order of selecting; a new stage has none."""

    def __init__(self) -> None:
        self._paths: list[str] = []

    def reset(self) -> None:
        """Select nothing."""
        self._paths = []

    def get_selected_prim_paths(self) -> list[str]:
        """Return the selected paths."""
        return list(self._paths)

    def set_selected_prim_paths(self, paths: Iterable[Any], expand_in_stage: bool = False) -> bool:
        """Select these paths and no others."""
        self._select([str(path) for path in paths])
        return True

    def clear_selected_prim_paths(self) -> bool:
        """Select nothing."""
        self._select([])
        return True

    def is_prim_path_selected(self, path: Any) -> bool:
        """Return whether a path is selected."""
        return str(path) in self._paths

    def set_prim_path_selected(
        self, path: Any, selected: bool, force: bool = False, clear_selected: bool = False, expand: bool = False
    ) -> bool:
        """Select a path or not, and with `clear_selected` no others."""
        others = [] if clear_selected else [each for each in self._paths if each != str(path)]
        self._select([*others, *([str(path)] if selected else [])])
        return True

    def _select(self, paths: list[str]) -> None:
        if paths != self._paths:
            self._paths = paths
            stage_events().send(StageEventType.SELECTION_CHANGED)


class UsdContext:
    """Access to the current stage; there is one context."""

    def new_stage(self) -> bool:
        stage_context.new_stage()
        return True

    async def new_stage_async(self) -> tuple[bool, str]:
        stage_context.new_stage()
        await asyncio.sleep(0)
        return True, ""

    def open_stage(self, url: str, *_: Any) -> bool:
        with stage_events().opening():
            stage_context.open_stage(url)
        return True

    async def open_stage_async(self, url: str, *_: Any) -> tuple[bool, str]:
        self.open_stage(url)
        await asyncio.sleep(0)
        return True, ""

    def attach_stage_with_callback(self, stage_id: int, on_finish_fn: Callable[[bool, str], Any] | None = None) -> bool:
        """Make a stage of USD's stage cache the current one; `on_finish_fn(True, "")` follows.

        Raises:
            StageError: no open stage has this id.
        """
        stage_context.set_stage(stage_context.stage_by_id(stage_id))
        if on_finish_fn is not None:
            on_finish_fn(True, "")
        return True

    async def attach_stage_async(self, stage: Usd.Stage) -> tuple[bool, str]:
        """Make a stage that a script has made the current one."""
        stage_context.set_stage(stage)
        await asyncio.sleep(0)
        return True, ""

    def save_as_stage(self, url: str, *_: Any) -> bool:
        """Write the stage to a file, which is that of the stage from then on: `save_stage` writes it again."""
        with stage_events().saving(str(url)):
            current().saved_as = str(stage_context.save_stage(url))
        return True

    def save_stage(self, *_: Any) -> bool:
        """Write the stage to its own file, as `save_as_stage`.

        Raises:
            Unsupported: the stage has no file.
        """
        if self.is_new_stage():
            raise Unsupported("save_stage: the stage is in memory and has no file; use save_as_stage")
        return self.save_as_stage(self.get_stage_url())

    async def save_stage_async(self, *_: Any) -> tuple[bool, str, list[str]]:
        """Write the stage as `save_stage`; return True, no error, and the file."""
        self.save_stage()
        await asyncio.sleep(0)
        return True, "", [self.get_stage_url()]

    def get_stage(self) -> Usd.Stage:
        return stage_context.current_stage()

    def get_stage_id(self) -> int:
        return stage_context.stage_id()

    def get_stage_url(self) -> str:
        """Return the file of the stage, or what its layer is called that has none."""
        return current().saved_as or stage_context.current_stage().GetRootLayer().identifier

    def stage_rendering_event_name(self, event_type: StageRenderingEventType, immediate: bool = False) -> str:
        """Return the name of a rendering event in `carb.eventdispatcher`; only new frames happen."""
        events.warn_if_never(StageRenderingEventType(event_type), {StageRenderingEventType.NEW_FRAME})
        return events.rendering_event_name(event_type)

    def stage_event_name(self, event_type: StageEventType, immediate: bool = False) -> str:
        """Return the name of a stage event in `carb.eventdispatcher`."""
        stage_events()
        events.warn_if_never(StageEventType(event_type), events.SENT_STAGE_EVENTS)
        return stage_event_name(event_type)

    def stage_event_type(self, event_name: str) -> StageEventType | None:
        """Return the type of the stage event that has a name, None for another name."""
        return stage_event_type(event_name)

    def get_stage_event_stream(self) -> IEventStream:
        """Return the stream of stage events (`carb.events`), with the types of `StageEventType`."""
        return stage_events().stage

    def get_rendering_event_stream(self) -> IEventStream:
        """Return the stream of rendering events (`carb.events`): a NEW_FRAME after each update."""
        return stage_events().rendering

    async def next_stage_event_async(self) -> tuple[int, dict[str, Any]]:
        """Wait for the next stage event, with app updates; return its type and payload."""
        heard: list[IEvent] = []
        subscription = self.get_stage_event_stream().create_subscription_to_pop(heard.append)
        while not heard:
            await get_app().next_update_async()
        subscription.unsubscribe()
        return heard[0].type, dict(heard[0].payload)

    def get_stage_state(self) -> StageState:
        """Return OPENED: there is always an open stage."""
        return StageState.OPENED

    async def save_as_stage_async(self, url: str, *_: Any) -> tuple[bool, str, list[str]]:
        """Write the stage as `save_as_stage`; return True, no error, and the file."""
        self.save_as_stage(url)
        await asyncio.sleep(0)
        return True, "", [str(url)]

    def close_stage(self, *_: Any) -> bool:
        """Replace the stage with a new one: there is always a stage."""
        stage_context.new_stage()
        return True

    async def close_stage_async(self, *_: Any) -> tuple[bool, str]:
        """Replace the stage with a new one: there is always a stage."""
        stage_context.new_stage()
        await asyncio.sleep(0)
        return True, ""

    def reopen_stage(self, *_: Any) -> bool:
        """Open the file of the stage again, without the changes since it was opened.

        Raises:
            Unsupported: the stage has no file.
        """
        if self.is_new_stage():
            raise Unsupported("reopen_stage: the stage is in memory and has no file; use new_stage")
        stage_context.open_stage(self.get_stage_url())
        return True

    def can_open_stage(self) -> bool:
        """Return True: no stage is being opened or closed."""
        return True

    can_close_stage = can_save_stage = can_open_stage

    async def reopen_stage_async(self, *_: Any) -> tuple[bool, str]:
        """As `reopen_stage`; return True and no error."""
        self.reopen_stage()
        await asyncio.sleep(0)
        return True, ""

    async def next_frame_async(self, viewport: int = 0) -> None:
        """Wait for the next app update, in which all viewports show a frame."""
        await get_app().next_update_async()

    next_usd_async = next_frame_async

    def reset_renderer_accumulation(self) -> None:
        """Do nothing: no picture has samples of an earlier one."""

    def get_timeline(self) -> Timeline:
        """Return the timeline, of which there is one."""
        return get_timeline()

    def get_timeline_name(self) -> str:
        """Return "": the only timeline is the default one."""
        return ""

    def is_new_stage(self) -> bool:
        """Return whether the stage has no file."""
        return current().saved_as is None and stage_context.current_stage().GetRootLayer().anonymous

    def is_writable(self) -> bool:
        """Return whether the stage can be saved where it is."""
        return not self.is_new_stage()

    def get_name(self) -> str:
        """Return "": the only context is the default one."""
        return ""

    def enable_save_to_recent_files(self) -> None:
        """Do nothing: there is no list of recent files."""

    def disable_save_to_recent_files(self) -> None:
        """Do nothing: there is no list of recent files."""

    def get_selection(self) -> Selection:
        """Return the paths that are selected, which scripts set and commands work on."""
        return current().selection

    def compute_path_world_bounding_box(self, path: Any) -> tuple[Double3, Double3]:
        """Return minimum and maximum of what is at `path` and below it, in the world [stage units].

        Raises:
            BadPrim: there is no such prim.
        """
        cache = bbox_cache(current_time(), use_extents_hint=False)
        box = aligned(cache, Usd.PrimRange(existing_prim(str(path)))).tolist()
        return Double3(box[:3]), Double3(box[3:])

    def compute_path_world_transform(self, path: Any) -> list[float]:
        """Return the 16 numbers of the matrix from the space of a prim to the world, row by row, for row vectors.

        Raises:
            BadPrim: there is no such prim.
        """
        matrix = get_world_transform_matrix(existing_prim(str(path)), current_time())
        return [value for row in matrix for value in row]

    def get_stage_loading_status(self) -> tuple[str, int, int]:
        """Return (message, files loaded, files to load): loading is synchronous, so nothing is ever pending."""
        return "", 0, 0

    def get_stage_streaming_status(self) -> bool:
        """Return False: textures are loaded before a picture is rendered, so nothing is ever streamed."""
        return False


_context = UsdContext()


def get_context(name: str = "") -> UsdContext:
    return _context


def get_stage_next_free_path(stage: Usd.Stage, path: str, prepend_default_prim: bool = True) -> str:
    return next_free_path(stage, path, prepend_default_prim)


def get_prim_at_path(path: Any) -> Usd.Prim:
    return stage_context.current_stage().GetPrimAtPath(path)


def get_world_transform_matrix(prim: Usd.Prim, time_code: Usd.TimeCode | None = None) -> Any:
    from usdsdg.stage.poses.transforms import local_to_world

    return local_to_world(prim, Usd.TimeCode.Default() if time_code is None else time_code)


def get_local_transform_matrix(prim: Usd.Prim, time_code: Usd.TimeCode | None = None) -> Gf.Matrix4d:
    """Return the matrix from a prim's space to its parent's, for row vectors: identity if it has no transform."""
    xform = UsdGeom.Xformable(prim)
    time = Usd.TimeCode.Default() if time_code is None else time_code
    return xform.GetLocalTransformation(time) if xform else Gf.Matrix4d(1)


def get_local_transform_SRT(
    prim: Usd.Prim, time_code: Usd.TimeCode | None = None
) -> tuple[Gf.Vec3d, Gf.Vec3d, Gf.Vec3i, Gf.Vec3d]:
    """Return scale, rotation [degrees], order of its axes (0 for x) and translation of a prim in its parent's space.

    The order is always (0, 1, 2), about x first, whatever ops the prim has; pivots and shears are not among these.
    """
    pose = decompose(get_local_transform_matrix(prim, time_code))
    scale, turn, place = (
        Gf.Vec3d(*part.tolist()) for part in (pose.scale, euler_xyz_from_quat(pose.rotation), pose.translate)
    )
    return scale, turn, Gf.Vec3i(0, 1, 2), place
