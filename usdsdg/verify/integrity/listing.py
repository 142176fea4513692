"""What the recipe and the journals of a dataset list, read as far as they can be read."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from usdsdg.datasets.attempt import UNREADABLE, attempt
from usdsdg.datasets.faults import Fault
from usdsdg.errors import counted
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.writers.journal import lines, recipe
from usdsdg.writers.journal.frames import FileFacts
from usdsdg.writers.journal.journal import NAME
from usdsdg.writers.journal.merge import listed, missing_shards, of_missing_shards, parts_of
from usdsdg.writers.journal.places.place import PARTS
from usdsdg.writers.journal.spool_hashes import AGGREGATES

JOURNAL = f"{BESIDE}/{NAME}"
SPOOLS = f"{BESIDE}/{AGGREGATES}/"
_NONE_WHOLE = "the run is unfinished, and no frame is whole (--resume)"


@dataclass(frozen=True)
class ListedFile:
    """A file as a journal lists it."""

    size: int  # bytes
    sha256: str
    frame: str  # its number, or "all" for a file about all frames
    has_grown: bool = False  # perhaps, since: only how it began is listed


@dataclass
class Listing:
    """The files of a dataset, by their paths below its folder, and what is wrong with the journals themselves."""

    files: dict[str, ListedFile] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    failed: list[Fault] = field(default_factory=list)  # those of `faults` that are frames at which a writer failed
    frames: set[int] = field(default_factory=set)  # their numbers, also of those without files
    is_complete: bool = False
    is_damaged: bool = False  # so that files may be unlisted through no fault of theirs
    is_cut_off: bool = False  # as by the death of a process: of the journal no line is damaged but the last one


def read_listing(folder: Path) -> Listing | None:
    """Return what is listed in a folder; None where no run has kept a journal."""
    parts, own = parts_of(folder), folder / JOURNAL
    if not (_is_there(own) or parts or _is_there(folder / recipe.FILE)):
        return None
    listing = Listing()
    recipe_hash = _check_recipe(folder, listing)
    is_empty = os.path.isfile(own) and not own.stat().st_size
    if _is_there(own) and not is_empty:
        _read_journal(own, JOURNAL, listing, recipe_hash)
    elif not parts:
        listing.is_damaged = True
        said = f"is empty: {_NONE_WHOLE}" if is_empty else "is missing"
        listing.faults.append(Fault(JOURNAL, "all", said))
        listing.is_cut_off = is_empty
    if parts:
        _read_parts(folder, parts, listing)
    return listing


def _check_recipe(folder: Path, listing: Listing) -> str | None:
    """Return the SHA-256 of the recipe; None if there is none."""
    file = _opened(folder / recipe.FILE, recipe.FILE, listing)
    if file is None:
        return None
    with file:
        data = file.read()
    try:
        values = json.loads(data)
    except (ValueError, RecursionError) as error:
        values, said = None, str(error)
    else:
        said = "it is no table"
    if not isinstance(values, dict):
        listing.faults.append(Fault(recipe.FILE, "all", f"is no recipe: {said}"))
    return hashlib.sha256(data).hexdigest()


def _read_journal(path: Path, name: str, listing: Listing, recipe_hash: str | None) -> None:
    """Add the files of a journal; recipe_hash: of the dataset's recipe, where it has one."""
    file = _opened(path, name, listing)
    if file is None:
        listing.is_damaged = True
        return
    with file:
        _read_lines(file, name, listing, recipe_hash)


