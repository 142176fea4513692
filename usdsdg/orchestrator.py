"""Capture frames and runs. Mirrors `rep.orchestrator`; the order of one frame is in `usdsdg.app.frame_loop`."""

import asyncio
import math
import time
from collections.abc import Callable, Generator
from numbers import Real
from typing import Any

from usdsdg.app.app import get_app
from usdsdg.app.frame_loop import Orchestrator, get_orchestrator
from usdsdg.app.run_ends import is_endless, limits_remain
from usdsdg.app.status import OrchestratorError, Status, StatusCallback
from usdsdg.arguments.parameters import name_parameters
from usdsdg.arguments.values import whole_number
from usdsdg.errors import GraphError
from usdsdg.session.settings.store import get_settings
from usdsdg.session.turns import turn_of_task, turns

__all__ = [
    "Orchestrator", "OrchestratorError", "Status", "StatusCallback", "get_is_paused", "get_is_started",
    "get_is_stopped", "get_orchestrator", "get_sim_times_to_write", "get_status", "pause", "preview", "preview_async",
    "register_status_callback", "resume", "run", "run_async", "run_until_complete", "run_until_complete_async",
    "set_capture_on_play", "set_minimum_next_rt_subframes", "set_next_rt_subframes", "step", "step_async", "stop",
    "stop_async", "wait_until_complete", "wait_until_complete_async",
]  # fmt: skip

PAUSED_SECONDS = 0.001
_ENDED = object()
# They only look, also while another thread captures.
_STATUS = ("get_is_paused", "get_is_started", "get_is_stopped", "get_orchestrator", "get_status")


def step(
    rt_subframes: int = -1, pause_timeline: bool = True, delta_time: float | None = None, wait_for_render: bool = True
) -> None:
    """Capture one frame with every enabled render product that a writer or annotator is attached to.

    Args:
        rt_subframes: Sub-frames of the fast mode, each a few samples per pixel; -1 takes those of
            `set_next_rt_subframes`. The setting /omni/replicator/RTSubframes, and triggers that fire, may require more.
        pause_timeline: Pause a playing timeline afterward, until the next step.
        delta_time: Seconds by which the timeline advances first, and physics with it if it plays; None: one time code
            if it plays; 0.0: not at all. The first captured frame does not advance it, unless motion blur exposes over
            `delta_time`. Where capture on play is set (`set_capture_on_play`), steps with None play the timeline
            themselves from the second frame on.
        wait_for_render: Ignored: frames are always complete when this returns.

    Raises:
        OrchestratorError: `rt_subframes` is not an integer, or `delta_time` is not a finite number >= 0.
        GraphError: a node failed; the message names the script line that made it.
    """
    _check_whole("rt_subframes", rt_subframes)
    if delta_time is not None and not (isinstance(delta_time, Real) and 0 <= delta_time < math.inf):
        raise OrchestratorError(
            f"orchestrator.step: delta_time is {delta_time!r}; expected seconds, 0 or more, or None"
        )
    get_orchestrator().step(rt_subframes, pause_timeline, delta_time)
    get_app().run_ready_tasks()


async def step_async(
    rt_subframes: int = -1, pause_timeline: bool = True, delta_time: float | None = None, wait_for_render: bool = True
) -> None:
    """Run `step` in a coroutine; other tasks run before and after the frame, not during it.

    Of several tasks that capture at once each goes on before the next frame, so that annotators have its own.
    """
    async with turn_of_task():
        await asyncio.sleep(0)
        step(rt_subframes, pause_timeline, delta_time, wait_for_render)
        await asyncio.sleep(0)


def preview() -> None:
    """Run every frame and time trigger once without capturing."""
    get_orchestrator().preview()


async def preview_async() -> None:
    """Run `preview` in a coroutine."""
    preview()
    await asyncio.sleep(0)


def run(num_frames: int | None = None, start_timeline: bool = False) -> None:
    """Capture `num_frames` frames, or until every trigger with `max_execs` has reached it, whichever is first.

    Where capture on play is set (`set_capture_on_play`, the default), the timeline plays after the first frame, so that
    bodies fall and animations run, and is stopped at the end.

    Each run begins anew: it repeats the draws of the one before, and what steps have captured before does not count.

    Args:
        num_frames: 0 captures nothing. Triggers without `max_execs` do not end the run before.
        start_timeline: Play the timeline first, whether capture on play is set or not.

    Raises:
        OrchestratorError: `num_frames` is None and no trigger ends the run, or it is not an integer >= 0. In a
            coroutine a run that nothing ends begins here instead, as with `run_async`.
    """
    if asyncio._get_running_loop() is not None and is_endless(num_frames):
        get_orchestrator().begin_run(start_timeline)
        return
    for _ in _run(num_frames, start_timeline):
        get_app().run_ready_tasks()
        turns.give_way()
        if get_is_paused():
            # Only a task or another thread can resume; sleep to leave it the processor.
            time.sleep(PAUSED_SECONDS)
    get_orchestrator().is_unawaited = True


def run_until_complete(num_frames: int | None = None, start_timeline: bool = False) -> None:
    """Run `run`; right after `run` or `run_async`, which in Replicator only begin a run, wait for the files of that."""
    if not _has_run(num_frames):
        run(num_frames, start_timeline)
    wait_until_complete()


