"""WebDatasetWriter: tar archives of samples, as `webdataset` and Hugging Face `datasets` read them."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any, Unpack

from usdsdg.writers.files import write_bytes, write_json
from usdsdg.writers.formats.shards import shard_files as files
from usdsdg.writers.formats.shards.encoding import array_bytes, image_bytes
from usdsdg.writers.formats.shards.samples import Sample, SampleOptions
from usdsdg.writers.formats.shards.shard_writer import ShardWriter
from usdsdg.writers.formats.shards.tar_shard import TarSample, archive
from usdsdg.writers.options import CommonOptions, typed


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
        masks: bool = False,
        depth: bool = False,
        splits: dict | None = None,
        frames_per_scene: int = 1,
        min_visibility: float = 0.0,
        min_pixels: int = 1,
        shard_samples: int = 1000,
        shard_megabytes: float = 500.0,
        image_output_format: str = "png",
        **common: Unpack[CommonOptions],
    ) -> None:
        """
        masks, depth: write them, too.
        splits: relative sizes of the parts of the dataset, such as {"train": 0.8, "val": 0.2}; default all "train".
        frames_per_scene: so many frames in a row are in the same part.
        min_visibility: objects of which less is visible, as a fraction of what they would cover alone, are left out.
        min_pixels: so are objects with fewer visible pixels.
        shard_samples, shard_megabytes: a shard has at most so many samples, and is at most so large.
        image_output_format: "png" or "jpg".
        common: as `CommonOptions`.

        Raises:
            WriterError: two options exclude each other, a value does not exist, or there is nowhere to write.
            OutputNotWritable: output_dir or the bucket cannot be written to.
        """
        self._set_up(
            output_dir, common, options=SampleOptions(masks, depth, min_visibility, min_pixels), splits=splits,
            frames_per_scene=frames_per_scene,
            image_format=image_output_format, shard_samples=shard_samples, shard_megabytes=shard_megabytes,
        )  # fmt: skip

    def _encoded(self, taken: Sample) -> TarSample:
        arrays = taken.arrays
        members = {self._image_format: image_bytes(arrays[files.IMAGE], self._image_format)}
        if files.INSTANCES in arrays:
            members[files.MEMBERS[files.INSTANCES]] = image_bytes(arrays[files.INSTANCES], "png")
        if files.DEPTH in arrays:
            members[files.MEMBERS[files.DEPTH]] = array_bytes(arrays[files.DEPTH])
        members[files.JSON] = json.dumps({**taken.facts, "objects": taken.objects}).encode()
        return TarSample(taken.key, members)

    def _write_shard(self, split: str, number: int, taken: Sequence[Any]) -> None:
        write_bytes(files.tar_of(split, number), archive(taken), self._store)

    def _finish(self) -> None:
        super()._finish()
        counts = {
            split: {files.tar_of(split, number): count for number, count in enumerate(packer.counts)}
            for split, packer in self._packers.items()
        }
        if any(counts.values()):
            write_json(files.INDEX, {"classes": self._classes, "shards": counts}, self._store, indent=1)
