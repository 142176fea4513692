"""Reader of ParquetWriter's shards. Needs pyarrow: `pip install 'usdsdg[parquet]'`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import PurePosixPath
from typing import Any

from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.formats import sharded
from usdsdg.datasets.seen import Seen
from usdsdg.writers.formats.shards.parquet_schema import classes_of, pyarrow
from usdsdg.writers.formats.shards.shard_files import OBJECT
from usdsdg.writers.formats.shards.shard_files import PARQUET as NAME

__all__ = ["NAME", "objects", "read"]
objects = sharded.objects


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what each row of each shard says."""
    known: dict[str, str] = {}
    first: list[str] | None = None
    for file in (each for each in files if PurePosixPath(each).suffix == ".parquet"):
        arrow = pyarrow()
        table = folder.opened(file, "all", arrow.parquet.ParquetFile)
        classes = None if table is None else folder.parsed(file, "all", lambda t=table: classes_of(t.schema_arrow))
        if table is None or classes is None:
            continue
        first = classes if first is None else first
        if classes != first:
            expected, found = ", ".join(first), ", ".join(classes)
            folder.faults.append(Fault(file, "all", "names of classes are those of the first shard", expected, found))
        for group in range(table.num_row_groups):
            for row in folder.opened(file, "all", lambda _, t=table, g=group: t.read_row_group(g).to_pylist()) or ():
                key = str(row.get("key"))
                if key in known:
                    folder.faults.append(Fault(file, key, f"is in {known[key]}, too"))
                known[key] = file
                seen = folder.parsed(file, key, partial(_seen, folder, file, row, classes))
                if seen is not None:
                    yield seen


def _seen(folder: Folder, file: str, row: Mapping[str, Any], classes: Sequence[str]) -> Seen:
    listed = row["objects"]
    counts = {len(listed[name]) for name in OBJECT}
    if len(counts) > 1:
        raise ValueError(f"the lists of `objects` have {sorted(counts)} entries")
    each: list[dict[str, Any]] = [dict(zip(OBJECT, values)) for values in zip(*(listed[name] for name in OBJECT))]

    def load(kind: str) -> tuple[str, bytes] | None:
        image = row.get(kind)
        return None if image is None else (str(image["path"]), image["bytes"])

    return sharded.seen_of(folder, NAME, file, row, each, classes, load, classes_file=file)
