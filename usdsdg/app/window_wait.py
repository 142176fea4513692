"""Scripts that only wait for a person to close their window, of which there is none."""

from __future__ import annotations

from usdsdg.errors import warn_once

# Updates with nothing to do after which a script waits for its window: 17 seconds of a GUI. Others that ask whether the
# application runs, such as loops that let an asset load, count updates or seconds, and go on earlier.
IDLE_UPDATES = 1000


class WindowWait:
    """Counts the updates in a row between which a script only asks whether the application runs."""

    def __init__(self) -> None:
        self._last_asked = -1
        self._idle = 0

    def is_over(self, update: int, *, idle: bool, ends: bool) -> bool:
        """Return whether the window counts as closed at the question after `update` updates.

        idle: nothing plays, no task waits, and no frame was captured since the last question.
        ends: a limit was given for what nothing else ends; without, there is a warning alone.
        """
        in_a_row = update == self._last_asked + 1
        self._last_asked = update
        self._idle = self._idle + 1 if idle and in_a_row else 0
        if self._idle < IDLE_UPDATES:
            return False
        if not ends:
            warn_once(
                "the script updates the application until its window is closed, and there is no window: nothing plays, "
                "is captured or waits. Ctrl-C ends it; with `usdsdg run --frames N` it goes on as if the window had "
                "been closed, and frames 0 to N are captured if it has captured none"
            )
        return ends
