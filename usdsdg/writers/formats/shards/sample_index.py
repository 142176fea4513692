"""`index.json` of a WebDataset: its classes, and the shards with the numbers of their samples."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import partial

from usdsdg.writers.aggregate import Aggregate, Texts
from usdsdg.writers.formats.shards import shard_files as files
from usdsdg.writers.formats.shards.packing import Limits
from usdsdg.writers.spool import Records


class SampleIndex(Aggregate):
    """A record has the "split" and the "size" of a sample.

    Of all frames are known the "classes", the "splits", and the most "samples" and "bytes" of a shard.
    """

    @staticmethod
    def files(records: Records) -> dict[str, Texts]:
        return {files.INDEX: partial(_index, records)}


def _index(records: Records) -> Iterator[str]:
    about = records.about
    counts: dict[str, list[int]] = {split: [] for split in about["splits"]}
    limits = {split: Limits.of(about) for split in counts}
    for each in records:
        own = counts[each["split"]]
        if limits[each["split"]].begins_shard(each["size"]) or not own:
            own.append(0)
        own[-1] += 1
    shards = {
        split: {files.tar_of(split, number): count for number, count in enumerate(own)} for split, own in counts.items()
    }
    yield json.dumps({"classes": about["classes"], "shards": shards}, indent=1)
