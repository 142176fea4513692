"""The samples of finished shards, read back to the spools of which shards are made, so that a dataset can grow.

A run that has ended has removed these spools, since they are as large as the shards.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import tarfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from usdsdg.errors import WriterError
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stores.whole_file import write_whole
from usdsdg.writers.formats.shards import shard_files as files
from usdsdg.writers.formats.shards.parquet_schema import classes_of, pyarrow
from usdsdg.writers.formats.shards.parquet_shard import ParquetShards, Row
from usdsdg.writers.formats.shards.shard_writer import ROW_GROUP, limits_of
from usdsdg.writers.formats.shards.tar_shard import TarSample, TarShards
from usdsdg.writers.journal.facts import WRITERS
from usdsdg.writers.journal.journal import Contents
from usdsdg.writers.journal.places.place import Place
from usdsdg.writers.journal.spool_hashes import AGGREGATES, ONCE, SUFFIX

_PARQUET = re.compile(r"data/(.+)-(\d{5})\.parquet", re.DOTALL)
_INDEX = f"{files.WEBDATASET}/index"
Line = dict[str, Any]


def restore_samples(place: Place, contents: Contents) -> None:
    """Write the spools of samples of a run that has ended, of its shards; contents: of its journal.

    Raises:
        WriterError: a shard is missing or was changed, or it is not known how the writer was set up.
        Unsupported: pyarrow is not installed.
    """
    spools = place.path / BESIDE / AGGREGATES
    index = spools / f"{_INDEX}{SUFFIX}"
    if index.is_file():
        lines = [json.loads(line) for line in index.read_bytes().splitlines()]
        about = next(line["about"] for line in reversed(lines) if "about" in line)
        for split in about["splits"]:
            records = [line for line in lines if line.get("split") == split]
            if records:
                _write(spools, files.WEBDATASET, split, _of_tars(place, contents, split, about, records))
    tables: dict[str, int] = {}  # how many shards each split has
    for name in contents.shared:
        if match := _PARQUET.fullmatch(name):
            tables[match[1]] = max(tables.get(match[1], 0), int(match[2]) + 1)
    for split, count in tables.items():
        _write(spools, files.PARQUET, split, _of_tables(place, contents, split, count))


def _write(spools: Path, writer: str, split: str, lines: Iterator[Line]) -> None:
    write_whole(spools / ONCE / writer / f"{split}{SUFFIX}", (json.dumps(line).encode() + b"\n" for line in lines))


def _of_tars(
    place: Place, contents: Contents, split: str, about: Mapping[str, Any], records: list[Line]
) -> Iterator[Line]:
    """Yield the lines of a spool of TarShards. records: of the samples in the index."""
    yield {"kind": TarShards.__name__}
    limits = {name: about[name] for name in ("samples", "bytes")}
    yield {"about": {"split": split, **limits, "classes": about["classes"]}}
    rest, path = iter(records), TarShards.path_of(split, 0)
    for data, path in _shards(place, contents, TarShards, split):
        for sample in _samples(data):
            record = next(rest, None)
            if record is None or record["size"] != sample.size:
                raise _unlike(place, path)
            yield {"frame": record["frame"], "size": sample.size, **sample.record()}
    if next(rest, None) is not None:
        raise _unlike(place, path)


def _samples(archive: bytes) -> Iterator[TarSample]:
    key, members = "", {}
    with tarfile.open(fileobj=io.BytesIO(archive), mode="r:") as tar:
        for member in tar:
            content = tar.extractfile(member)
            name, _, extension = member.name.partition(".")
            if members and name != key:
                yield TarSample(key, members)
                members = {}
            key, members[extension] = name, content.read() if content is not None else b""
    if members:
        yield TarSample(key, members)


def _of_tables(place: Place, contents: Contents, split: str, count: int) -> Iterator[Line]:
    """Yield the lines of a spool of ParquetShards."""
    arguments = [
        each for key, each in contents.facts.get(WRITERS, {}).items() if key.rpartition("-")[0] == files.PARQUET
    ]
    shards = list(_opened_tables(place, contents, split))
    if len(arguments) != 1 or len(shards) != count:
        raise WriterError(f"{place.name}: its Parquet shards are not of one ParquetWriter, so they cannot grow.")
    known = shards[-1].schema_arrow
    numbers = sorted(contents.frames)
    yield {"kind": ParquetShards.__name__}
    yield {
        "about": {
            "split": split,
            "group": arguments[0].get("row_group_samples", ROW_GROUP),
            "masks": files.INSTANCES in known.names,
            **limits_of(arguments[0]),
            "classes": classes_of(known),
        }
    }
    for table in shards:
        for group in range(table.num_row_groups):
            for values in table.read_row_group(group).to_pylist():
                if values["frame"] >= len(numbers):  # the journal has lost lines: if its last ones, they are made again
                    if numbers[-1] - numbers[0] >= len(numbers):
                        raise _unlike(place, ParquetShards.path_of(split, 0))
                    return
                row = Row(values)
                yield {"frame": numbers[values["frame"]], "size": row.size, **row.record()}


def _opened_tables(place: Place, contents: Contents, split: str) -> Iterator[Any]:
    arrow = pyarrow()
    for data, _ in _shards(place, contents, ParquetShards, split):
        yield arrow.parquet.ParquetFile(arrow.BufferReader(data))


def _shards(place: Place, contents: Contents, kind: type[Any], split: str) -> Iterator[tuple[bytes, str]]:
    """Yield the content and the path of each shard, as the journal lists it."""
    number = 0
    while (path := kind.path_of(split, number)) in contents.shared:
        data = place.read(path)
        if data is None or contents.shared[path] != (len(data), hashlib.sha256(data).hexdigest()):
            raise _unlike(place, path)
        yield data, path
        number += 1


def _unlike(place: Place, path: str) -> WriterError:
    return WriterError(
        f"{place.name}/{path} is missing or is not as the run has left it, and it grows by samples. Make it again "
        "as it was with usdsdg repair, or begin again with --overwrite."
    )
