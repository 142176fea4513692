"""The files that an earlier run has left in the place of a dataset."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from usdsdg.errors import WriterError, counted, warn_once
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.writers.journal import journal, lines, recipe
from usdsdg.writers.journal.frames import FileFacts
from usdsdg.writers.journal.journal import NAME
from usdsdg.writers.journal.place import PARTS, FolderPlace, Place
from usdsdg.writers.journal.spool_hashes import AGGREGATES

_PART = re.compile(r"^\..*\.part$")  # files that a process was writing when it died


def remove_run(place: Place, *, is_told: bool) -> None:
    """Remove the files that the journals in a place list, and what is beside them.

    is_told: whether a warning names the files; False where the user asked for their removal.
    """
    path = place.path
    if not (path / recipe.FILE).exists():
        return
    journals = [path / BESIDE / NAME, *(path / PARTS).glob(f"*/{NAME}")]
    if is_told and any(each.is_file() and each.stat().st_size for each in journals):
        warn_once(f"{place.name}: the files of the earlier run there are replaced.")
    for each in journals:
        remove_files(place, each)
    place.remove_beside()


def remove_files(place: Place, listed: Path) -> None:
    """Remove the files that a journal lists."""
    if not listed.is_file():
        return
    own = listed.relative_to(place.path).as_posix()
    with suppress(WriterError):  # damaged: what it lists up to there is removed
        place.remove(
            name
            for line in journal.lines(listed)
            for name in (*line.get(lines.FILES, ()), *line.get(lines.SHARED, ()))
            if name != own
        )
    os.truncate(listed, 0)


def warn_of_lost(place: Place, listed: Path) -> None:
    """Warn of files of frames that are missing or of another size, since these frames are not made again."""
    if not isinstance(place, FolderPlace):
        return
    lost = [
        name
        for line in journal.lines(listed)
        for name, (size, _) in line.get(lines.FILES, {}).items()
        if not _has_size(place.path / name, size)
    ]
    if lost:
        warn_once(
            f"{place.name}: missing or changed: {_first_of(lost)} of frames that were made before, which going on does "
            "not make again. usdsdg verify lists them, and usdsdg repair makes them again once the run has ended."
        )


def warn_of_lost_about_all(place: Place, shared: Mapping[str, FileFacts]) -> None:
    """Warn of files about all frames that are missing or of another size once a run that went on is whole."""
    if not isinstance(place, FolderPlace):
        return
    spools = f"{BESIDE}/{AGGREGATES}/"  # which have facts of their own
    lost = [
        name
        for name, (size, _) in shared.items()
        if not name.startswith(spools) and not _has_size(place.path / name, size)
    ]
    if lost:
        warn_once(
            f"{place.name}: missing or changed: {_first_of(lost)} about all frames, which going on has not made again. "
            "usdsdg repair makes them again."
        )


def _first_of(names: Sequence[str]) -> str:
    return f"{names[0]} and {counted(len(names) - 1, 'more file')}" if len(names) > 1 else names[0]


def _has_size(path: Path, size: int) -> bool:
    try:
        return path.stat().st_size == size
    except OSError:
        return False


def remove_unfinished(path: Path) -> None:
    """Remove the files that a process was writing when it died, apart from folders with datasets of their own."""
    for folder, below, names in os.walk(path):
        # Other processes may be writing to those.
        below[:] = [name for name in below if not Path(folder, name, BESIDE).is_dir()]
        for name in filter(_PART.match, names):
            with suppress(FileNotFoundError):
                os.unlink(os.path.join(folder, name))
