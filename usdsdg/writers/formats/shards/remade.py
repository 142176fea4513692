"""Single shards that are made again: the frames that have their samples, and the shards of these."""

from __future__ import annotations

import itertools
import re
from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from usdsdg.errors import Unsupported
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stores.whole_file import write_whole
from usdsdg.writers import spool
from usdsdg.writers.formats.shards import shard_files as files
from usdsdg.writers.formats.shards.packing import Limits
from usdsdg.writers.formats.shards.parquet_schema import classes_of, pyarrow
from usdsdg.writers.formats.shards.parquet_shard import ParquetShards
from usdsdg.writers.formats.shards.tar_shard import TarShards
from usdsdg.writers.journal.spool_hashes import AGGREGATES, ONCE, SUFFIX
from usdsdg.writers.spool import Records

_INDEX = f"{BESIDE}/{AGGREGATES}/{files.WEBDATASET}/index{SUFFIX}"
_TAR, _PARQUET = re.compile(r"(.+)-(\d{6})\.tar", re.DOTALL), re.compile(r"data/(.+)-(\d{5})\.parquet", re.DOTALL)


class ShardedFolder:
    """A dataset in a folder, with shards of which some are damaged."""

    def __init__(
        self, folder: Path, listed: Collection[str], damaged: Collection[str], frames: Collection[int]
    ) -> None:
        """listed: all files. damaged: those that are not what the run has left. frames: of the dataset."""
        self._folder, self._listed, self._damaged, self._frames = folder, listed, damaged, sorted(frames)

    def frames(self) -> dict[str, frozenset[int] | None]:
        """Return the frames with which each damaged shard is made again; None: all, as nothing tells fewer."""
        found: dict[str, frozenset[int] | None] = {}
        for name in self._damaged:
            if match := _TAR.fullmatch(name):
                found[name] = self._frames_of_tar(match[1], int(match[2]))
            elif match := _PARQUET.fullmatch(name):
                found[name] = self._frames_of_table(match[1], int(match[2]))
        return found

    def write(self, spools: Path, to: Path) -> None:
        """Write the shards of which samples were made again, to a folder.

        spools: folder of the spools of a process that has made the frames, and perhaps others.
        """
        for path in sorted((spools / ONCE / files.WEBDATASET).glob(f"*{SUFFIX}")):
            split, records = path.name.removesuffix(SUFFIX), spool.read(path)
            made = {record["frame"] for record in records}
            numbers = [number for frame, number in self._samples_of(split) if frame in made]
            if len(numbers) == records.count:
                self._write(TarShards, split, records, numbers, to)
        for path in sorted((spools / ONCE / files.PARQUET).glob(f"*{SUFFIX}")):
            split, records = path.name.removesuffix(SUFFIX), spool.read(path)
            known, classes = self._known_rows(split)
            numbers = list(_numbers(records, {key: number for number, key, _ in known}))
            about = records.about | ({"classes": classes} if classes is not None else {})
            self._write(ParquetShards, split, replace(records, about=about), numbers, to)

    def _write(self, kind: Any, split: str, records: Records, numbers: list[int], to: Path) -> None:
        """numbers: of the shard of each record."""
        of_records = iter(itertools.pairwise([-1, *numbers]))

        def begins(_: dict[str, Any]) -> bool:
            before, number = next(of_records)
            return before != number

        for (number, _), shard in zip(itertools.groupby(numbers), records.runs(begins)):
            name = kind.path_of(split, number)
            if name in self._damaged:
                write_whole(to / name, kind.content(shard))

    def _frames_of_tar(self, split: str, number: int) -> frozenset[int] | None:
        return frozenset(frame for frame, own in self._samples_of(split) if own == number) or None

    def _samples_of(self, split: str) -> list[tuple[int, int]]:
        """Return frame and shard of each sample of a split of a WebDataset; none where its index is damaged."""
        if _INDEX in self._damaged or _INDEX not in self._listed:
            return []
        records = spool.read(self._folder / _INDEX)
        limits, number, found = Limits.of(records.about), 0, []
        for record in records:
            if record["split"] == split:
                number += limits.begins_shard(record["size"])
                found.append((record["frame"], number))
        return found

    def _frames_of_table(self, split: str, number: int) -> frozenset[int] | None:
        """Return the frames from the end of the whole shard before to the begin of the one after."""
        known, _ = self._known_rows(split)
        first = max((frame for own, _, frame in known if own < number), default=None)
        last = min((frame for own, _, frame in known if own > number), default=None)
        if first is last is None:
            return None
        return frozenset(
            frame for frame in self._frames if (first is None or frame >= first) and (last is None or frame <= last)
        )

    def _known_rows(self, split: str) -> tuple[list[tuple[int, str, int]], list[str] | None]:
        """Return the shard, key and frame of each row of whole shards of a split, and the classes that they name."""
        found: list[tuple[int, str, int]] = []
        classes = None
        try:
            parquet = pyarrow().parquet
        except Unsupported:  # then nothing tells fewer frames than all
            return found, classes
        for number in itertools.count():
            name = ParquetShards.path_of(split, number)
            if name not in self._listed:
                break
            if name not in self._damaged:
                table = parquet.read_table(self._folder / name, columns=["key", "frame"])
                classes = classes_of(table.schema)
                rows = zip(table["key"].to_pylist(), table["frame"].to_pylist())
                found += [(number, key, self._frames[frame]) for key, frame in rows]
        return found, classes


def _numbers(records: Records, known: dict[str, int]) -> Iterator[int]:
    """Yield the shard of each row of a table; known: by key, those of rows of whole shards."""
    number, limits = -1, None
    for record in records:
        own = known.get(record["values"]["key"])
        if own is not None:
            number, limits = own, None
        elif limits is None:
            number, limits = number + 1, Limits.of(records.about)
            limits.begins_shard(record["size"])
        else:
            number += limits.begins_shard(record["size"])
        yield number
