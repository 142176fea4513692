"""The frame loop: capture one frame, or a run of frames.

The order of one frame: triggers and events write the stage → timeline and physics advance → render products are
exposed, in sub-frames if motion blur is on → labels are rendered → annotators compute → writers write.
"""

import sys
import threading
import weakref
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager

from pxr import Usd

from usdsdg import rng
from usdsdg.app.app import get_app
from usdsdg.app.exposing import expose
from usdsdg.app.frames_of_others import FramesOfOthers
from usdsdg.app.playback import Playback
from usdsdg.app.run_ends import (
    all_ended,
    are_frames_due,
    ends_without_picture,
    frames_remain,
    most_frames,
    never_ends,
    report_end,
    triggers_that_end,
)
from usdsdg.app.saved_graph import author_run, warn_of_idle_triggers
from usdsdg.app.status import OrchestratorError, Status, StatusCallback
from usdsdg.app.sub_frames import SubFrames
from usdsdg.capture.capture import Capture
from usdsdg.capture.output import close_writers, drain, in_spite_of_failures
from usdsdg.capture.pictures_ahead import PicturesAhead
from usdsdg.capture.render_settings import render_mode
from usdsdg.capture.worlds import WorldTap
from usdsdg.errors import Unsupported, called_for_script, warn_once
from usdsdg.graph import evaluate
from usdsdg.graph.firings import frames_until_exhausted
from usdsdg.listeners import Listeners
from usdsdg.session import stage_context
from usdsdg.session.devices.memory import device_memory
from usdsdg.session.endings.interrupted_frame import InterruptedFrame
from usdsdg.session.endings.termination import whole_frame
from usdsdg.session.interpreter_lock import switching_soon
from usdsdg.session.session import current
from usdsdg.session.settings.store import captures_on_play
from usdsdg.session.timeline import get_timeline
from usdsdg.session.turns import in_turn, turns
from usdsdg.stage import assets
from usdsdg.writers.journal.run import get_run


