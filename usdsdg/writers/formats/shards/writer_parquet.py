"""ParquetWriter: tables of pictures and their labels, as Hugging Face `datasets` reads them."""

from __future__ import annotations

import io
import os
from collections.abc import Sequence
from typing import Any, NamedTuple, Unpack

from usdsdg.errors import WriterError, warn_once
from usdsdg.writers.files import write_bytes
from usdsdg.writers.formats.shards import shard_files as files
from usdsdg.writers.formats.shards.encoding import image_bytes
from usdsdg.writers.formats.shards.parquet_schema import pyarrow, schema
from usdsdg.writers.formats.shards.samples import Sample
from usdsdg.writers.formats.shards.shard_writer import ShardOptions, ShardWriter
from usdsdg.writers.options import typed

_COMPRESSION = "zstd"  # of all columns; images stay about as large as they are


class Row(NamedTuple):
    """The values of one sample by column, and the classes that were known then."""

    values: dict[str, Any]
    classes: list[str]

    @property
    def size(self) -> int:
        """Bytes of its images, which are nearly all of a row."""
        return sum(len(self.values[name]["bytes"]) for name in (files.IMAGE, files.INSTANCES) if name in self.values)


class ParquetWriter(ShardWriter):
    """Writes `data/<split>-NNNNN.parquet`. Needs pyarrow: `pip install 'usdsdg[parquet]'`.

    A row is a picture: `key`, `frame`, `view`, `width`, `height`, `image` (bytes and path, which `datasets` decodes),
    with `masks` also `instances` (an image whose 16-bit pixels are the ids of objects, 0 elsewhere), and `objects`, a
    list for each key of `samples.sample`; `category` is a ClassLabel. Where classes appear later, the names in earlier
    shards are completed at the end.
    """

    version = "0.0.1"

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike | None = None,
        row_group_samples: int = 100,
        **options: Unpack[ShardOptions],
    ) -> None:
        """
        row_group_samples: samples that a reader has to hold at once.
        options: as `ShardOptions`.

        Raises:
            WriterError: two options exclude each other, a value does not exist, or there is nowhere to write.
            OutputNotWritable: output_dir or the bucket cannot be written to.
            Unsupported: pyarrow is not installed.
        """
        pyarrow()
        if row_group_samples < 1:
            raise WriterError(f"ParquetWriter: row_group_samples is {row_group_samples}; expected 1 or more.")
        self._group = row_group_samples
        self._named: dict[str, list[str]] = {}  # classes by shard
        self._set_up(output_dir, options)

    def _encoded(self, taken: Sample) -> Row:
        kinds = {files.IMAGE: self._image_format, files.INSTANCES: "png"}
        images = {
            name: {"bytes": image_bytes(array, kinds[name]), "path": f"{taken.key}.{name}.{kinds[name]}"}
            for name, array in taken.arrays.items()
        }
        objects = {name: [each[name] for each in taken.objects] for name in files.OBJECT}
        return Row({**taken.facts, **images, "objects": objects}, taken.classes)

    def _write_shard(self, split: str, number: int, taken: Sequence[Row]) -> None:
        path, classes = files.parquet_of(split, number), taken[-1].classes
        arrow, known = pyarrow(), schema(classes, masks=self._options.masks)
        buffer = io.BytesIO()
        with arrow.parquet.ParquetWriter(buffer, known, compression=_COMPRESSION) as file:
            for first in range(0, len(taken), self._group):
                rows = [each.values for each in taken[first : first + self._group]]
                file.write_table(arrow.Table.from_pylist(rows, schema=known))
        write_bytes(path, buffer.getvalue(), self._store)
        self._named[path] = classes

    def _finish(self) -> None:
        super()._finish()
        for path in [path for path, named in self._named.items() if named != self._classes]:
            self._rename(path, self._classes)

    def _rename(self, path: str, classes: list[str]) -> None:
        """Write a shard again with the names of all classes; their numbers stay."""
        try:
            data = self._store.read_blob(path)
        except NotImplementedError as error:
            warn_once(
                f"{path} names {len(self._named[path])} of {len(classes)} classes, as the others appeared later, and "
                f"cannot be completed: {error}. Name all with settings.set_semantic_classes before the run."
            )
            return
        arrow, buffer = pyarrow(), io.BytesIO()
        old = arrow.parquet.ParquetFile(io.BytesIO(data))
        known = schema(classes, masks=self._options.masks)
        with arrow.parquet.ParquetWriter(buffer, known, compression=_COMPRESSION) as file:
            for group in range(old.num_row_groups):
                file.write_table(old.read_row_group(group).cast(known))
        write_bytes(path, buffer.getvalue(), self._store)
        self._named[path] = classes
