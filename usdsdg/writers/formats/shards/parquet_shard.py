"""Tables of samples in Parquet, a row group at a time."""

from __future__ import annotations

import base64
import itertools
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from typing import IO, Any, NamedTuple

from usdsdg.errors import warn_once
from usdsdg.stores.temporary import temporary_root
from usdsdg.writers.files import write_bytes
from usdsdg.writers.formats.shards import shard_files as files
from usdsdg.writers.formats.shards.parquet_schema import pyarrow, schema
from usdsdg.writers.formats.shards.shards import Shards
from usdsdg.writers.spool import Records

_COMPRESSION = "zstd"  # of all columns; images stay about as large as they are
_AT_A_TIME = 1 << 20  # bytes of a file that are in memory
_IMAGES = (files.IMAGE, files.INSTANCES)


class Row(NamedTuple):
    """The values of one sample by column."""

    values: dict[str, Any]

    @property
    def size(self) -> int:
        """Bytes of its images, which are nearly all of a row."""
        return sum(len(self.values[name]["bytes"]) for name in _IMAGES if name in self.values)

    def record(self) -> dict[str, Any]:
        """Return it as a spool has it."""
        images = {name: self.values[name] for name in _IMAGES if name in self.values}
        texts = {name: {**each, "bytes": base64.b64encode(each["bytes"]).decode()} for name, each in images.items()}
        return {"values": self.values | texts}


class ParquetShards(Shards):
    """Shards of a table. A record has the "values" of a row, with images in Base64.

    Of all frames are known, too, the samples of a row "group", and whether there are "masks".
    """

    def __init__(self, *args: Any, **about: Any) -> None:
        super().__init__(*args, **about)
        self._named: dict[str, list[str]] = {}  # classes by shard that is written

    @staticmethod
    def path_of(split: str, number: int) -> str:
        return files.parquet_of(split, number)

    @staticmethod
    def content(records: Records) -> Iterable[bytes]:
        arrow, known = pyarrow(), schema(records.about["classes"], masks=records.about["masks"])
        file = tempfile.TemporaryFile(dir=temporary_root())  # noqa: SIM115 - closed with what is returned
        with arrow.parquet.ParquetWriter(file, known, compression=_COMPRESSION) as table:
            rows = map(_values, records)
            while group := list(itertools.islice(rows, records.about["group"])):
                table.write_table(arrow.Table.from_pylist(group, schema=known))
        return _Parts(file)

    def complete(self, classes: list[str]) -> None:
        """Write shards that name other classes again, with the names of all; their numbers stay."""
        for path in [path for path, named in self._named.items() if named != classes]:
            self._rename(path, classes)

    def _wrote(self, path: str, records: Records) -> None:
        self._named[path] = records.about["classes"]

    def _rename(self, path: str, classes: list[str]) -> None:
        try:
            data = self._backend.read_blob(path)
        except NotImplementedError as error:
            warn_once(
                f"{path} names {len(self._named[path])} of {len(classes)} classes, as the others appeared later, and "
                f"cannot be completed: {error}. Name all with settings.set_semantic_classes before the run."
            )
            return
        arrow = pyarrow()
        buffer = arrow.BufferOutputStream()
        old = arrow.parquet.ParquetFile(arrow.BufferReader(data))
        known = schema(classes, masks=self._about["masks"])
        with arrow.parquet.ParquetWriter(buffer, known, compression=_COMPRESSION) as file:
            for group in range(old.num_row_groups):
                file.write_table(old.read_row_group(group).cast(known))
        write_bytes(path, buffer.getvalue().to_pybytes(), self._backend)
        self._named[path] = classes


class _Parts:
    """The bytes of a file in parts."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file

    def __iter__(self) -> Iterator[bytes]:
        self._file.seek(0, os.SEEK_SET)
        while data := self._file.read(_AT_A_TIME):
            yield data


def _values(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a row by column."""
    values = dict(record["values"])
    for name in _IMAGES:
        if name in values:
            values[name] = {**values[name], "bytes": base64.b64decode(values[name]["bytes"])}
    return values