async def run_async(num_frames: int | None = None, start_timeline: bool = False) -> None:
    """Run `run` in a coroutine; other tasks run between the frames.

    A run that nothing ends begins here: each update of the application, as by `next_update_async`, captures a frame of
    it, until `stop`.
    """
    if is_endless(num_frames):
        get_orchestrator().begin_run(start_timeline)
        await asyncio.sleep(0)
        return
    frames = _run(num_frames, start_timeline)
    try:
        while True:
            async with turn_of_task():
                if next(frames, _ENDED) is _ENDED:
                    break
            await asyncio.sleep(0)
    finally:
        frames.close()
    get_orchestrator().is_unawaited = True


async def run_until_complete_async(num_frames: int | None = None, start_timeline: bool = False) -> None:
    """Run `run_until_complete` in a coroutine; other tasks run between the frames."""
    if not _has_run(num_frames):
        await run_async(num_frames, start_timeline)
    await wait_until_complete_async()


def _has_run(num_frames: int | None) -> bool:
    """Return whether the run that a script waits for has begun, and so ended, before: scripts begin it with `run`."""
    return num_frames is None and get_orchestrator().is_unawaited and not limits_remain()


def _run(num_frames: int | None, start_timeline: bool) -> Generator[None]:
    if num_frames is not None:
        _check_whole("num_frames", num_frames, least=0)
    return get_orchestrator().run(num_frames, start_timeline)


def _check_whole(name: str, value: Any, *, least: int | None = None) -> None:
    try:
        whole_number(name, value, least=least)
    except GraphError as error:
        raise OrchestratorError(f"orchestrator: {error}") from None


def wait_until_complete() -> None:
    """Wait until every scheduled file is written; raises the failure of a writer or its backend.

    Raises:
        OrchestratorError: a run that nothing ends has begun, and captured nothing yet.
    """
    get_orchestrator().finish()


async def wait_until_complete_async() -> None:
    """Run `wait_until_complete` in a coroutine."""
    await asyncio.sleep(0)
    wait_until_complete()


def stop() -> None:
    """End the run: wait for all files and notify writers. The next run repeats the draws of the first."""
    get_orchestrator().stop()


async def stop_async() -> None:
    """Run `stop` in a coroutine."""
    stop()
    await asyncio.sleep(0)


def pause() -> None:
    """Pause the captures of a run, or of a playing timeline, until `resume`.

    Where capture on play is set (`set_capture_on_play`), the timeline is paused, too.
    """
    get_orchestrator().pause()


def resume() -> None:
    """Continue after `pause`; after a `step`, let each update of the application capture a frame, until `stop`.

    Where capture on play is set, the next frame shows the time at which the timeline was paused, which then plays on.
    """
    get_orchestrator().resume()


def set_capture_on_play(value: bool) -> None:
    """Set whether every app update of a playing timeline is captured (default: True).

    If it is, stopping the timeline ends the run.

    Raises:
        OrchestratorError: `value` is neither True nor False.
    """
    if not isinstance(value, bool):
        raise OrchestratorError(f"orchestrator.set_capture_on_play: value is {value!r}; expected True or False")
    get_settings().set("/omni/replicator/captureOnPlay", bool(value))


def get_sim_times_to_write() -> list[float]:
    """Return the times of frames that are not yet captured: always [], since `step` returns complete frames."""
    return []


def set_next_rt_subframes(rt_subframes: int) -> None:
    """Set the number of sub-frames of the next capture; the setting, and triggers that fire, may require more.

    What a `step` is given counts instead.

    Raises:
        OrchestratorError: `rt_subframes` is not an integer.
    """
    _check_whole("rt_subframes", rt_subframes)
    get_orchestrator().sub_frames.set_next(rt_subframes)


def set_minimum_next_rt_subframes(rt_subframes: int) -> None:
    """Set the least number of sub-frames of the next capture, as `set_next_rt_subframes`, which may have set more.

    Raises:
        OrchestratorError: `rt_subframes` is not an integer.
    """
    _check_whole("rt_subframes", rt_subframes)
    get_orchestrator().sub_frames.set_minimum(rt_subframes)


def get_status() -> Status:
    """Return the status of the orchestrator."""
    # Scripts that ask for it wait for the end of a run by themselves.
    get_orchestrator().is_unawaited = False
    return get_orchestrator().status


def get_is_started() -> bool:
    """Return whether a run has started and is neither stopped nor paused.

    The first call after `run`, which returns when the run has ended, is True as well: scripts wait for the start.
    """
    return get_orchestrator().is_started()


def get_is_stopped() -> bool:
    """Return whether no run has started since the last one ended."""
    return get_status() is Status.STOPPED


def get_is_paused() -> bool:
    """Return whether the run is paused."""
    return get_status() is Status.PAUSED


def register_status_callback(callback: Callable[[Status], None]) -> StatusCallback:
    """Call `callback(status)` at every change while the returned handle is referenced and registered."""
    handle = StatusCallback(callback)
    handle.register()
    return handle


# A run takes turns by frames, so that other threads can look at it, pause and stop it.
name_parameters(globals(), without_turns=("run", "run_until_complete", *_STATUS))
