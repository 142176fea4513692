"""Comparison of the files on disk with those that the journal of a dataset lists."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path, PurePosixPath

from usdsdg.datasets.faults import Fault
from usdsdg.errors import counted
from usdsdg.parallel import available_threads
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stores.whole_file import facts_of
from usdsdg.verify.integrity.listing import SPOOLS, ListedFile, Listing, read_listing

Progress = Callable[[str, int, int | None], None]
PAGE = "inspect.html"  # which `usdsdg inspect` puts beside the data
# Beside the data: what has no line in the journal.
_OWN = re.compile(
    rf"{re.escape(BESIDE)}/(recipe\.json|journal\.jsonl|.*\.lock|parts/.*|joined/.*|aggregates/samples/.*)"
)
_OF_SYSTEMS = re.compile(r"\.DS_Store|Thumbs\.db|desktop\.ini|\.nfs[0-9a-f]+|\.directory")


@dataclass
class Integrity:
    """The result of the comparison."""

    listed: frozenset[str]  # paths below the folder
    faults: list[Fault] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    compared: int = 0  # files, by hash
    is_finished: bool = True  # the run, or all parts of it, which are joined


def check(folder: Path, progress: Progress | None = None) -> Integrity | None:
    """Compare the files of a dataset with its journal; None where no run has kept one.

    Finds files that are missing, changed or foreign, and journals and recipes that are damaged or unfinished.
    """
    listing = read_listing(folder)
    if listing is None:
        return None
    result = Integrity(frozenset(listing.files), list(listing.faults), is_finished=listing.is_complete)
    by_hash = {(each.size, each.sha256): name for name, each in listing.files.items()}
    with ThreadPoolExecutor(available_threads()) as pool:
        for fault in pool.map(partial(_compared, folder, by_hash=by_hash), listing.files, listing.files.values()):
            result.compared += 1
            if fault is not None:
                result.faults.append(fault)
            if progress is not None:
                progress("files verified", result.compared, len(listing.files))
    _check_unlisted(folder, listing, by_hash, result)
    return result


def _compared(folder: Path, name: str, listed: ListedFile, by_hash: dict[tuple[int, str], str]) -> Fault | None:
    """Return what is wrong with a listed file."""
    path = folder / name
    if ".." in PurePosixPath(name).parts or PurePosixPath(name).is_absolute():
        return Fault(name, listed.frame, "is outside of the folder of the dataset")
    try:
        status = os.lstat(path)
        if not stat.S_ISREG(status.st_mode):
            return Fault(name, listed.frame, "is no file", "a file", _kind_of(status.st_mode))
        if status.st_size < listed.size or (status.st_size > listed.size and not listed.has_grown):
            what = "its size is not the one in the journal" + _same_as(by_hash, facts_of(path), name)
            return Fault(name, listed.frame, what, counted(listed.size, "byte"), f"{status.st_size}")
        facts = facts_of(path, listed.size if listed.has_grown else None)
    except OSError as error:
        is_missing = isinstance(error, (FileNotFoundError, NotADirectoryError))
        return Fault(name, listed.frame, "is missing" if is_missing else f"cannot be read: {error.strerror}")
    if facts[1] != listed.sha256:
        what = "was changed" + _same_as(by_hash, facts, name)
        return Fault(name, listed.frame, what, f"SHA-256 {listed.sha256[:12]}", facts[1][:12])
    return None


def _same_as(by_hash: dict[tuple[int, str], str], facts: tuple[int, str], name: str) -> str:
    other = by_hash.get(facts)
    return f": it has the content of {other}" if other not in (None, name) and facts[0] else ""


def _check_unlisted(folder: Path, listing: Listing, by_hash: dict[tuple[int, str], str], result: Integrity) -> None:
    """Add the files that no line of a journal lists."""
    unlisted = [each for each in _files(folder) if each not in listing.files and not _OWN.fullmatch(each)]
    if not listing.is_complete:
        unlisted = [each for each in unlisted if not each.startswith(SPOOLS)]
    if unlisted and (listing.is_damaged or not listing.is_complete):
        result.notes.append(
            f"{counted(len(unlisted), 'file is', 'files are')} in no line of the journal, such as {unlisted[0]}; "
            "frames that were in hand when the run ended leave such files"
        )
        return
    for name in unlisted:
        path = folder / name
        if not stat.S_ISREG(os.lstat(path).st_mode):
            result.faults.append(Fault(name, "?", f"no run wrote it: {_kind_of(os.lstat(path).st_mode)}"))
            continue
        with suppress(OSError):  # such as of another user: nothing is known of it, but that it is there
            copied = by_hash.get(facts_of(path)) if path.stat().st_size else None
            if copied:
                result.faults.append(Fault(name, "?", f"is a copy of {copied}"))
                continue
        result.faults.append(Fault(name, "?", "no run wrote it"))


def _files(folder: Path) -> Iterator[str]:
    """Yield the paths of all files below a folder, hidden ones too, without those of datasets inside of it."""
    for where, folders, names in os.walk(folder):
        inside = Path(where)
        if inside != folder and BESIDE in folders:
            folders.clear()
            continue
        links = [each for each in folders if (inside / each).is_symlink()]
        folders.sort()
        for name in sorted([*names, *links]):
            if not _OF_SYSTEMS.fullmatch(name) and not (inside == folder and name == PAGE):
                yield (inside / name).relative_to(folder).as_posix()


def _kind_of(mode: int) -> str:
    """Return what is in the place of a file, in words."""
    kinds = {
        stat.S_IFLNK: "a link", stat.S_IFDIR: "a folder", stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket",
        stat.S_IFCHR: "a device", stat.S_IFBLK: "a device",
    }  # fmt: skip
    return kinds.get(stat.S_IFMT(mode), "something else")
