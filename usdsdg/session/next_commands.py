"""The commands that follow a run: those that look at the datasets it has written."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Iterable
from pathlib import Path

from usdsdg.session.session import current

_COMMANDS = {"inspect": "its images and labels on one page", "verify": "checks its files against each other"}
_OF_PARTS = {"merge": "joins the parts, when all are made"}
_FORMATS = "usdsdg.writers.formats."  # package of the writers whose files can be read back


def written_datasets() -> list[Path]:
    """Return the folders that this process has written datasets to and that are still there, the outermost ones."""
    return _tops([path for path in map(Path, current().written_folders) if path.is_dir()])


def next_commands(folders: Iterable[Path]) -> list[str]:
    """Return a line for each command that looks at these datasets: `usdsdg inspect cubes   (...)`."""
    commands = _OF_PARTS if current().run.portion is not None else _COMMANDS
    pairs = [
        (f"usdsdg {command} {_quoted(_shortest(folder))}", what)
        for folder in folders
        for command, what in commands.items()
        if command != "inspect" or _is_readable(folder)
    ]
    width = max((len(command) for command, _ in pairs), default=0)
    return [f"{'next: ' if number == 0 else '      '}{c:{width}}   ({what})" for number, (c, what) in enumerate(pairs)]


def _quoted(name: str) -> str:
    """Return a name as shells read it; one with line ends, or with bytes that are no UTF-8, as bash and zsh do."""
    if name.isprintable():
        return shlex.quote(name)
    plain = set(range(32, 127)) - set(b"\\'")
    return "$'" + "".join(chr(byte) if byte in plain else f"\\{byte:03o}" for byte in os.fsencode(name)) + "'"


def _is_readable(folder: Path) -> bool:
    """Return whether any writer of files in a folder has a format that is known here, or it is not known who has."""
    kinds = [
        kind
        for place, own in current().writers_kinds.items()
        if Path(place).is_relative_to(folder) or folder.is_relative_to(place)
        for kind in own
    ]
    return not kinds or any(base.__module__.startswith(_FORMATS) for kind in kinds for base in kind.__mro__)


def _shortest(folder: Path) -> str:
    """Return how a folder is called from where the program was started: what is in it by its name there."""
    started_in = Path(sys.modules["usdsdg"]._STARTED_IN)  # also where a script has left it
    try:
        inside = folder.resolve().relative_to(started_in.resolve())
    except (OSError, ValueError):
        return str(folder)
    return f".{os.sep}{inside}" if str(inside).startswith("-") else str(inside)


def _tops(folders: list[Path]) -> list[Path]:
    """Return folders without those inside of others; instead of all folders in one, that one."""
    outer = [each for each in folders if not any(other in each.parents for other in folders)]
    parents = {each.parent for each in outer}
    if len(outer) > 1 and len(parents) == 1:
        (parent,) = parents
        if {each for each in parent.iterdir() if each.is_dir()} == set(outer):
            return [parent]
    return outer
