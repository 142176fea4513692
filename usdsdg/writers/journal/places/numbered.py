"""Places of writers of which each wants a new one: the wanted name, and it with _0001 and so on appended.

The recipe there says which of the writers of its run it is of, so that a run that goes on, and each process of several
that make parts, gives each writer its own.
"""

from __future__ import annotations

import glob
import itertools
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from usdsdg.writers.journal import recipe
from usdsdg.writers.journal.places.place import FolderPlace

if TYPE_CHECKING:
    from usdsdg.writers.journal.run import Run


class NumberedPlaces:
    """Which of the writers that have asked for a place of one name has which place."""

    def __init__(self) -> None:
        self._asked: Counter[str] = Counter()
        self._given: dict[str, int] = {}

    def ask(self, wanted: str) -> int:
        """Count a writer that wants a place; return how many have asked for one of that name before."""
        self._asked[wanted] += 1
        return self._asked[wanted] - 1

    def give(self, place: str, copy: int) -> None:
        """Note the place of the writer for which `ask` has returned `copy`."""
        self._given[place] = copy

    def copy_of(self, place: str) -> int:
        """Return what `give` has noted of a place; 0 for others."""
        return self._given.get(place, 0)

    def has_given(self, place: str) -> bool:
        """Return whether a writer of this process has a place."""
        return place in self._given


def next_writers_folder(run: Run, wanted: Path) -> Path:
    """Return the folder of the next writer that wants one of its own.

    It is the latest one with this run or a part of it that this writer had, where frames are added to such; else a new
    one.
    """
    wanted = wanted.absolute()
    copy = run.numbered.ask(str(wanted))
    # Before others are read: a process of another part that begins meanwhile is found there then.
    new = next(each for each in _candidates(wanted) if _is_free(run, each))
    found = None
    if run.may_go_on:
        there = sorted(wanted.parent.glob(f"{glob.escape(wanted.name)}_[0-9][0-9][0-9][0-9]"), reverse=True)
        found = run.first_of_this(map(FolderPlace, [*there, wanted]), copy)
    folder = found.path if found is not None else new
    run.numbered.give(str(folder), copy)
    return folder


def _candidates(wanted: Path) -> Iterator[Path]:
    numbered = (wanted.with_name(f"{wanted.name}_{number:04d}") for number in itertools.count(1))
    return itertools.chain([wanted], numbered)


def _is_free(run: Run, folder: Path) -> bool:
    """Whether a writer can have a folder as a new one: also one that a process of another part has just made."""
    if not folder.exists():
        return True
    if not run.may_go_on or run.numbered.has_given(str(folder)) or not folder.is_dir():
        return False
    return not (folder / recipe.FILE).exists() and not FolderPlace(folder).has_files()
