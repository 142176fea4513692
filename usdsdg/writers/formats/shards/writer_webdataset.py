"""WebDatasetWriter: tar archives of samples, as `webdataset` and Hugging Face `datasets` read them."""

from __future__ import annotations

import json
import os
from typing import Unpack

from usdsdg.writers.formats.shards import shard_files as files
from usdsdg.writers.formats.shards.encoding import array_bytes, image_bytes
from usdsdg.writers.formats.shards.sample_index import SampleIndex
from usdsdg.writers.formats.shards.samples import Sample
from usdsdg.writers.formats.shards.shard_writer import Encoded, ShardOptions, ShardWriter
from usdsdg.writers.formats.shards.tar_shard import TarSample, TarShards
from usdsdg.writers.options import typed


class WebDatasetWriter(ShardWriter):
    """Writes `<split>-NNNNNN.tar`, and `index.json` with the classes and the numbers of samples of the shards.

    The files of a sample are KEY.png (or .jpg) and KEY.json; with `masks` KEY.instances.png, whose 16-bit pixels are
    the ids of objects, 0 elsewhere; with `depth` KEY.depth.npy, float32 meters along the optical axis. KEY is the
    number of the frame, after the name of the render product where there are several. KEY.json has `key`, `frame`,
    `view`, `width`, `height` and `objects`, of which each has the keys of `samples.sample`.
    """

    version = "0.0.1"

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike | None = None,
        depth: bool = False,
        **options: Unpack[ShardOptions],
    ) -> None:
        """
        depth: write it, too.
        options: as `ShardOptions`.

        Raises:
            WriterError: two options exclude each other, a value does not exist, or there is nowhere to write.
            OutputNotWritable: output_dir or the bucket cannot be written to.
        """
        self._set_up(output_dir, options, depth=bool(depth))
        self._index = SampleIndex(self._store, "WebDatasetWriter/index")

    def _shards_of(self, split: str) -> TarShards:
        return TarShards(self._store, f"WebDatasetWriter/{split}", split=split, **self._limits)

    def _encoded(self, taken: Sample) -> TarSample:
        arrays = taken.arrays
        members = {self._image_format: image_bytes(arrays[files.IMAGE], self._image_format)}
        if files.INSTANCES in arrays:
            members[files.MEMBERS[files.INSTANCES]] = image_bytes(arrays[files.INSTANCES], "png")
        if files.DEPTH in arrays:
            members[files.MEMBERS[files.DEPTH]] = array_bytes(arrays[files.DEPTH])
        members[files.JSON] = json.dumps({**taken.facts, "objects": taken.objects}).encode()
        return TarSample(taken.key, members)

    def _add(self, made: Encoded) -> None:
        super()._add(made)
        self._index.note(classes=made.classes, splits=list(self._splits.names), **self._limits)
        self._index.add(made.frame, split=made.split, size=made.sample.size)

    def on_final_frame(self) -> None:
        super().on_final_frame()
        self._index.write()
