"""Progress on a terminal: a bar for each task, below all lines that are printed in the meantime."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TextIO

REDRAW_SECONDS = 0.1
# Columns of a line; a bar has what is left, within bounds.
LABEL, ABOUT, SHORTEST_BAR, LONGEST_BAR = 25, 28, 4, 30
BLOCKS, ASCII = "█░", "#-"
# What terminals do: go up some lines; clear the rest of a line, or of the screen.
_UP, _CLEAR_LINE, _CLEAR_BELOW = "\x1b[{}A", "\x1b[K", "\x1b[J"


@dataclass
class _Task:
    started: float
    done: int = 0
    total: int | None = None
    drawn: float = -math.inf


class BarReporter:
    """Implements `progress.Reporter` for a terminal. Bars of tasks that have ended stay, above the others; tasks that
    ended at once have none, since each frame may have some.

    While there are bars, what is printed to stdout and stderr, where these are terminals, appears above them, line by
    line.
    """

    def __init__(self, described: Callable[[int, int | None, float], str], *, kept: str) -> None:
        """described: formats steps done, their total, and seconds. kept: a task whose bar stays in any case."""
        self._described, self._kept, self._stream = described, kept, sys.stderr
        self._full, self._empty = BLOCKS if _has(self._stream, BLOCKS) else ASCII
        # Of threads that report; a handler of a signal may report within a report.
        self._lock = threading.RLock()
        self._process = os.getpid()
        self._tasks: dict[str, _Task] = {}
        self._lines = 0  # of bars that are on the terminal; the cursor is at the end of the last

    def __call__(self, label: str, done: int, total: int | None) -> None:
        if not self._is_here():
            return
        with self._lock:
            _print_above(self)
            now = time.monotonic()
            task = self._tasks.setdefault(label, _Task(now))
            task.done, task.total = done, total
            if total is not None and done >= total:
                del self._tasks[label]
                self._end(label, task, now)
            elif now - task.drawn >= REDRAW_SECONDS:
                task.drawn = now
                self._draw()

    def say(self, line: str) -> None:
        self.print_above(self._stream, f"{line}\n")

    def close(self) -> None:
        if not self._is_here():
            return
        with self._lock:
            self._draw()
            if self._lines:
                self._write("\n")
            self._tasks.clear()
            self._lines = 0
            _print_directly(self)

    @property
    def are_shown(self) -> bool:
        """Whether there are bars of this process on the terminal."""
        return bool(self._tasks) and self._is_here()

    def print_above(self, stream: TextIO, text: str) -> None:
        """Print whole lines to a stream of the terminal, above the bars."""
        if not self._is_here() or not (self._tasks or self._lines):
            stream.write(text)
            stream.flush()
            return
        with self._lock:
            begin, self._lines = self._begin(), 0
            self._write(begin + _CLEAR_BELOW)
            try:
                stream.write(text)
                stream.flush()
            finally:
                self._draw()

    def _end(self, label: str, task: _Task, now: float) -> None:
        if label == self._kept or now - task.started >= REDRAW_SECONDS:
            with suppress(OSError):
                self.print_above(self._stream, self._bar(label, task) + "\n")
        else:
            self._draw()

    def _draw(self) -> None:
        columns, rows = self._size()
        bars = [self._bar(label, task)[: columns - 1] + _CLEAR_LINE for label, task in self._tasks.items()]
        bars = bars[1 - rows :]
        if bars or self._lines:
            begin, self._lines = self._begin(), len(bars)
            self._write(begin + "\n".join(bars) + _CLEAR_BELOW)

    def _begin(self) -> str:
        """Return what brings the cursor to the beginning of the first bar."""
        return "\r" + (_UP.format(self._lines - 1) if self._lines > 1 else "")

    def _bar(self, label: str, task: _Task) -> str:
        length, bar = min(max(self._size()[0] - LABEL - ABOUT - 3, SHORTEST_BAR), LONGEST_BAR), ""
        if task.total is not None:
            full = length * min(task.done, task.total) // max(task.total, 1)
            bar = self._full * full + self._empty * (length - full)
        about = self._described(task.done, task.total, time.monotonic() - task.started)
        return f"{label:{LABEL}} {bar:{length}} {about}"

    def _size(self) -> tuple[int, int]:
        try:
            columns, rows = os.get_terminal_size(self._stream.fileno())
        except (OSError, ValueError):
            columns, rows = 0, 0
        return columns or 80, rows or 24  # some terminals say 0

    def _write(self, text: str) -> None:
        with suppress(OSError):  # of a terminal that hung up
            self._stream.write(text)
            self._stream.flush()

    def _is_here(self) -> bool:
        """Whether this is the process whose bars these are, and not a fork of it, in which the lock may be held."""
        return os.getpid() == self._process


class LinesAbove:
    """Stands for a stream of the terminal: its lines appear above the bars, each when it has ended."""

    def __init__(self, stream: TextIO, bars: BarReporter) -> None:
        self.stream, self.bars = stream, bars
        self._begun = ""

    def write(self, text: str) -> int:
        if not self.bars.are_shown:
            self.end()
            return self.stream.write(text)
        ended, newline, self._begun = (self._begun + text).rpartition("\n")
        if newline:
            self.bars.print_above(self.stream, ended + newline)
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        for line in lines:
            self.write(line)

    def end(self) -> None:
        """Print the line that has not ended."""
        begun, self._begun = self._begun, ""
        self.stream.write(begun)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


def _print_above(bars: BarReporter) -> None:
    """Let what is printed to stdout and stderr appear above the bars, where these are terminals."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if not isinstance(stream, LinesAbove) and _is_terminal(stream):
            setattr(sys, name, LinesAbove(stream, bars))


def _print_directly(bars: BarReporter) -> None:
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if isinstance(stream, LinesAbove) and stream.bars is bars:
            with suppress(OSError):
                stream.end()
            setattr(sys, name, stream.stream)


def _is_terminal(stream: Any) -> bool:
    """Whether a stream is a terminal; a script may have closed it, or have put there what only has `write`."""
    try:
        return stream.isatty()
    except (AttributeError, ValueError):
        return False


def _has(stream: TextIO, characters: str) -> bool:
    """Whether the encoding of a stream has characters."""
    try:
        characters.encode(stream.encoding or "ascii")
    except UnicodeEncodeError:
        return False
    return True