def _read_lines(file: IO[bytes], name: str, listing: Listing, recipe_hash: str | None) -> None:
    digest, numbers, closing, closing_data = hashlib.sha256(), [], None, b""
    spools: dict[str, FileFacts] = {}
    damaged: list[int] = []
    place = 0
    for place, data in enumerate(file, 1):
        line = lines.parsed(data)
        spools.update((line or {}).get(lines.SPOOLS, {}))
        if closing is not None:  # of a run that went on
            digest.update(closing_data)
            _add(listing, closing[lines.SHARED], "all")
            closing = None
        if line is None:
            damaged.append(place)
            is_cut = not data.endswith(b"\n")
            listing.faults.append(Fault(name, "?", f"line {place} is {'cut off' if is_cut else 'damaged'}"))
        elif lines.FRAMES in line:
            closing, closing_data = line, data
        else:
            digest.update(data)
            if lines.FRAME in line:
                numbers.append(line[lines.FRAME])
                _add(listing, line[lines.FILES], str(line[lines.FRAME]))
                if why := line.get(lines.FAILED):
                    said = f"a writer did not get to its end, so files may be missing: {why}"
                    listing.failed.append(Fault(name, str(line[lines.FRAME]), said))
                    listing.faults.append(listing.failed[-1])
            _add(listing, line.get(lines.SHARED, {}), "all")
    listing.is_damaged |= bool(damaged)
    listing.is_cut_off = damaged == [place]  # which a run that goes on drops
    listing.frames.update(numbers)
    _check_order(name, numbers, listing)
    if closing is None or not closing.get(lines.COMPLETE):
        whole = counted(len(numbers), "frame is", "frames are")
        listing.faults.append(Fault(name, "all", f"the run is unfinished: {whole} whole (--resume)"))
        _add(listing, closing[lines.SHARED] if closing else {}, "all")
        _list_beginnings(listing, spools)
        return
    _add(listing, closing[lines.SHARED], "all")
    listing.is_complete = True
    if closing[lines.FRAMES] != len(numbers):
        listing.is_damaged = True
        listing.faults.append(
            Fault(name, "all", "frames are missing or doubled", str(closing[lines.FRAMES]), str(len(numbers)))
        )
    if closing.get(lines.LINES) != digest.hexdigest():
        listing.faults.append(Fault(name, "all", "its lines are not those that the run wrote"))
    if recipe_hash is not None and closing.get(lines.RECIPE) not in (None, recipe_hash):
        listing.faults.append(Fault(recipe.FILE, "all", "was changed after the run"))


def _list_beginnings(listing: Listing, spools: dict[str, FileFacts]) -> None:
    """List how the spools of an unfinished run began, by their paths below their folder; it may have gone on since."""
    for name in [each for each in listing.files if each.startswith(SPOOLS)]:
        told = spools.get(name.removeprefix(SPOOLS))
        if told is None:
            del listing.files[name]
        else:
            listing.files[name] = ListedFile(*told, "all", has_grown=True)


def _read_parts(folder: Path, parts: list[Path], listing: Listing) -> None:
    listing.is_complete = False
    for part in parts:
        of_part = Listing()
        _read_journal(part / NAME, (part / NAME).relative_to(folder).as_posix(), of_part, None)
        listing.files |= of_part.files
        listing.frames |= of_part.frames
        listing.faults += of_part.faults
        listing.failed += of_part.failed
        listing.is_damaged |= of_part.is_damaged
    names = [part.name for part in parts]
    unjoined = counted(len(parts), "part is", "parts are")
    listing.faults.append(Fault(PARTS, "all", f"{unjoined} not joined (usdsdg merge): {listed(names)}"))
    if missing := missing_shards(names):
        listing.faults.append(Fault(PARTS, "all", of_missing_shards(missing)))


def _is_there(path: Path) -> bool:
    """Return whether anything is in a place, or hidden from this user."""
    try:
        os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError:
        return True
    return True


def _opened(path: Path, name: str, listing: Listing) -> IO[bytes] | None:
    """Open a file; None, and a fault, where it cannot be read, as a pipe, which may never end."""
    if os.path.exists(path) and not os.path.isfile(path):
        listing.faults.append(Fault(name, "all", "is no file"))
        return None
    return attempt(listing.faults, name, "all", UNREADABLE, lambda: path.open("rb"))


def _add(listing: Listing, files: dict[str, FileFacts], frame: str) -> None:
    for name, (size, sha256) in files.items():
        listing.files[name] = ListedFile(size, sha256, frame)


def _check_order(name: str, numbers: list[int], listing: Listing) -> None:
    last = -1
    for number in numbers:
        if number <= last:
            listing.faults.append(Fault(name, str(number), f"comes after frame {last}"))
        last = max(last, number)
