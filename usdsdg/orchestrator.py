"""Frames on demand. Mirrors `rep.orchestrator`; what a frame is stands in `frame_loop`."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

from usdsdg.app import get_app
from usdsdg.frame_loop import Orchestrator, OrchestratorError, Status, StatusCallback, get_orchestrator
from usdsdg.settings import get_settings

__all__ = [
    "Orchestrator", "OrchestratorError", "Status", "StatusCallback", "get_is_paused", "get_is_started",
    "get_is_stopped", "get_orchestrator", "get_sim_times_to_write", "get_status", "pause", "preview", "preview_async",
    "register_status_callback", "resume", "run", "run_async", "run_until_complete", "run_until_complete_async",
    "set_capture_on_play", "set_minimum_next_rt_subframes", "set_next_rt_subframes", "step", "step_async", "stop",
    "stop_async", "wait_until_complete", "wait_until_complete_async",
]  # fmt: skip

PAUSED_SECONDS = 0.001


def step(
    rt_subframes: int = -1, pause_timeline: bool = True, delta_time: float | None = None, wait_for_render: bool = True
) -> None:
    """Capture one frame with every enabled render product that a writer or annotator is attached to.

    Args:
        rt_subframes: Sub-frames of the fast mode, each a few samples per pixel; -1 takes the setting.
        pause_timeline: Pause a playing timeline afterwards, until the next step.
        delta_time: Seconds to move the playing timeline first; None moves by one time code, 0.0 not at all. The first
            captured frame does not move, unless motion blur spreads it over `delta_time`.
        wait_for_render: Frames are always complete when this returns, so both values mean the same here.
    """
    get_orchestrator().step(rt_subframes, pause_timeline, delta_time)
    get_app().turn_loop()


async def step_async(
    rt_subframes: int = -1, pause_timeline: bool = True, delta_time: float | None = None, wait_for_render: bool = True
) -> None:
    """`step` for coroutines; other tasks run before and after, not during, the frame."""
    await asyncio.sleep(0)
    step(rt_subframes, pause_timeline, delta_time, wait_for_render)
    await asyncio.sleep(0)


def preview() -> None:
    """Run every trigger of frames or of times once without capturing."""
    get_orchestrator().preview()


async def preview_async() -> None:
    """`preview` for coroutines."""
    preview()
    await asyncio.sleep(0)


def run(num_frames: int | None = None, start_timeline: bool = False) -> None:
    """Capture `num_frames` frames, or until every trigger with `max_execs` has run out.

    Raises:
        OrchestratorError: without `num_frames`, no trigger would ever end the run.
    """
    for _ in get_orchestrator().run(num_frames, start_timeline):
        get_app().turn_loop()
        if get_is_paused():
            # Only a task can resume; meanwhile leave it the processor.
            time.sleep(PAUSED_SECONDS)


run_until_complete = run


async def run_async(num_frames: int | None = None, start_timeline: bool = False) -> None:
    """`run` for coroutines; other tasks run between the frames."""
    for _ in get_orchestrator().run(num_frames, start_timeline):
        await asyncio.sleep(0)


run_until_complete_async = run_async


def wait_until_complete() -> None:
    """Return when every scheduled file is on disk; raises what a writer or its backend failed with."""
    get_orchestrator().finish()


async def wait_until_complete_async() -> None:
    """`wait_until_complete` for coroutines."""
    await asyncio.sleep(0)
    wait_until_complete()


def stop() -> None:
    """End the run: files are finished and writers told. What is captured after it begins as the first run did."""
    get_orchestrator().stop()


async def stop_async() -> None:
    """`stop` for coroutines."""
    stop()
    await asyncio.sleep(0)


def pause() -> None:
    """Capture nothing more in `run` and `run_async`, and let a playing timeline stand, until `resume`."""
    get_orchestrator().pause()


def resume() -> None:
    """Go on after `pause`."""
    get_orchestrator().resume()


def set_capture_on_play(value: bool) -> None:
    """Whether every app update of a playing timeline is captured, as it is until somebody says False.

    Then stopping the timeline ends the run.
    """
    get_settings().set("/omni/replicator/captureOnPlay", bool(value))


def get_sim_times_to_write() -> list[float]:
    """Times of frames that are still to be written: none, since a frame is complete when `step` returns."""
    return []


def set_next_rt_subframes(rt_subframes: int) -> None:
    """At least this many sub-frames at the next capture."""
    get_orchestrator().set_next_subframes(rt_subframes)


set_minimum_next_rt_subframes = set_next_rt_subframes


def get_status() -> Status:
    """Where the orchestrator stands."""
    return get_orchestrator().status


def get_is_started() -> bool:
    return get_status() in (Status.STARTED, Status.STEPPING, Status.STEPPED)


def get_is_stopped() -> bool:
    return get_status() is Status.STOPPED


def get_is_paused() -> bool:
    return get_status() is Status.PAUSED


def register_status_callback(callback: Callable[[Status], None]) -> StatusCallback:
    """Call `callback(status)` at every change, for as long as the returned handle is held and registered."""
    handle = StatusCallback(callback)
    handle.register()
    return handle
