"""Progress in Jupyter: one output for each cell, with a bar, the rate and the time left of each task."""

from __future__ import annotations

import html
import sys
import time
from dataclasses import dataclass, field
from typing import Any

UPDATE_SECONDS = 0.2
# Seconds that a task takes before it is shown.
FIRST = 1.0
_BAR = "width:220px;vertical-align:middle"


@dataclass
class _Task:
    started: float
    done: int = 0
    total: int | None = None
    ended: float | None = None
    is_shown: bool = False


@dataclass
class _Cell:
    """What is reported while one cell runs."""

    number: int
    tasks: dict[str, _Task] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)
    output: Any = None  # the handle of the display
    updated: float = 0.0


def notebook() -> Any | None:
    """Return the shell of the notebook that runs this, or None elsewhere, as in IPython on a terminal."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    return shell if getattr(shell, "kernel", None) is not None else None


class NotebookReporter:
    """Implements `progress.Reporter` for a notebook. Tasks that end within a second are not shown."""

    def __init__(self, described: Any) -> None:
        """described: formats steps done, their total, and seconds."""
        self._described, self._cell = described, _Cell(-1)

    def __call__(self, label: str, done: int, total: int | None) -> None:
        now, cell = time.monotonic(), self._current()
        task = cell.tasks.setdefault(label, _Task(now))
        if task.ended is not None and done < task.done:
            task = cell.tasks[label] = _Task(now, is_shown=task.is_shown)  # it begins again
        task.done, task.total = done, total
        is_over = total is not None and done >= total
        task.ended = now if is_over else None
        task.is_shown = task.is_shown or now - task.started >= FIRST
        if task.is_shown and (is_over or now - cell.updated >= UPDATE_SECONDS):
            self._show(cell, now)

    def say(self, line: str) -> None:
        cell = self._current()
        cell.lines.append(line)
        self._show(cell, time.monotonic())

    def close(self) -> None:
        self._cell = _Cell(-1)

    def _current(self) -> _Cell:
        """Return what is reported in the cell that runs; another cell begins anew."""
        shell = notebook()
        number = shell.execution_count if shell is not None else -1
        if self._cell.number != number:
            self._cell = _Cell(number)
        return self._cell

    def _show(self, cell: _Cell, now: float) -> None:
        from IPython.display import HTML, display  # pyright: ignore[reportMissingImports]

        cell.updated = now
        shown = HTML(self._html(cell, now))
        if cell.output is None:
            cell.output = display(shown, display_id=True)
        else:
            cell.output.update(shown)

    def _html(self, cell: _Cell, now: float) -> str:
        rows = []
        for label, task in cell.tasks.items():
            if task.is_shown:
                value = f'value="{task.done}" max="{task.total}"' if task.total else ""
                about = self._described(task.done, task.total, (task.ended or now) - task.started)
                rows.append(f'<progress style="{_BAR}" {value}></progress> {html.escape(label)}: {html.escape(about)}')
        rows += [html.escape(line) for line in cell.lines]
        return "".join(f"<div>{row}</div>" for row in rows)
