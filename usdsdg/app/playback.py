"""The timeline during captures: when these play it, and how far each frame goes."""

from usdsdg.app.app import get_app
from usdsdg.capture.render_settings import opens_shutter
from usdsdg.session.settings.store import captures_motion_blur, captures_on_play
from usdsdg.session.timeline import get_timeline


class Playback:
    """Plays the timeline for frames, as they do themselves where capture on play is set."""

    def __init__(self) -> None:
        self.resumes = False  # whether the next frame shows the time of a pause, after which the timeline plays on
        self.has_ended = False  # whether the timeline has come to an end, without looping, since a run has begun

    def reset(self) -> None:
        self.resumes = self.has_ended = False

    def play(self, delta_time: float | None, *, is_first: bool, runs: bool) -> None:
        """Play what `step` has held, and the timeline itself where the frame is to do that.

        is_first: of a run, which shows the scene as it was set up.
        runs: whether the frame is one of a run or of a playing timeline, not of a single step.
        """
        timeline = get_timeline()
        timeline.release()
        self.resumes = self.resumes and runs and not timeline.is_playing()
        if not is_first and not self.resumes and self._plays(delta_time):
            timeline.play()

    def _plays(self, delta_time: float | None) -> bool:
        if not captures_on_play():
            return False
        return captures_motion_blur() or (delta_time is None and get_timeline().is_auto_updating())

    def end_frame(self, pause_timeline: bool) -> None:
        """Play on after a frame that showed the time of a pause, or pause until the next step."""
        if self.resumes:
            self.resumes = False
            get_timeline().play()
        if pause_timeline:
            get_timeline().hold()

    def duration(self, delta_time: float | None) -> float:
        """Return the seconds of a frame; without `delta_time` only a playing timeline advances."""
        if delta_time is not None:
            return float(delta_time)
        return get_app().seconds_of_update() if get_timeline().is_playing() else 0.0

    def until_picture(self, delta_time: float | None, *, is_first: bool) -> float:
        """Return the seconds by which the timeline will advance before the picture, or before its shutter closes."""
        return max(self.duration(delta_time), 0.0) if not is_first or opens_shutter() else 0.0
