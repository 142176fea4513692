"""The files that an earlier run has left in the place of a dataset."""

from __future__ import annotations

import itertools
import json
import os
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from usdsdg.errors import OutputNotWritable, WriterError, counted, warn_once
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stores.whole_file import write_whole
from usdsdg.writers.journal import journal, lines, recipe
from usdsdg.writers.journal.frames import FileFacts
from usdsdg.writers.journal.journal import NAME
from usdsdg.writers.journal.places.place import PARTS, REMOVING, FolderPlace, Place
from usdsdg.writers.journal.spool_hashes import AGGREGATES

_PART = re.compile(r"^\..*\.part$")  # files that a process was writing when it died


def remove_run(place: Place, *, is_told: bool) -> None:
    """Remove the files that the journals in a place list, and what is beside them; `forget_names` ends that.

    is_told: whether a warning names the files; False where the user asked for their removal.
    """
    path = place.path
    journals = _with_lines(_all_journals(path))
    if not journals and not (path / recipe.FILE).exists() and not (path / BESIDE / REMOVING).is_file():
        return
    if is_told and journals:
        warn_once(f"{place.name}: the files of the earlier run there are replaced.")
    _remove_files(place, path / BESIDE, journals)
    place.remove_beside()


def remove_part(place: Place, home: Path) -> None:
    """Remove the files of a part, of which the journal is in a folder `home`."""
    _remove_files(place, home, _with_lines([home / NAME]))
    shutil.rmtree(home / AGGREGATES, ignore_errors=True)


def forget_names(home: Path) -> None:
    """End a removal, once the recipe of the next run is there: until then the folder is no one else's."""
    if (home / REMOVING).is_file():
        (home / REMOVING).unlink()


def end_removal(place: Place, home: Path) -> None:
    """Remove what a removal that was interrupted has left of a run, or a part, so that going on makes all frames."""
    if not is_half_removed(place, home):
        forget_names(home)
    elif _is_whole_run(place, home):
        remove_run(place, is_told=False)
    else:
        remove_part(place, home)


def is_half_removed(place: Place, home: Path) -> bool:
    """Return whether a removal was interrupted that had begun, so that no frame of the run, or part, is left."""
    if not (home / REMOVING).is_file():
        return False
    # Else it had not begun, or there are frames of a later run.
    return not _with_lines(_all_journals(place.path) if _is_whole_run(place, home) else [home / NAME])


def has_frames(place: Place) -> bool:
    """Return whether a journal in a place has lines, of all frames or of a part."""
    return bool(_with_lines(_all_journals(place.path)))


def _is_whole_run(place: Place, home: Path) -> bool:
    return home == place.path / BESIDE


def _all_journals(path: Path) -> list[Path]:
    return [path / BESIDE / NAME, *(path / PARTS).glob(f"*/{NAME}")]


def _with_lines(journals: Iterable[Path]) -> list[Path]:
    return [each for each in journals if each.is_file() and each.stat().st_size]


def _remove_files(place: Place, home: Path, journals: list[Path]) -> None:
    """Remove the files that journals list, and empty these.

    No journal may list files that are gone, as where this is interrupted: `--resume` would not make them again. So
    the names are kept in another file, with which the next run goes on.
    """
    kept = home / REMOVING
    names = itertools.chain(_kept_names(kept), _listed_names(place, journals))
    if journals and not _keep_names(kept, names):
        place.remove(_listed_names(place, journals))
        _empty(place, journals)
        return
    _empty(place, journals)
    place.remove(_kept_names(kept))


def _keep_names(kept: Path, names: Iterable[str]) -> bool:
    """Write the names to a file; False where the disk is full, of which the removal itself frees some."""
    try:
        write_whole(kept, (f"{json.dumps(name)}\n".encode() for name in names), durable=True)
    except OutputNotWritable:
        return False
    return True


def _listed_names(place: Place, journals: list[Path]) -> Iterator[str]:
    own = {each.relative_to(place.path).as_posix() for each in journals}
    for each in journals:
        with suppress(WriterError):  # damaged: what it lists up to there
            for line in journal.lines(each):
                yield from (
                    name for name in (*line.get(lines.FILES, ()), *line.get(lines.SHARED, ())) if name not in own
                )


def _kept_names(kept: Path) -> Iterator[str]:
    """Yield the names in a file that a removal has left; none where there is no such file, or a damaged one."""
    if not kept.is_file():
        return
    with suppress(ValueError), open(kept, encoding="utf-8") as file:
        for line in file:
            if isinstance(name := json.loads(line), str) and "\0" not in name:
                yield name


def _empty(place: Place, journals: list[Path]) -> None:
    if not journals:
        return
    place.push()
    for each in journals:
        os.truncate(each, 0)  # which are locked
    place.push()


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