class Orchestrator:
    """Captures frames and keeps the state of a run."""

    def __init__(self) -> None:
        self.status = Status.STOPPED
        self.captures = 0
        self._initialized = False  # since the stage was made or `stop`
        self.sub_frames, self._playback = SubFrames(), Playback()
        self.capture = Capture()  # of one frame
        self._interrupted = InterruptedFrame()
        self.status_callbacks: weakref.WeakSet[StatusCallback] = weakref.WeakSet()
        self._captured: Listeners[[]] = Listeners()
        self._frames_of_last_run = 0
        self._start_unseen = False
        self._frames_of_run = 0  # captured since it started
        self._runs = False  # whether `run` or a playing timeline captures, not single steps
        self._run: object = None  # stands for the `run` that has begun last, until it ends
        self._is_open = False  # whether each app update captures a frame, until `stop`
        self.is_unawaited = False  # whether `run` has returned, and the script may still wait for it
        self._last: int | None = None  # frame before which the current `run` ends; None: triggers end it
        self.frames_without_end: int | None = None  # of a run that nothing ends; None: an error

    def reset(self) -> None:
        """Restore the initial state for a new stage; callbacks stay."""
        self._set_status(Status.STOPPED)
        self.captures, self._initialized, self._frames_of_last_run = 0, False, 0
        for part in (self.sub_frames, self._playback):
            part.reset()
        self._start_unseen = self.is_unawaited = self._is_open = False
        self.capture = Capture()

    # --- one frame ---
    @in_turn
    def step(self, rt_subframes: int, pause_timeline: bool, delta_time: float | None) -> None:
        """Capture one frame; see `usdsdg.orchestrator.step` for the arguments."""
        self.is_unawaited = False
        with self._interrupted.noticed(), whole_frame(), device_memory(), switching_soon():
            run = get_run()
            if (run.ends_early or run.is_at_exit) and threading.current_thread() is not threading.main_thread():
                sys.exit()  # this thread alone: its frames would be in no journal
            if current().worlds is not None:
                self._step_worlds(rt_subframes, current().worlds)
                return
            ahead = self._draw_ahead()
            for _ in range(ahead.count if ahead is not None else 1):
                self._step(rt_subframes, pause_timeline, delta_time, ahead)

    def _draw_ahead(self) -> PicturesAhead | None:
        """Draw the next frames together, where that is asked for; None if they are drawn one by one."""
        count = current().frames_together
        if count <= 1 or any(trigger.rt_subframes > 1 for trigger in evaluate.graph().triggers):
            return None
        self._start_if_stopped()
        count = count if self._last is None else max(1, min(count, self._last - self.captures))
        try:
            if self._runs and (ending := triggers_that_end(self._last)):
                count = frames_until_exhausted(ending, self.captures, count)
            return PicturesAhead(self.captures, count)
        except Unsupported as error:
            warn_once(f"{error} Frames are rendered one by one.")
            return None

    def _step(
        self, rt_subframes: int, pause_timeline: bool, delta_time: float | None, ahead: PicturesAhead | None
    ) -> None:
        self._start_if_stopped()
        self._set_status(Status.STARTED if self._runs else Status.STEPPING)
        timeline = get_timeline()
        self._playback.play(delta_time, is_first=not self._frames_of_run, runs=self._runs)
        self.sub_frames.of_step = max(rt_subframes, 0)
        if ahead is None:
            with timeline.before_picture(self._playback.until_picture(delta_time, is_first=not self.captures)):
                fired = evaluate.graph().evaluate(capture=self.captures, time=timeline.get_picture_elapsed_time())
            if self._run is not None and self._last is None and ends_without_picture(fired):
                return
        else:
            ahead.show(self.captures)
            fired = []
        mode = render_mode(self.sub_frames.take(rt_subframes, fired))
        self.capture.begin(self.captures, ahead)
        try:
            duration, bodies_wait = self._playback.duration(delta_time), evaluate.puts_bodies_back(fired)
            expose(self.capture, mode, duration, is_first=not self.captures, bodies_wait=bodies_wait)
            self.capture.finish(self.captures, timeline.get_current_time())
        except BaseException:
            self.capture.give_up()
            if self.capture.is_handed_over:
                self.captures += 1
                self._end_step(pause_timeline)
            raise
        self.captures += 1
        self._captured.call()
        self._end_step(pause_timeline)

    def _end_step(self, pause_timeline: bool) -> None:
        self._frames_of_run += 1
        self._is_open = self._is_open and self._runs
        self._playback.end_frame(pause_timeline)
        self._set_status(Status.STARTED if self._runs else Status.STEPPED)

    def _step_worlds(self, rt_subframes: int, tap: WorldTap) -> None:
        """Capture many worlds, as if they were the next frames; graph and renderer run once for all of them."""
        self._start_if_stopped()
        self._set_status(Status.STEPPING)
        values = tap.draw(self.captures)
        mode = render_mode(self.sub_frames.take(rt_subframes, evaluate.graph().triggers))
        tap.capture(values, self.captures, mode)
        self.captures += tap.count
        self._captured.call()
        self._set_status(Status.STEPPED)

    def _start_if_stopped(self) -> None:
        """Start a run: reset counters and generators and run a preview if not initialized, then check references.

        A run that cannot start is stopped, so that the next one is checked again.
        """
        if self.status is not Status.STOPPED:
            return
        try:
            if not self._initialized:
                self.status = Status.INITIALIZING  # of which callbacks are not told, as in Replicator
                evaluate.graph().restart()
                rng.reset_all()
                self.preview()
                self._initialized = True
            warn_of_idle_triggers(stage_context.current_stage())
            assets.check_missing(stage_context.current_stage())
            assets.name_other_metrics(stage_context.current_stage())
        except BaseException:
            self._set_status(Status.STOPPED)
            raise
        self._frames_of_run = 0
        self._set_status(Status.STARTING)

    # --- many frames ---
    def capture_on_play(self, played: bool) -> None:
        """Capture an app update of an open run, or of a playing timeline if that is set and something waits for frames.

        When all triggers have reached their limits, or a timeline that does not loop its end, the run ends and the
        timeline stops.

        played: whether the update has advanced the timeline.
        """
        timeline = get_timeline()
        plays = (played and (timeline.is_playing() or timeline.has_ended())) or self._playback.resumes
        is_due = self._is_open or (plays and captures_on_play() and are_frames_due())
        if is_due and self.status is not Status.PAUSED:
            if self.status is Status.STOPPED:
                evaluate.graph().renew_limits()
            # Time triggers fire in the update, before its picture.
            if not ends_without_picture([each for each in evaluate.graph().triggers if each.exhausted]):
                with self._running():
                    self.step(-1, False, 0.0)
            if all_ended(self.captures) or timeline.has_ended():
                self.finish()

    @contextmanager
    def _running(self) -> Iterator[None]:
        self._runs = True
        try:
            yield
        finally:
            self._runs = False

    def follow_timeline(self, event: str) -> None:
        """End, pause or go on with the captures of a playing timeline as it stops, pauses or plays."""
        if not captures_on_play():
            return
        if event == "stop" and self.captures:
            self.finish()
        elif event == "play" and self.status is Status.PAUSED:
            self._set_status(Status.STARTED)
        elif event == "pause" and get_timeline().has_ended():
            self._playback.has_ended = True  # which a last frame shows
        elif event == "pause" and self.status is Status.STARTED and self._run is None:
            self._set_status(Status.PAUSED)

    def pause(self) -> None:
        """Pause the captures of `run` or a playing timeline until `resume`, and the timeline if that is captured."""
        if self.status is not Status.STOPPED:
            self._set_status(Status.PAUSED)
            if captures_on_play():
                get_timeline().pause()

    def resume(self) -> None:
        """Continue after `pause`, or capture every app update after a `step`.

        A timeline that is captured plays on after a frame of the time at which it paused.
        """
        if self.status in (Status.PAUSED, Status.STEPPED):
            self._is_open = self._is_open or self.status is Status.STEPPED
            self._set_status(Status.STARTED)
            self._playback.resumes = captures_on_play()

    def begin_run(self, start_timeline: bool) -> None:
        """Begin an open run, which captures a frame at each app update until `stop`.

        The timeline plays after the first frame, as in `run`.
        """
        self._begin_anew()
        self._start_if_stopped()
        self._set_status(Status.STARTED)
        self._is_open, self._playback.resumes = True, captures_on_play() or start_timeline

    def check_open_run(self) -> None:
        """Raise if an open run has begun, and no app update has captured a frame of it."""
        if self._is_open and not self._frames_of_run:
            self._is_open = False
            raise never_ends()

    def _begin_anew(self) -> None:
        """Leave what steps or a run have drawn and counted before, which is not part of the next run."""
        self._is_open = False
        if self.status is Status.PAUSED:
            self._set_status(Status.STARTED)
        elif self.captures:
            self.stop()
        if self.status is Status.STOPPED:
            evaluate.graph().renew_limits()
        self._playback.reset()

    def run(self, num_frames: int | None, start_timeline: bool) -> Generator[None]:
        """Capture frames and yield after each, until the run has ended or has been stopped."""
        if self._run is not None and self.status is not Status.STOPPED:
            raise OrchestratorError(
                "orchestrator.run: another run captures frames already; await it, or end it with orchestrator.stop()."
            )
        self._begin_anew()
        get_timeline().release()
        if start_timeline:
            get_timeline().play()
        num_frames = most_frames(num_frames)
        expected_before = self.capture.expected_frames  # by a job that this run is part of
        self._last = self.capture.expected_frames = None if num_frames is None else self.captures + num_frames
        others = FramesOfOthers(self.capture, self._is_unseen)
        self._start_unseen = True
        this = self._run = object()
        try:
            has_begun = False
            while True:
                with turns:  # in which other threads pause and stop
                    if has_begun and (self.status is Status.STOPPED or self._run is not this):
                        return
                    if not frames_remain(self.captures, self._last):
                        break
                    if self.status is not Status.PAUSED:
                        with self._running():
                            self._pass_over_others(others)
                            if not self._playback.has_ended:
                                self.step(-1, False, None)
                    has_begun = True
                    if self._playback.has_ended:
                        break
                yield
            report_end(num_frames, self.captures, self._last)
        finally:
            if self._run is this:
                self._run, self._last, self.capture.expected_frames = None, None, expected_before
        self.finish()

    def expect_frames(self, count: int | None, *, before: int = 0) -> None:
        """Set how many frames a job has, for progress reports, None if it is not known, and how many are before.

        before: frames of the job on earlier stages, after which the frames of this one are counted.
        """
        self.capture.expected_frames, self.capture.frames_before = count, before

    def _pass_over_others(self, others: FramesOfOthers) -> None:
        """Count the next frames of a run that other processes make, as far as these need not be evaluated here."""
        if self.status is not Status.STOPPED and self._frames_of_run:  # else the first frame starts the run
            for _ in others.pass_over(self.captures, self._last, self._playback):
                self.captures += 1
                self._frames_of_run += 1

    def _is_unseen(self) -> bool:
        """Return whether no code of the script can look at the stage between frames."""
        return not self._captured and not get_app().has_other_tasks()

    def pass_over(self, frames: int) -> None:
        """Count frames that other processes make, without evaluating, simulating or rendering anything."""
        for _ in range(frames):
            self.capture.pass_over(self.captures)
            self.captures += 1

    def preview(self) -> None:
        """Run every frame and time trigger once without capturing."""
        current().observations.previews += 1
        evaluate.graph().evaluate(time=get_timeline().get_elapsed_time(), preview=True)

    @in_turn
    def finish(self) -> None:
        """Wait for all files, then notify writers that the last frame has been written; raises the first failure.

        Where capture on play is set, the timeline is stopped before.
        """
        self.check_open_run()
        self.is_unawaited = self._is_open = False
        if self.status is not Status.STOPPED and captures_on_play():
            get_timeline().stop()
        if self.status is Status.STOPPED:
            drain()
        else:
            self._set_status(Status.STOPPING)
            in_spite_of_failures(drain, lambda: self._set_status(Status.STOPPED), close_writers)

    def stop(self) -> None:
        """End the run: the next frame is again a first frame, with the same draws."""
        self._is_open = False
        self.finish()
        self._frames_of_last_run = self.captures or self._frames_of_last_run
        self.captures, self._initialized, self._start_unseen = 0, False, False

    def author_run(self, stage: Usd.Stage) -> None:
        """Author what a saved stage needs to repeat the run."""
        author_run(stage, frames=self.captures or self._frames_of_last_run, rt_subframes=self.sub_frames.of_step)

    # --- status ---
    def is_started(self) -> bool:
        """Return whether a run has started and is neither stopped nor paused.

        Scripts wait until the run that they have started is seen to start. `run` returns after its last frame, so a run
        that nobody has asked about counts as started once more.
        """
        unseen, self._start_unseen, self.is_unawaited = self._start_unseen, False, False
        return self.status in (Status.STARTED, Status.STEPPING, Status.STEPPED) or (
            unseen and self.status is Status.STOPPED
        )

    def on_captured(self, callback: Callable[[], None]) -> Callable[[], None]:
        """Call `callback()` after each captured frame; return the unsubscriber."""
        return self._captured.subscribe(callback)

    def _set_status(self, status: Status) -> None:
        if status is self.status:
            return
        self.status = status
        for callback in sorted(self.status_callbacks, key=lambda each: each.number):
            with called_for_script("a status callback of the orchestrator"):
                callback.function(status)


def get_orchestrator() -> Orchestrator:
    """Return the orchestrator of the session."""
    return current().orchestrator
