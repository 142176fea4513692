"""Joining the parts of a dataset: its journal, its spools, and the files that are made of them."""

from __future__ import annotations

import shutil
from pathlib import Path

from usdsdg.errors import DatasetError
from usdsdg.session.session import current
from usdsdg.writers.aggregates import finish_run
from usdsdg.writers.journal import merge, recipe
from usdsdg.writers.journal.earlier_run import Mode
from usdsdg.writers.journal.folders import DatasetFolder
from usdsdg.writers.journal.places.place import JOINED, PARTS, FolderPlace, Place
from usdsdg.writers.journal.recipe import Recipe
from usdsdg.writers.journal.run import Run


def forget_parts(place: Place) -> None:
    """Remove what is left of parts beside a whole dataset: those that have been joined, or were made once more."""
    for name in (PARTS, JOINED):
        shutil.rmtree(place.path / name, ignore_errors=True)
    place.push()


def join_parts(place: Place) -> int:
    """Make one dataset of the parts in a place, and return its number of frames.

    Raises:
        DatasetError: there are none, or they are not complete.
        DatasetInTheWay: a process is writing there.
    """
    place.pull()
    values = recipe.read(place.path, remedy=recipe.PUT_BACK)
    if values is None:
        raise DatasetError(f"{place.name} has no parts to be joined: there is no {recipe.FILE}")
    wanted = Recipe.of_values(values, Path(place.name))
    # With the lock of the whole dataset, which no part may hold meanwhile.
    claimed = DatasetFolder(place, wanted, Mode.RESUME, None, before=lambda: merge.join(place), with_parts=True)
    current().run = run = Run()
    run.begin(wanted, Mode.RESUME, None)
    run.adopt(claimed)
    finish_run(complete=True)
    if isinstance(place, FolderPlace):
        current().written_folders.setdefault(place.name)
    return claimed.journal.count
