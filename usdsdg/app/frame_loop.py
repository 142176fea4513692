"""The order of one frame, and runs of many.

One frame: triggers and events write the stage → timeline and physics advance → render products are exposed, in
motion-blur sub-frames where asked → labels are rendered → annotators compute → writers write.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterator

from pxr import Usd

from usdsdg import rng
from usdsdg.app.app import get_app
from usdsdg.app.saved_graph import note_run
from usdsdg.app.status import OrchestratorError, Status, StatusCallback
from usdsdg.capture.capture import Capture
from usdsdg.capture.output import close_writers, drain
from usdsdg.capture.render_settings import RenderMode, render_mode
from usdsdg.capture.requests import is_watched
from usdsdg.errors import warn_once
from usdsdg.graph import evaluate
from usdsdg.session import stage_context
from usdsdg.session.progress import report
from usdsdg.session.session import current
from usdsdg.session.settings_store import get_settings
from usdsdg.session.timeline import get_timeline
from usdsdg.stage import assets


class Orchestrator:
    """Captures frames, and holds the state between two of them."""

    def __init__(self) -> None:
        self.status = Status.STOPPED
        self.captures = 0
        self._initialized = False  # since the stage was made or `stop`
        self._next_subframes = 0
        self._capture = Capture()
        self.status_callbacks: weakref.WeakSet[StatusCallback] = weakref.WeakSet()
        self._captured_callbacks: list[Callable[[], None]] = []
        self._asked_subframes = self._frames_of_last_run = 0

    def reset(self) -> None:
        """Begin with a new stage: nothing captured, nothing started."""
        self._set_status(Status.STOPPED)
        self.captures, self._initialized, self._next_subframes = 0, False, 0
        self._asked_subframes = self._frames_of_last_run = 0
        self._capture = Capture()

    # --- one frame ---
    def step(self, rt_subframes: int, pause_timeline: bool, delta_time: float | None) -> None:
        """Capture one frame; see `usdsdg.orchestrator.step` for the arguments."""
        self._start_if_stopped()
        self._set_status(Status.STEPPING)
        timeline = get_timeline()
        timeline.release()
        self._asked_subframes = max(rt_subframes, 0)
        fired = evaluate.graph().evaluate(capture=self.captures, time=timeline.get_elapsed_time())
        mode = render_mode(self._subframes(rt_subframes, fired))
        self._capture.begin(self.captures)
        self._advance_and_expose(mode, self._duration(delta_time))
        self._capture.finish(self.captures, timeline.get_current_time())
        self.captures += 1
        for callback in list(self._captured_callbacks):
            callback()
        if pause_timeline:
            timeline.hold()
        self._set_status(Status.STEPPED)

    def _advance_and_expose(self, mode: RenderMode, duration: float) -> None:
        """Move timeline and physics on by `duration` [s]; with motion blur, expose sub-frames on the way."""
        if mode.motion_blur and duration > 0.0:
            parts = mode.split(mode.sub_frames)
            self._capture.open_shutter()
            for part in parts:
                get_app().advance(duration / len(parts))
                self._capture.expose(part)
            return
        # The first captured frame shows the scene as it was set up.
        if duration > 0.0 and self.captures > 0:
            get_app().advance(duration)
        self._capture.expose(mode)

    def _duration(self, delta_time: float | None) -> float:
        timeline = get_timeline()
        if not timeline.is_playing():
            return 0.0
        return 1.0 / timeline.get_time_codes_per_seconds() if delta_time is None else float(delta_time)

    def _subframes(self, rt_subframes: int, fired: list[evaluate.Trigger]) -> int:
        wanted = rt_subframes if rt_subframes > 0 else get_settings().get_as_int("/omni/replicator/RTSubframes")
        minimum = max([self._next_subframes, *(trigger.rt_subframes for trigger in fired)], default=1)
        self._next_subframes = 0
        return max(wanted, minimum, 1)

    def _start_if_stopped(self) -> None:
        """Begin a run: at its first frame with counters, generators and a preview, then with a check of references."""
        if self.status is not Status.STOPPED:
            return
        if not self._initialized:
            self._set_status(Status.INITIALIZING)
            evaluate.graph().restart()
            rng.reset_all()
            self.preview()
            self._initialized = True
        for missing in assets.missing_dependencies(stage_context.current_stage()):
            warn_once(f"{missing.where} refers to {missing.asset_path}, which cannot be opened: {missing.why}")
        self._set_status(Status.STARTED)

    # --- many frames ---
    def capture_on_play(self) -> None:
        """Capture an app update of a playing timeline, where that is on and somebody is attached."""
        timeline = get_timeline()
        plays = timeline.is_playing() and timeline.is_auto_updating() and self.status is not Status.PAUSED
        if plays and get_settings().get_as_bool("/omni/replicator/captureOnPlay") and is_watched():
            self.step(-1, False, 0.0)

    def follow_timeline(self, event: str) -> None:
        """End the run when the timeline stops, where playing means capturing."""
        if event == "stop" and self.captures and get_settings().get_as_bool("/omni/replicator/captureOnPlay"):
            self.finish()

    def pause(self) -> None:
        """Capture nothing in `run`, and let the timeline stand, until `resume`."""
        if self.status is not Status.STOPPED:
            get_timeline().hold()
            self._set_status(Status.PAUSED)

    def resume(self) -> None:
        """Go on after `pause`."""
        if self.status is Status.PAUSED:
            self._set_status(Status.STARTED)
            get_timeline().release()

    def run(self, num_frames: int | None, start_timeline: bool) -> Iterator[None]:
        """Capture frame after frame and yield after each, until the run has ended or somebody has stopped it."""
        timeline = get_timeline()
        timeline.release()
        if start_timeline:
            timeline.play()
        self._capture.expected_frames = num_frames
        if self.status is Status.STOPPED:
            evaluate.graph().allow_again()
        if num_frames is None and not any(trigger.max_execs for trigger in evaluate.graph().triggers):
            raise OrchestratorError("orchestrator.run: nothing ends the run; give num_frames, or a trigger max_execs.")
        last = self.captures + (num_frames or 0)
        goes_on = _triggers_are_left if num_frames is None else lambda: self.captures < last
        while goes_on():
            if self.status is not Status.PAUSED:
                self.step(-1, False, None)
            yield
            if self.status is Status.STOPPED:
                return
        if num_frames is None:
            report("frames captured", self.captures, self.captures)
        self.finish()

    def expect_frames(self, count: int | None) -> None:
        """Set how many frames progress reports should expect; None: not known."""
        self._capture.expected_frames = count

    def preview(self) -> None:
        """Run every trigger of frames or of times once, capture nothing."""
        evaluate.graph().evaluate(time=get_timeline().get_elapsed_time(), preview=True)

    def finish(self) -> None:
        """Wait for all files, then tell writers that this was the last frame."""
        drain()
        if self.status is not Status.STOPPED:
            self._set_status(Status.STOPPED)
            close_writers()

    def stop(self) -> None:
        """End the run: the next frame is a first one again, with the draws of the first."""
        self.finish()
        self._frames_of_last_run = self.captures or self._frames_of_last_run
        self.captures, self._initialized = 0, False

    def note_run(self, stage: Usd.Stage) -> None:
        """Author what a saved stage needs to repeat the run."""
        note_run(stage, frames=self.captures or self._frames_of_last_run, rt_subframes=self._asked_subframes)

    # --- status ---
    def set_next_subframes(self, count: int) -> None:
        """Render the next frame with at least `count` sub-frames."""
        self._next_subframes = int(count)

    def on_captured(self, callback: Callable[[], None]) -> Callable[[], None]:
        """Call `callback()` after each captured frame; returns what ends it."""
        self._captured_callbacks.append(callback)
        return lambda: self._captured_callbacks.remove(callback) if callback in self._captured_callbacks else None

    def _set_status(self, status: Status) -> None:
        if status is self.status:
            return
        self.status = status
        for callback in sorted(self.status_callbacks, key=lambda each: each.number):
            callback.function(status)


def _triggers_are_left() -> bool:
    """Whether a trigger with `max_execs` has not run out yet.

    Raises:
        OrchestratorError: some have not, but none of them can fire any more.
    """
    left = [trigger for trigger in evaluate.graph().triggers if trigger.max_execs and not trigger.exhausted]
    reasons = [trigger.blocked() for trigger in left]
    if left and all(reasons):
        raise OrchestratorError(f"orchestrator.run: nothing ends the run: {'; '.join(reasons)}. Or give num_frames.")
    return bool(left)


def get_orchestrator() -> Orchestrator:
    """The orchestrator of the session."""
    return current().orchestrator
