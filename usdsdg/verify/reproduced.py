"""Comparison of a dataset with frames of it that were made again."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from usdsdg.datasets.faults import Fault
from usdsdg.record import STAGES
from usdsdg.stores.whole_file import facts_of
from usdsdg.verify.integrity.listing import ListedFile, read_listing
from usdsdg.verify.recorded_assets import hashes_of
from usdsdg.verify.tolerance import Unknown, difference
from usdsdg.writers.formats.rerun import rrd_content
from usdsdg.writers.journal import journal, recipe
from usdsdg.writers.journal.facts import ASSETS
from usdsdg.writers.journal.merge import parts_of
from usdsdg.writers.journal.portion import Portion


@dataclass
class Comparison:
    """The result of the comparison."""

    equal: int = 0  # files, byte for byte; of recordings what they hold
    close: int = 0  # within the tolerance
    faults: list[Fault] = field(default_factory=list)
    unknown: list[str] = field(default_factory=list)  # that differ, and of which no tolerance is known


def counterpart(folder: Path, made: list[Path]) -> Path | None:
    """Return which of several folders that were made again has the files of `folder`; None: none of them."""
    listing = read_listing(folder)
    wanted = listing.files if listing is not None else {}

    def shared(other: Path) -> tuple[int, int]:
        found = read_listing(other)
        files = found.files if found is not None else {}
        names = wanted.keys() & files.keys()
        return sum(wanted[name].sha256 == files[name].sha256 for name in names), len(names)

    best = max(made, key=shared, default=None)
    return best if best is not None and shared(best)[1] else None


def compare(folder: Path, made: Path, portion: Portion | None, *, exact: bool) -> Comparison:
    """Compare the files of a dataset with those of frames that were made again.

    portion: those frames; None: all, and then files about all frames are compared, too.
    exact: whether a file with other bytes is a fault; False: one beyond the tolerance is.
    """
    wanted, again = files_of(folder, portion), files_of(made, portion)
    result = Comparison()
    for name in sorted(wanted.keys() | again.keys()):
        is_missing = name not in again or name not in wanted
        if is_missing and not exact and name.startswith(f"{STAGES}/"):
            result.unknown.append(name)  # its name is that of its bytes
        elif is_missing:
            there, frame = ("made again", wanted[name].frame) if name in wanted else ("there", again[name].frame)
            result.faults.append(Fault(name, frame, f"is not {there}"))
        else:
            _compare_file(folder, made, name, wanted[name], result, exact=exact)
    return result


def _compare_file(folder: Path, made: Path, name: str, listed: ListedFile, result: Comparison, *, exact: bool) -> None:
    frame = listed.frame
    try:
        there, again = facts_of(folder / name), facts_of(made / name)
    except OSError as error:
        result.faults.append(Fault(name, frame, f"cannot be read: {error.strerror}"))
        return
    if there == again:
        result.equal += 1
    elif exact and name.endswith(rrd_content.SUFFIX):
        _compare_recordings(folder, made, name, frame, result)
    elif exact:
        old, new = there[1][:12], again[1][:12]
        is_listed = again[1] == listed.sha256
        whose = ", which are those of the journal: the file here was changed" if is_listed else ""
        result.faults.append(Fault(name, frame, f"is made with other bytes{whose}", f"SHA-256 {old}", new))
    else:
        _compare_within_tolerance(folder, made, name, frame, result)


def _compare_recordings(folder: Path, made: Path, name: str, frame: str, result: Comparison) -> None:
    """Compare what recordings hold: the order of their metadata is another each time."""
    try:
        is_same = rrd_content.content(folder / name) == rrd_content.content(made / name)
    except ValueError as error:
        result.faults.append(Fault(name, frame, f"cannot be read: {error}"))
        return
    if is_same:
        result.equal += 1
    else:
        result.faults.append(Fault(name, frame, "is made with other values"))


def _compare_within_tolerance(folder: Path, made: Path, name: str, frame: str, result: Comparison) -> None:
    try:
        said = difference(folder / name, made / name)
    except Unknown:
        result.unknown.append(name)
        return
    if said is None:
        result.close += 1
    else:
        result.faults.append(Fault(name, frame, f"is made otherwise: {said}"))


def changed_assets(folder: Path, made: Path) -> list[str]:
    """Return the names of assets that had other content when frames of a dataset were made again."""
    wanted, again = hashes_of(recipe.read(folder)), hashes_of(recipe.read(made))
    for part in parts_of(made):  # whose recipe does not tell of assets
        again |= hashes_of({"assets": list(journal.read(part / journal.NAME).facts.get(ASSETS, {}).values())})
    return sorted(name for name in wanted.keys() & again.keys() if not again[name] <= wanted[name])


def files_of(folder: Path, portion: Portion | None) -> dict[str, ListedFile]:
    """Return the files of the frames of a portion; None: all files."""
    listing = read_listing(folder)
    files = listing.files if listing is not None else {}
    if portion is None:
        return files
    return {name: each for name, each in files.items() if each.frame.isdigit() and portion.has(int(each.frame))}
