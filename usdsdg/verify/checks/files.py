"""Files: all that a frame wrote are there, no others are, and the numbers of frames have no gaps."""

from __future__ import annotations

from collections.abc import Iterable, Set

from usdsdg.datasets.always import always
from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.seen import Seen
from usdsdg.errors import counted
from usdsdg.record import FRAMES
from usdsdg.writers.formats.shards.shard_files import INDEX, PARQUET, WEBDATASET

_SHOWN = 8
_IN_SHARDS = {WEBDATASET: INDEX, PARQUET: "data"}  # by writer: what is named where a sample is missing


def check(folder: Folder, read: Iterable[str], *, listed: Set[str] = frozenset(), is_finished: bool = True) -> Faults:
    """Compare the files that are there with those that the records tell of.

    read: the files that belong to images of a known format. listed: those that a journal lists. is_finished: whether
        the files about all frames have been written.
    """
    told = {fault.file for fault in folder.faults} | listed
    for file in always(folder.records) if is_finished else ():
        if file not in told and not folder.has(file):
            yield Fault(file, "all", "is missing: a dataset of its format always has it")
    for record in folder.records:
        for file in record.files:
            if file not in told and not folder.has(file):
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
            names = ", ".join(map(str, missing[:_SHOWN])) + (", ..." if len(missing) > _SHOWN else "")
            what = counted(len(missing), f"frame of {writer} has", f"frames of {writer} have")
            yield Fault(FRAMES, names, f"{what} no record")


class Samples:
    """The recorded images that shards have: each is a sample, and there is no file of its own that could be missing."""

    def __init__(self) -> None:
        self._found: set[tuple[int, str]] = set()

    def add(self, seen: Seen) -> None:
        """Note one image of any format."""
        if seen.format in _IN_SHARDS and seen.truth is not None:
            self._found.add((seen.truth.record.number, seen.truth.product.name))

    def check(self, folder: Folder) -> Faults:
        """Compare the samples with the records."""
        for writer, file in _IN_SHARDS.items():
            recorded = {
                (each.number, product.name)
                for each in folder.records if each.writer == writer
                for product in each.products
            }  # fmt: skip
            if missing := sorted(recorded - self._found):
                numbers = list(dict.fromkeys(str(number) for number, _ in missing))
                names = ", ".join(numbers[:_SHOWN]) + (", ..." if len(numbers) > _SHOWN else "")
                what = "recorded images are in no shard"
                yield Fault(file, names, what, str(len(recorded)), str(len(recorded) - len(missing)))
