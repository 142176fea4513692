"""What the writers of WebDataset and Parquet share: samples, dealt to splits, encoded on the queue, and packed."""

from __future__ import annotations

import sys
from abc import abstractmethod
from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple, Protocol

from usdsdg.errors import WriterError
from usdsdg.session.session import current
from usdsdg.writers.aggregate_writer import AggregateWriter
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.files import checked_image_format
from usdsdg.writers.formats import class_places
from usdsdg.writers.formats.shards.packing import InOrder
from usdsdg.writers.formats.shards.samples import BOXES, Sample, SampleOptions, sample
from usdsdg.writers.formats.shards.shards import Shards
from usdsdg.writers.formats.splits import Splits
from usdsdg.writers.journal.frames import FrameFiles
from usdsdg.writers.options import CommonOptions, common_backend, common_labels

_DIGITS = 6
ROW_GROUP = 100  # samples of a group of rows, by default


class EncodedSample(Protocol):
    """A sample as it goes into a shard."""

    @property
    def size(self) -> int: ...

    def record(self) -> dict[str, Any]: ...


class Encoded(NamedTuple):
    """An encoded sample, and where it belongs."""

    split: str
    frame: int
    classes: list[str]  # that were known then
    sample: EncodedSample
    files: FrameFiles | None  # of its frame


class ShardOptions(CommonOptions, total=False):
    """Options of writers of shards, as `**options: Unpack[ShardOptions]`, beside `CommonOptions`.

    masks: write `instances`, too; default False.
    splits: relative sizes of the parts of the dataset, such as {"train": 0.8, "val": 0.2}; default all "train".
    frames_per_scene: so many frames in a row are in the same part; default 1.
    min_visibility: objects of which less is visible, as a fraction of what they would cover alone, are left out;
        default 0.
    min_pixels: so are objects with fewer visible pixels; default 1.
    shard_samples, shard_megabytes: a shard has at most so many samples, and is at most so large: its files, or its
        images in a table; default 1000 and 500.
    image_output_format: "png", the default, or "jpg".
    """

    masks: bool
    splits: dict | None
    frames_per_scene: int
    min_visibility: float
    min_pixels: int
    shard_samples: int
    shard_megabytes: float
    image_output_format: str


def limits_of(options: Mapping[str, Any]) -> dict[str, int]:
    """Return the most "samples" and "bytes" of a shard, by the options of a writer."""
    return {
        "samples": options.get("shard_samples", 1000),
        "bytes": int(min(options.get("shard_megabytes", 500.0) * 1e6, sys.maxsize)),
    }


class ShardWriter(AggregateWriter):
    """Base of writers with many samples in a file. A subclass encodes a sample, and writes a shard of them."""

    data_structure = "renderProduct"
    shares_arrays = True

    def _set_up(self, output_dir: Any, options: ShardOptions, *, depth: bool = False) -> None:
        """Check the options of `__init__`, and get ready to write.

        depth: samples also have distances along the optical axis [m].

        Raises:
            WriterError: one of them cannot be.
        """
        name = type(self).__name__
        for limit in ("shard_samples", "shard_megabytes"):
            if not (value := options.get(limit, 1)) > 0:
                raise WriterError(f"{name}: {limit} is {value}; expected more than 0.")
        self._options = SampleOptions(
            bool(options.get("masks")), depth, options.get("min_visibility", 0.0), options.get("min_pixels", 1)
        ).checked(name)
        self._image_format = checked_image_format(options.get("image_output_format", "png"))
        self._splits = Splits(name, options.get("splits"), options.get("frames_per_scene", 1))
        self.annotators = list(self._options.annotators(common_labels(name, options)))
        self._limits = limits_of(options)
        self.backend = common_backend(name, output_dir, options)
        self._shards = {split: self._shards_of(split) for split in self._splits.names}
        self._in_order: InOrder[Encoded] = InOrder(self._take)
        self._frame_id = self._put = 0  # the next frame, and samples of this process
        # Also if a script ends or is interrupted before its run is complete.
        current().io_queue.call_at_exit(self.on_final_frame)

    @abstractmethod
    def _shards_of(self, split: str) -> Shards:
        """Return the shards of a part of the dataset."""

    @abstractmethod
    def _encoded(self, taken: Sample) -> EncodedSample:
        """Return a sample as it goes into a shard; called on the queue."""

    def skip(self, data: dict[str, Any]) -> None:
        self._frame_id += 1

    def write(self, data: dict[str, Any]) -> None:
        several = max(len(self.render_products), len(data["renderProducts"])) > 1
        split, table = self._splits.of(self._frame_id), self._table()
        for product, seen in data["renderProducts"].items():
            key = (f"{product}_" if several else "") + f"{self._frame_id:0{_DIGITS}d}"
            made = sample(key, self._frame_id, product, seen, table, self._options)
            self._submit(split, made)
        self._frame_id += 1

    def _submit(self, split: str, made: Sample) -> None:
        """Encode a sample on the queue. The frame is not whole before the sample is in its spool."""
        place, self._put = self._put, self._put + 1
        size = sum(each.nbytes for each in made.arrays.values())
        files = current().io_queue.files_in_hand()
        number = self.num_written if files is None else files.number
        if files is not None:
            files.hold()
        pack = partial(self._pack, place, split, number, made, files)
        # A shard belongs to many frames. Not by the backend: one that is a group would have each sample once for each
        # of its members.
        with current().io_queue.of_all_frames():
            current().io_queue.submit(pack, what=made.key, size=size, owner=self)

    def on_final_frame(self) -> None:
        """Write the last shards, after all samples are encoded."""
        current().io_queue.wait_until_done(self)
        with current().io_queue.of_all_frames():
            for shards in self._shards.values():
                shards.write()

    def _pack(self, place: int, split: str, number: int, made: Sample, files: FrameFiles | None) -> None:
        self._in_order.put(place, Encoded(split, number, made.classes, self._encoded(made), files))

    def _take(self, made: Encoded) -> None:
        self._add(made)
        if made.files is not None:
            made.files.release()

    def _add(self, made: Encoded) -> None:
        """Add an encoded sample to its shard; called for one after the other, in their order."""
        self._shards[made.split].add_sample(made.frame, made.classes, made.sample.size, made.sample.record())

    def _table(self) -> Any:
        return class_places.table_of(self._annotator_called(BOXES).label_filter)

    @property
    def _store(self) -> BaseBackend:
        assert self.backend is not None
        return self.backend
