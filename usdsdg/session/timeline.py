"""The timeline: play, pause, stop and time, with the interface of `omni.timeline`. Times are in seconds."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from pxr import Usd

from usdsdg.errors import BadValue, Unsupported
from usdsdg.listeners import Listeners
from usdsdg.session import stage_times
from usdsdg.session.session import current
from usdsdg.session.stage_times import StageTimes
from usdsdg.stage.time_code import time_code_at

DEFAULT_RATE = 60.0
DEFAULT_END_TIME = 100 / DEFAULT_RATE
# Seconds: what sums of frames may lack of an end that is a multiple of these.
ROUNDING = 1e-6


class Timeline:
    """The simulation clock; scripts control it, the app and the orchestrator advance it.

    Commands take effect at once, so `commit` does nothing. A looping timeline wraps to its start; one that does not
    loop pauses at its end.

    Rate and range follow what a script authors on the current stage (`timeCodesPerSecond`, `startTimeCode`,
    `endTimeCode`), and the rate that is set here is authored there, as in Kit. A range that is set here is not.
    """

    def __init__(self) -> None:
        self._playing = False
        self._stopped = True
        self._time = 0.0
        self._start, self._end = 0.0, DEFAULT_END_TIME
        self._looping = True
        self._auto_update = True
        self._held = False
        self._looped = 0.0  # seconds subtracted by loops
        self.latest_advance = 0.0  # seconds of the latest `advance`
        self._rate = DEFAULT_RATE  # time codes per second
        self._target_framerate: float | None = None
        # Start, end and looping of the range that `play` was given, until the next stop.
        self._played_range: tuple[float, float, bool] | None = None
        self._range_is_authored = False  # else a script set it, or it is the default
        self._before_picture = False
        self._until_picture = 0.0  # seconds
        self._shown_is_set = False  # whether the next advance leaves the time as it is
        self._stage_times: StageTimes | None = None  # those that rate and range have followed
        self._listeners: Listeners[[str]] = Listeners()

    # --- state ---
    def is_playing(self) -> bool:
        return self._playing

    def is_stopped(self) -> bool:
        return self._stopped

    def has_ended(self) -> bool:
        """Return whether it is paused at the end of what it plays, as where it does not loop."""
        start, end, looping = self._played()
        return not (self._playing or self._stopped or looping) and end > start and self._time >= end

    def get_current_time(self) -> float:
        return self._time

    def get_elapsed_time(self) -> float:
        """Return the time without wrapping at loops, counted since a script last set the time or stopped."""
        return self._time + self._looped

    def get_start_time(self) -> float:
        self._follow_stage()
        return self._start

    def get_end_time(self) -> float:
        self._follow_stage()
        return self._end

    def is_looping(self) -> bool:
        return self._looping

    def is_auto_updating(self) -> bool:
        return self._auto_update

    def get_time_codes_per_seconds(self) -> float:
        """Return the rate that time codes and app updates have [1/s].

        Raises:
            BadValue: a script authored one that is not above 0 on the stage.
        """
        self._follow_stage()
        return self._rate

    get_time_codes_per_second = get_time_codes_per_seconds

    # --- commands ---
    def play(self, start_timecode: float = 0.0, end_timecode: float = 0.0, looping: bool = True) -> None:
        """Play on, or from and within a range of time codes, until the next stop; start and end time stay as they are.

        Raises:
            BadValue: the range is not finite, or its end is not after its start.
        """
        start, end = (float(code) / self.get_time_codes_per_seconds() for code in (start_timecode, end_timecode))
        if (start, end) != (0.0, 0.0):
            if not start < end < math.inf:
                raise BadValue(f"timeline.play({start_timecode}, {end_timecode}): the end is to be after the start")
            self.set_current_time(start)
            self._played_range = start, end, bool(looping)
        self._held = False
        if not self._playing:
            self._playing, self._stopped = True, False
            self._notify("play")

    def pause(self) -> None:
        self._held = False
        if self._playing:
            self._playing = False
            self._notify("pause")

    def stop(self) -> None:
        """Stop and return to the start time; physics restores the poses of its bodies."""
        self._held = False
        if not self._stopped:
            self._playing, self._stopped, self._played_range = False, True, None
            self.set_current_time(self.get_start_time())
            self._notify("stop")

    def set_current_time(self, seconds: float) -> None:
        """Go to a time.

        Raises:
            BadValue: it is not finite, or more than `stage_times.MOST_SECONDS` from 0.
        """
        if not abs(float(seconds)) <= stage_times.MOST_SECONDS:
            raise BadValue(f"timeline.set_current_time({seconds}): expected at most {stage_times.MOST_SECONDS:g} s")
        self._time, self._looped = float(seconds), 0.0

    def set_start_time(self, seconds: float) -> None:
        self._set_range(float(seconds), self.get_end_time())

    def set_end_time(self, seconds: float) -> None:
        self._set_range(self.get_start_time(), float(seconds))

    def set_looping(self, looping: bool) -> None:
        self._looping = bool(looping)

    def set_auto_update(self, auto_update: bool) -> None:
        """Set whether app updates advance the time."""
        self._auto_update = bool(auto_update)

    def set_time_codes_per_second(self, rate: float) -> None:
        """Set the rate of time codes and app updates [1/s], here and on the stage; the range stays in seconds.

        Raises:
            BadValue: the rate is not a finite number above 0.
        """
        rate = float(rate)
        if not (math.isfinite(rate) and rate > 0.0):
            raise BadValue(f"timeline.set_time_codes_per_second({rate}): expected a finite number > 0")
        self._follow_stage()
        self._rate, stage = rate, current().stage
        if stage is not None:
            stage_times.set_rate(stage, rate)
            self._stage_times = stage_times.of_stage(stage)

    def set_target_framerate(self, rate: float) -> None:
        """Note a rate [1/s] at which updates are to follow each other in real time, for which none waits here.

        How far an update advances the time is up to the time codes per second, as in Kit.
        """
        self._target_framerate = float(rate)

    def get_target_framerate(self) -> float:
        """Return the rate that was set, or the time codes per second."""
        return self.get_time_codes_per_seconds() if self._target_framerate is None else self._target_framerate

    def set_play_every_frame(self, every: bool) -> None:
        """Do nothing: no frame is ever skipped."""

    set_fast_mode = set_play_every_frame

    def get_ticks_per_frame(self) -> int:
        """Return how often the time advances per update: once."""
        return 1

    def get_ticks_per_second(self) -> float:
        """Return how often the time advances per second of the timeline."""
        return self.get_time_codes_per_seconds()

    def time_to_time_code(self, seconds: float) -> float:
        """Return the time code of a time."""
        return float(seconds) * self.get_time_codes_per_seconds()

    def time_code_to_time(self, time_code: float) -> float:
        """Return the time of a time code [s]."""
        return float(time_code) / self.get_time_codes_per_seconds()

    def set_ticks_per_frame(self, ticks: int) -> None:
        """Set how often the time advances per update.

        Raises:
            Unsupported: any number but 1.
        """
        if int(ticks) != 1:
            raise Unsupported(
                f"timeline.set_ticks_per_frame({ticks}): the time advances once per update; raise time codes per second"
            )

    def commit(self) -> None:
        """Do nothing: commands take effect at once."""

    commit_silently = commit

    def get_timeline_event_stream(self) -> Any:
        """Return the stream of events (`carb.events`) of this timeline, with the types of `TimelineEventType`."""
        return current().event_streams.timeline

    def forward_one_frame(self) -> None:
        self.advance(1.0 / self.get_time_codes_per_seconds())

    def rewind_one_frame(self) -> None:
        self._time = max(self.get_start_time(), self._time - 1.0 / self._rate)

    # --- driven by the app and the orchestrator ---
    def hold(self) -> None:
        """Pause a playing timeline until `release`; a command in between cancels the hold."""
        held = self._playing
        self.pause()
        self._held = held

    def release(self) -> None:
        """Resume playing after `hold`."""
        if self._held:
            self.play()

    def advance(self, seconds: float) -> None:
        """Advance the time by `seconds`; wrap or pause at the end."""
        self._follow_stage()
        self.latest_advance = seconds
        if self._shown_is_set:  # the next picture shows the time that was set for it, even one beyond the end
            self._shown_is_set = False
            self._notify("tick")
            return
        self._time += seconds
        start, end, looping = self._played()
        if end > start and self._time >= (end if looping else end - ROUNDING):
            self._wrap_or_pause()
        self._notify("tick")

    @contextmanager
    def before_picture(self, seconds: float) -> Iterator[None]:
        """Within, the time will be advanced by `seconds` before the next picture is taken."""
        self._until_picture, self._shown_is_set, self._before_picture = seconds, False, True
        try:
            yield
        finally:
            self._until_picture, self._before_picture = 0.0, False

    def show(self, seconds: float) -> None:
        """Go to a time, which is that of the next picture where this is called in `before_picture`.

        Raises:
            BadValue: as `set_current_time`.
        """
        self.set_current_time(seconds)
        if self._before_picture:
            self._until_picture, self._shown_is_set = 0.0, True

    def get_picture_time(self) -> float:
        """Return the time at which the next picture is taken [s]."""
        time = self.get_current_time() + self._until_picture
        start, end, looping = self._played()
        if self._until_picture > 0.0 and end > start and time >= end:
            return self._wrapped(time) if looping else end
        return time

    def get_picture_elapsed_time(self) -> float:
        """As `get_picture_time`, without wrapping at loops: the time by which time triggers fire."""
        ahead = self._until_picture
        start, end, looping = self._played()
        if not looping and end > start:
            ahead = max(min(ahead, end - self.get_current_time()), 0.0)
        return self.get_elapsed_time() + ahead

    def _played(self) -> tuple[float, float, bool]:
        """Return start and end of what is played [s], and whether it begins again at its end."""
        return self._played_range or (self._start, self._end, self._looping)

    def _wrapped(self, time: float) -> float:
        start, end, _ = self._played()
        return start + (time - end) % (end - start)

    def _wrap_or_pause(self) -> None:
        _, end, looping = self._played()
        if looping:
            before = self._time
            self._time = self._wrapped(before)
            self._looped += before - self._time
            self._notify("loop")
        else:
            self._time = end
            self.pause()

    def subscribe(self, listener: Callable[[str], None]) -> Callable[[], None]:
        """Call `listener(change)` after each "play", "pause", "stop", "loop" and "tick"; return the unsubscriber."""
        return self._listeners.subscribe(listener)

    def _notify(self, event: str) -> None:
        self._listeners.call(event)

    # --- the stage ---
    def begin_stage(self, stage: Usd.Stage) -> None:
        """Take the range and rate of the animation of a stage that has one, and go to its start.

        Raises:
            BadValue: its time codes are not finite, or their rate is not above 0.
        """
        self._stage_times = stage_times.of_stage(stage)
        if self._stage_times.seconds is not None:
            self._take(self._stage_times)
            self.set_current_time(self._start)

    def _follow_stage(self) -> None:
        """Take the rate and the range that a script has authored since they were looked at."""
        stage = current().stage
        if stage is None or self._stage_times is None:
            return
        now, before = stage_times.of_stage(stage), self._stage_times
        if now != before:
            self._stage_times = now
            self._take(now, with_range=self._range_is_authored or now[1:] != before[1:])

    def _take(self, authored: StageTimes, with_range: bool = True) -> None:
        self._rate = authored.rate
        if with_range and authored.seconds is not None:
            self._start, self._end = authored.seconds
            self._range_is_authored = True

    def _set_range(self, start: float, end: float) -> None:
        self._start, self._end, self._range_is_authored = start, end, False

    def reset(self) -> None:
        """Restore the state of a new stage; listeners stay."""
        self.stop()
        self._set_range(0.0, DEFAULT_END_TIME)
        self.set_current_time(0.0)
        self._looping, self._auto_update = True, True
        self._rate, self._stage_times, self._target_framerate = DEFAULT_RATE, None, None


def get_timeline() -> Timeline:
    """Return the timeline of the session (`omni.timeline.get_timeline_interface()`)."""
    return current().timeline


def stage_time(stage: Usd.Stage) -> Usd.TimeCode:
    """Return the current time of the timeline as a time code of a stage."""
    return time_code_at(get_timeline().get_current_time(), stage)


def picture_time(stage: Usd.Stage) -> Usd.TimeCode:
    """Return the time of the next picture as a time code of a stage: what triggers write is seen then."""
    return time_code_at(get_timeline().get_picture_time(), stage)
