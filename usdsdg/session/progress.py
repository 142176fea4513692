"""Progress reports of long tasks: bars with rate and ETA of commands on a terminal, plain lines elsewhere."""

import os
import sys
import time
from contextlib import suppress
from typing import Protocol, TextIO

from usdsdg.operating_system import obeys_terminal_sequences
from usdsdg.session.reporters.notebook_progress import NotebookReporter, notebook
from usdsdg.session.reporters.terminal_bars import BarReporter
from usdsdg.session.session import current

FIRST_LINE = 1.0  # seconds that a task takes before anything is said of it
LINE_INTERVAL, LONGEST_INTERVAL = 5.0, 60.0  # seconds between plain lines of one task, more the longer it takes
# The task whose end is always reported; that of others only if they took their time.
FRAMES = "frames captured"
# The same frames in a process that lets others make them.
COUNTED = "frames counted"
# In plain Python 0 or off is silence, as the setting `/usdsdg/progress` is; commands have --quiet.
VARIABLE = "USDSDG_PROGRESS"
_OFF = ("0", "off", "false", "no")


class Reporter(Protocol):
    """Shows progress and single lines."""

    def __call__(self, label: str, done: int, total: int | None) -> None:
        """Show that `done` of `total` steps of a task are done; `total` is None while it is not known."""
        ...

    def say(self, line: str) -> None:
        """Show one line."""
        ...

    def close(self) -> None:
        """Stop showing anything."""
        ...


class SilentReporter:
    """Reports nothing (`--quiet`)."""

    def __call__(self, label: str, done: int, total: int | None) -> None: ...

    def say(self, line: str) -> None: ...

    def close(self) -> None: ...


class LineReporter:
    """Plain lines for logs: one every few seconds of each task that takes long, and its end."""

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream  # None: what `sys.stderr` is at each line, since test runners replace and close it
        self._started: dict[str, float] = {}
        self._last: dict[str, float] = {}

    def __call__(self, label: str, done: int, total: int | None) -> None:
        now = time.monotonic()
        started = self._started.setdefault(label, now)
        if total is not None and done >= total:
            if label == FRAMES or label in self._last or now - started >= FIRST_LINE:
                self.say(f"{label}: {described(done, total, now - started)}")
            self._started.pop(label, None)
            self._last.pop(label, None)
        elif now >= self._next_line(label):
            self._last[label] = now
            self.say(f"{label}: {described(done, total, now - started)}")

    def _next_line(self, label: str) -> float:
        """Return when the next line of a task is due, by `time.monotonic`."""
        started, last = self._started[label], self._last.get(label)
        if last is None:
            return started + FIRST_LINE
        return last + min(max(LINE_INTERVAL, (last - started) / 10), LONGEST_INTERVAL)

    def say(self, line: str) -> None:
        print_safely(f"[usdsdg] {line}", self._stream)

    def close(self) -> None: ...


def print_safely(line: str, stream: TextIO | None = None) -> None:
    """Print a line to `stream`, by default `sys.stderr`; a closed, broken or missing stream is no error.

    That is so in a program without a console, where there is no `sys.stderr`, and where the reader of a pipe has gone.
    """
    stream = stream or sys.stderr
    if stream is not None:
        with suppress(OSError, ValueError):  # a closed file raises a ValueError
            print(line, file=stream, flush=hasattr(stream, "flush"))


def described(done: int, total: int | None, elapsed: float) -> str:
    """Format progress as `12/40, 3.1/s, 9 s left`; `elapsed` in seconds."""
    rate = done / elapsed if elapsed > 0.05 else 0.0
    parts = [f"{done}/{total}" if total is not None else str(done)]
    if rate:
        parts.append(f"{rate:.1f}/s")
        if total is not None and done < total:
            parts.append(f"{(total - done) / rate:.0f} s left")
    return ", ".join(parts)


def reporter_of_library() -> Reporter:
    """Return the reporter of a program that calls usdsdg: lines, unless the environment turns them off.

    There are no bars, which would be drawn over what the program prints, but in notebooks.
    """
    return SilentReporter() if os.environ.get(VARIABLE, "").lower() in _OFF else _shown()


def _shown() -> Reporter:
    return NotebookReporter(described) if notebook() is not None else LineReporter()


def use(reporter: Reporter) -> None:
    """Send the progress of this process to `reporter`."""
    current().reporter.close()
    current().reporter = reporter


def use_of_library(shown: bool) -> None:
    """Show progress and notes as lines, or nothing (the setting `/usdsdg/progress`)."""
    use(_shown() if shown else SilentReporter())


def use_default(quiet: bool = False) -> None:
    """Show progress as bars on a terminal, as lines elsewhere, and not at all if `quiet`."""
    shows_bars = not quiet and sys.stderr.isatty() and obeys_terminal_sequences(sys.stderr)
    use(SilentReporter() if quiet else BarReporter(described, kept=FRAMES) if shows_bars else LineReporter())


def report(label: str, done: int, total: int | None) -> None:
    """Report that `done` of `total` steps of a task are done; `total` is None while it is not known."""
    current().reporter(label, done, total)


def report_frames(done: int, total: int | None) -> None:
    """As `report`, of the frames of the run."""
    report(COUNTED if current().run.counts_only else FRAMES, done, total)


def say(line: str) -> None:
    """Report one line."""
    current().reporter.say(line)


def say_once(line: str) -> None:
    """Report one line, unless it has been reported before."""
    if line not in current().said:
        current().said.add(line)
        say(line)
