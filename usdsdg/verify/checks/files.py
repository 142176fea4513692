"""Files: all that a frame wrote are there, no others are, and the numbers of frames have no gaps."""

from __future__ import annotations

from collections.abc import Iterable, Set

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.folder import Folder
from usdsdg.record import FRAMES


def check(folder: Folder, read: Iterable[str], *, listed: Set[str] = frozenset()) -> Faults:
    """read: the files that belong to images of a known format. listed: those that a journal lists."""
    there = set(folder.files)
    for record in folder.records:
        for file in record.files:
            if file not in there and file not in listed and not folder.has(file):
                yield Fault(file, str(record.number), "is missing: the frame wrote it")
    if folder.records and all(record.files or not record.products for record in folder.records):
        for file in sorted(set(read) - set(folder.record_of) - listed):
            if folder.has(file):
                yield Fault(file, "?", "no recorded frame wrote it")
    numbers: dict[str, list[int]] = {}
    for record in folder.records:
        numbers.setdefault(record.writer, []).append(record.number)
    for writer, found in numbers.items():
        missing = sorted(set(range(max(found) + 1)) - set(found))
        if missing:
            names = ", ".join(map(str, missing[:8])) + (", ..." if len(missing) > 8 else "")
            yield Fault(FRAMES, names, f"{len(missing)} frames of {writer} have no record")
