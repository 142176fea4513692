"""ParquetWriter: tables of pictures and their labels, as Hugging Face `datasets` reads them."""

from __future__ import annotations

import os
from typing import Unpack

from usdsdg.errors import WriterError
from usdsdg.session.session import current
from usdsdg.writers.formats.shards import shard_files as files
from usdsdg.writers.formats.shards.encoding import image_bytes
from usdsdg.writers.formats.shards.parquet_schema import pyarrow
from usdsdg.writers.formats.shards.parquet_shard import ParquetShards, Row
from usdsdg.writers.formats.shards.samples import Sample
from usdsdg.writers.formats.shards.shard_writer import ROW_GROUP, Encoded, ShardOptions, ShardWriter
from usdsdg.writers.options import typed


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
        row_group_samples: int = ROW_GROUP,
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
        self._tables: list[ParquetShards] = []
        self._classes: list[str] = []  # names of those at the last sample
        self._set_up(output_dir, options)

    def _shards_of(self, split: str) -> ParquetShards:
        about = {"split": split, "group": self._group, "masks": self._options.masks, **self._limits}
        self._tables.append(ParquetShards(self._store, f"ParquetWriter/{split}", **about))
        return self._tables[-1]

    def _encoded(self, taken: Sample) -> Row:
        kinds = {files.IMAGE: self._image_format, files.INSTANCES: "png"}
        images = {
            name: {"bytes": image_bytes(array, kinds[name]), "path": f"{taken.key}.{name}.{kinds[name]}"}
            for name, array in taken.arrays.items()
        }
        objects = {name: [each[name] for each in taken.objects] for name in files.OBJECT}
        return Row({**taken.facts, **images, "objects": objects})

    def _add(self, made: Encoded) -> None:
        super()._add(made)
        self._classes = made.classes

    def on_final_frame(self) -> None:
        super().on_final_frame()
        with current().io_queue.of_all_frames():
            for shards in self._tables:
                shards.complete(self._classes)
