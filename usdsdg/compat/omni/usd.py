"""`omni.usd`: the USD context and its stage."""

import asyncio
import enum
from typing import Any

from pxr import Usd

from usdsdg.compat.carb.eventdispatcher import NEW_FRAME
from usdsdg.session import stage_context
from usdsdg.stage.paths import next_free_path

__all__ = [
    "StageRenderingEventType", "UsdContext", "get_context", "get_prim_at_path", "get_stage_next_free_path",
    "get_world_transform_matrix",
]  # fmt: skip


class StageRenderingEventType(enum.Enum):
    """The event types of `stage_rendering_event_name`."""

    NEW_FRAME = 0


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
        stage_context.open_stage(url)
        return True

    async def open_stage_async(self, url: str, *_: Any) -> tuple[bool, str]:
        stage_context.open_stage(url)
        await asyncio.sleep(0)
        return True, ""

    def save_as_stage(self, url: str, *_: Any) -> bool:
        stage_context.save_stage(url)
        return True

    def get_stage(self) -> Usd.Stage:
        return stage_context.current_stage()

    def get_stage_id(self) -> int:
        return stage_context.stage_id()

    def get_stage_url(self) -> str:
        return stage_context.current_stage().GetRootLayer().identifier

    def stage_rendering_event_name(self, event_type: StageRenderingEventType, immediate: bool = False) -> str:
        """Return the name of the event of new frames in `carb.eventdispatcher`."""
        return NEW_FRAME

    def get_stage_loading_status(self) -> tuple[str, int, int]:
        """Return (message, files loaded, files to load): loading is synchronous, so nothing is ever pending."""
        return "", 0, 0


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
