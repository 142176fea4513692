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
from usdsdg.app.frames_of_others import FramesOfOthers
from usdsdg.app.run_ends import all_ended, are_frames_due, ends_without_picture, triggers_remain, triggers_that_end
from usdsdg.app.saved_graph import author_run
from usdsdg.app.status import OrchestratorError, Status, StatusCallback
from usdsdg.capture.capture import Capture
from usdsdg.capture.output import close_writers, drain, in_spite_of_failures
from usdsdg.capture.pictures_ahead import PicturesAhead
from usdsdg.capture.render_settings import RenderMode, opens_shutter, render_mode
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
from usdsdg.session.progress import report_frames
from usdsdg.session.session import current
from usdsdg.session.settings.store import captures_motion_blur, captures_on_play, get_settings
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
        self._next_subframes = 0
        self.capture = Capture()  # of one frame
        self._interrupted = InterruptedFrame()
        self.status_callbacks: weakref.WeakSet[StatusCallback] = weakref.WeakSet()
        self._captured: Listeners[[]] = Listeners()
        self._requested_subframes = self._frames_of_last_run = 0
        self._start_unseen = False
        self._frames_of_run = 0  # captured since it started
        self._runs = False  # whether `run` or a playing timeline captures, not single steps
        self._run: object = None  # stands for the `run` that has begun last, until it ends
        self.is_unawaited = False  # whether `run` has returned, and the script may still wait for it
        self._last: int | None = None  # frame before which the current `run` ends; None: triggers end it
        self.frames_without_end: int | None = None  # of a run that nothing ends; None: an error

    def reset(self) -> None:
        """Restore the initial state for a new stage; callbacks stay."""
        self._set_status(Status.STOPPED)
        self.captures, self._initialized, self._next_subframes = 0, False, 0
        self._requested_subframes = self._frames_of_last_run = 0
        self._start_unseen = self.is_unawaited = False
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
        timeline.release()
        if self._plays_timeline(delta_time):
            timeline.play()
        self._requested_subframes = max(rt_subframes, 0)
        if ahead is None:
            with timeline.before_picture(self._until_picture(delta_time)):
                fired = evaluate.graph().evaluate(capture=self.captures, time=timeline.get_picture_elapsed_time())
            if self._run is not None and self._last is None and ends_without_picture(fired):
                return
        else:
            ahead.show(self.captures)
            fired = []
        mode = render_mode(self._subframes(rt_subframes, fired))
        self.capture.begin(self.captures, ahead)
        try:
            self._advance_and_expose(mode, self._duration(delta_time), evaluate.puts_bodies_back(fired))
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
        if pause_timeline:
            get_timeline().hold()
        self._set_status(Status.STARTED if self._runs else Status.STEPPED)

    def _plays_timeline(self, delta_time: float | None) -> bool:
        """Return whether a frame plays the timeline itself, as all but the first do where capture on play is set."""
        if not self._frames_of_run or not captures_on_play():
            return False
        return captures_motion_blur() or (delta_time is None and get_timeline().is_auto_updating())

    def _step_worlds(self, rt_subframes: int, tap: WorldTap) -> None:
        """Capture many worlds, as if they were the next frames; graph and renderer run once for all of them."""
        self._start_if_stopped()
        self._set_status(Status.STEPPING)
        values = tap.draw(self.captures)
        mode = render_mode(self._subframes(rt_subframes, evaluate.graph().triggers))
        tap.capture(values, self.captures, mode)
        self.captures += tap.count
        self._captured.call()
        self._set_status(Status.STEPPED)

    def _advance_and_expose(self, mode: RenderMode, duration: float, bodies_wait: bool) -> None:
        """Advance timeline, and physics if it plays, by `duration` [s]; motion blur exposes sub-frames in between."""
        if mode.motion_blur and duration > 0.0:
            parts = mode.split(mode.sub_frames)
            self.capture.open_shutter()
            for part in parts:
                get_app().advance(duration / len(parts), bodies_wait=bodies_wait)
                self.capture.expose(part)
            return
        # The first captured frame shows the scene as it was set up.
        if duration > 0.0 and self.captures > 0:
            get_app().advance(duration, bodies_wait=bodies_wait)
        self.capture.expose(mode)

    def _duration(self, delta_time: float | None) -> float:
        """Return the seconds of a frame; without `delta_time` only a playing timeline advances."""
        if delta_time is not None:
            return float(delta_time)
        timeline = get_timeline()
        return 1.0 / timeline.get_time_codes_per_seconds() if timeline.is_playing() else 0.0

    def _until_picture(self, delta_time: float | None) -> float:
        """Return the seconds by which the timeline will advance before the picture, or before its shutter closes."""
        advances = self.captures > 0 or opens_shutter()
        return max(self._duration(delta_time), 0.0) if advances else 0.0

    def _subframes(self, rt_subframes: int, fired: list[evaluate.Trigger]) -> int:
        requested = rt_subframes if rt_subframes > 0 else get_settings().get_as_int("/omni/replicator/RTSubframes")
        minimum = max([self._next_subframes, *(trigger.rt_subframes for trigger in fired)], default=1)
        self._next_subframes = 0
        return max(requested, minimum, 1)

    def _start_if_stopped(self) -> None:
        """Start a run: reset counters and generators and run a preview if not initialized, then check references.

        A run that cannot start is stopped, so that the next one is checked again.
        """
        if self.status is not Status.STOPPED:
            return
        try:
            if not self._initialized:
                self._set_status(Status.INITIALIZING)
                evaluate.graph().restart()
                rng.reset_all()
                self.preview()
                self._initialized = True
            assets.check_missing(stage_context.current_stage())
            assets.name_other_metrics(stage_context.current_stage())
        except BaseException:
            self._set_status(Status.STOPPED)
            raise
        self._frames_of_run = 0
        self._set_status(Status.STARTED)

    # --- many frames ---
    def capture_on_play(self) -> None:
        """Capture an app update of a playing timeline if capture on play is set, and something waits for frames.

        When all triggers have reached their limits, the run ends and the timeline stops.
        """
        timeline = get_timeline()
        plays = timeline.is_playing() and timeline.is_auto_updating() and self.status is not Status.PAUSED
        if plays and captures_on_play() and are_frames_due():
            if self.status is Status.STOPPED:
                evaluate.graph().renew_limits()
            # Time triggers fire in the update, before its picture.
            if not ends_without_picture([each for each in evaluate.graph().triggers if each.exhausted]):
                with self._running():
                    self.step(-1, False, 0.0)
            if all_ended():
                self.finish()

    @contextmanager
    def _running(self) -> Iterator[None]:
        self._runs = True
        try:
            yield
        finally:
            self._runs = False

    def follow_timeline(self, event: str) -> None:
        """End the run when the timeline stops, if capture on play is set."""
        if event == "stop" and self.captures and captures_on_play():
            self.finish()

    def pause(self) -> None:
        """Pause the captures of `run` and the timeline until `resume`."""
        if self.status is not Status.STOPPED:
            get_timeline().hold()
            self._set_status(Status.PAUSED)

    def resume(self) -> None:
        """Continue after `pause`."""
        if self.status is Status.PAUSED:
            self._set_status(Status.STARTED)
            get_timeline().release()

    def run(self, num_frames: int | None, start_timeline: bool) -> Generator[None]:
        """Capture frames and yield after each, until the run has ended or has been stopped."""
        if self._run is not None and self.status is not Status.STOPPED:
            raise OrchestratorError(
                "orchestrator.run: another run captures frames already; await it, or end it with orchestrator.stop()."
            )
        timeline = get_timeline()
        timeline.release()
        if start_timeline:
            timeline.play()
        if self.status is Status.STOPPED:
            evaluate.graph().renew_limits()
        if num_frames is None and not any(trigger.max_execs for trigger in evaluate.graph().triggers):
            num_frames = self.frames_without_end
            if num_frames is None:
                raise OrchestratorError(
                    "orchestrator.run: nothing ends the run; give num_frames, or a trigger max_execs, or "
                    "`usdsdg run --frames N`."
                )
        expected_before = self.capture.expected_frames  # by a job that this run is part of
        self.capture.expected_frames = None if num_frames is None else self.captures + num_frames
        last = self.captures + (num_frames or 0)
        self._last = last if num_frames is not None else None
        others = FramesOfOthers(self.capture, self._is_unseen)
        self._start_unseen = True
        this = self._run = object()
        frames_remain = triggers_remain if num_frames is None else lambda: self.captures < last and not all_ended()
        try:
            has_begun = False
            while True:
                with turns:  # in which other threads pause and stop
                    if has_begun and (self.status is Status.STOPPED or self._run is not this):
                        return
                    if not frames_remain():
                        break
                    if self.status is not Status.PAUSED:
                        with self._running():
                            self._pass_over_others(others)
                            self.step(-1, False, None)
                    has_begun = True
                yield
        finally:
            if self._run is this:
                self._run, self._last, self.capture.expected_frames = None, None, expected_before
        if num_frames is None:
            made = get_run().own_frames(self.captures)
            report_frames(made, made)
        self.finish()

    def expect_frames(self, count: int | None, *, before: int = 0) -> None:
        """Set how many frames a job has, for progress reports, None if it is not known, and how many are before.

        before: frames of the job on earlier stages, after which the frames of this one are counted.
        """
        self.capture.expected_frames, self.capture.frames_before = count, before

    def _pass_over_others(self, others: FramesOfOthers) -> None:
        """Count the next frames of a run that other processes make, as far as these need not be evaluated here."""
        while self._frames_of_run and (count := others.count(self.captures, self._last)):
            end = self.captures + count
            while self.captures < end:
                with whole_frame():
                    others.fire(self.captures, end)
                    if self._plays_timeline(None):
                        get_timeline().play()
                    if seconds := self._duration(None):
                        get_app().advance(seconds)
                    self.capture.pass_over(self.captures)
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
        self.is_unawaited = False
        if self.status is not Status.STOPPED and captures_on_play():
            get_timeline().stop()
        if self.status is Status.STOPPED:
            drain()
        else:
            in_spite_of_failures(drain, lambda: self._set_status(Status.STOPPED), close_writers)

    def stop(self) -> None:
        """End the run: the next frame is again a first frame, with the same draws."""
        self.finish()
        self._frames_of_last_run = self.captures or self._frames_of_last_run
        self.captures, self._initialized, self._start_unseen = 0, False, False

    def author_run(self, stage: Usd.Stage) -> None:
        """Author what a saved stage needs to repeat the run."""
        author_run(stage, frames=self.captures or self._frames_of_last_run, rt_subframes=self._requested_subframes)

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

    def set_next_subframes(self, count: int) -> None:
        """Render the next frame with at least `count` sub-frames."""
        self._next_subframes = int(count)

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
