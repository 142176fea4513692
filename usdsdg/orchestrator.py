"""Frames on demand. Mirrors `rep.orchestrator`; what a frame is stands in `frame_loop`."""

import asyncio
import time
from collections.abc import Callable, Iterator
from numbers import Real
from typing import Any

from usdsdg.app.app import get_app
from usdsdg.app.frame_loop import Orchestrator, get_orchestrator
from usdsdg.app.status import OrchestratorError, Status, StatusCallback
from usdsdg.arguments.values import whole_number
from usdsdg.errors import GraphError
from usdsdg.session.settings_store import get_settings

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
        rt_subframes: Sub-frames of the fast mode, each a few samples per pixel; -1 takes the setting
            /omni/replicator/RTSubframes. Triggers that fire, and `set_next_rt_subframes`, may ask for more.
        pause_timeline: Pause a playing timeline afterwards, until the next step.
        delta_time: Seconds to move the playing timeline first; None moves by one time code, 0.0 not at all. The first
            captured frame does not move, unless motion blur spreads it over `delta_time`.
        wait_for_render: Frames are always complete when this returns, so both values mean the same here.

    Raises:
        OrchestratorError: `rt_subframes` is no whole number, or `delta_time` no number of seconds, 0 or more.
        GraphError: a node failed; says which script line made it.
    """
    _check_whole("rt_subframes", rt_subframes)
    if delta_time is not None and not (isinstance(delta_time, Real) and delta_time >= 0):
        raise OrchestratorError(
            f"orchestrator.step: delta_time is {delta_time!r}; expected seconds, 0 or more, or None"
        )
    get_orchestrator().step(rt_subframes, pause_timeline, delta_time)
    get_app().run_ready_tasks()


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

    Args:
        num_frames: 0 captures nothing.
        start_timeline: Play the timeline first.

    Raises:
        OrchestratorError: without `num_frames`, no trigger would ever end the run; or it is no whole number, 0 or more.
    """
    for _ in _run(num_frames, start_timeline):
        get_app().run_ready_tasks()
        if get_is_paused():
            # Only a task can resume; meanwhile leave it the processor.
            time.sleep(PAUSED_SECONDS)


run_until_complete = run


async def run_async(num_frames: int | None = None, start_timeline: bool = False) -> None:
    """`run` for coroutines; other tasks run between the frames."""
    for _ in _run(num_frames, start_timeline):
        await asyncio.sleep(0)


run_until_complete_async = run_async


def _run(num_frames: int | None, start_timeline: bool) -> Iterator[None]:
    if num_frames is not None:
        _check_whole("num_frames", num_frames, least=0)
    return get_orchestrator().run(num_frames, start_timeline)


def _check_whole(name: str, value: Any, *, least: int | None = None) -> None:
    try:
        whole_number(name, value, least=least)
    except GraphError as error:
        raise OrchestratorError(f"orchestrator: {error}") from None


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

    Raises:
        OrchestratorError: `value` is neither True nor False.
    """
    if not isinstance(value, bool):
        raise OrchestratorError(f"orchestrator.set_capture_on_play: value is {value!r}; expected True or False")
    get_settings().set("/omni/replicator/captureOnPlay", bool(value))


def get_sim_times_to_write() -> list[float]:
    """Times of frames that are still to be written: none, since a frame is complete when `step` returns."""
    return []


def set_next_rt_subframes(rt_subframes: int) -> None:
    """At least this many sub-frames at the next capture.

    Raises:
        OrchestratorError: it is no whole number.
    """
    _check_whole("rt_subframes", rt_subframes)
    get_orchestrator().set_next_subframes(rt_subframes)


set_minimum_next_rt_subframes = set_next_rt_subframes


def get_status() -> Status:
    """Where the orchestrator stands."""
    return get_orchestrator().status


def get_is_started() -> bool:
    """Whether a run has begun and neither ended nor been paused."""
    return get_status() in (Status.STARTED, Status.STEPPING, Status.STEPPED)


def get_is_stopped() -> bool:
    """Whether no run has begun, or the last one has ended."""
    return get_status() is Status.STOPPED


def get_is_paused() -> bool:
    """Whether `pause` was called and `resume` not yet."""
    return get_status() is Status.PAUSED


def register_status_callback(callback: Callable[[Status], None]) -> StatusCallback:
    """Call `callback(status)` at every change, for as long as the returned handle is held and registered."""
    handle = StatusCallback(callback)
    handle.register()
    return handle
