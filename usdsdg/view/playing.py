"""Physics of the viewed stage: played in real time as far as the machine keeps up, stepped, and reset."""

from __future__ import annotations

import time

from usdsdg.app.app import get_app
from usdsdg.session.timeline import get_timeline
from usdsdg.view.scene import Scene

# The most that is simulated for one picture [s]: a slow machine plays slower, and stays responsive.
LONGEST = 0.1


class Playing:
    """Plays the timeline of the session. What it has started, `restore` undoes for a script that goes on."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._last: float | None = None  # when the timeline last advanced; None while it does not play
        self._started = False  # by the viewer, not by a script

    @property
    def is_playing(self) -> bool:
        """Whether time goes on by itself."""
        return self._last is not None

    def play(self) -> None:
        """Let time go on."""
        self._start()
        self._last = time.monotonic()

    def pause(self) -> None:
        """Hold the time."""
        self._last = None

    def step(self) -> None:
        """Advance by one time code."""
        self.pause()
        self._start()
        self._advance(self._code)

    def reset(self) -> None:
        """Stop, and put everything back to where it was before the first play."""
        self.pause()
        get_timeline().stop()
        self._started = False
        self._scene.change()

    def restore(self) -> None:
        """Leave the timeline to a script as it was: stopped, where the viewer has started it."""
        self.pause()
        if self._started:
            self.reset()

    def follow(self) -> None:
        """Advance by the time that has passed, in whole time codes."""
        if self._last is None:
            return
        now = time.monotonic()
        self._last = max(self._last, now - LONGEST)
        codes = int((now - self._last) / self._code)
        self._last += codes * self._code
        for _ in range(codes):
            self._advance(self._code)

    @property
    def _code(self) -> float:
        return 1.0 / get_timeline().get_time_codes_per_seconds()

    def _start(self) -> None:
        timeline = get_timeline()
        if not timeline.is_playing():
            self._started |= timeline.is_stopped()
            timeline.play()

    def _advance(self, seconds: float) -> None:
        get_app().advance(seconds)
        self._scene.change()
