"""Programs of examples, in cells: `# %% name, name` begins the example of these names."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

HEAD = re.compile(r"^# %% (.+)$", re.MULTILINE)
SETTING = "setting"


@dataclass(frozen=True)
class Cell:
    """An example.

    Attributes:
        names: What it shows.
        code: Its lines.
    """

    names: tuple[str, ...]
    code: str


def cells(program: Path) -> list[Cell]:
    """Return the cells of a program in order; the first, `setting`, has what the others need."""
    parts = HEAD.split(program.read_text(encoding="utf-8"))[1:]
    return [
        Cell(tuple(name.strip() for name in names.split(",")), code.strip() + "\n")
        for names, code in zip(parts[::2], parts[1::2], strict=True)
    ]
