"""What the writers of WebDataset and Parquet share: samples, dealt to splits, encoded on the queue, and packed."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from usdsdg.errors import WriterError
from usdsdg.session.session import current
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.base import Writer
from usdsdg.writers.files import checked_image_format
from usdsdg.writers.formats import class_places
from usdsdg.writers.formats.shards.packing import Packer
from usdsdg.writers.formats.shards.samples import BOXES, Sample, SampleOptions, sample
from usdsdg.writers.formats.splits import Splits
from usdsdg.writers.options import CommonOptions, common_backend, common_labels

_DIGITS = 6


class ShardWriter(Writer):
    """Base of writers with many samples in a file. A subclass encodes a sample, and writes a shard of them."""

    data_structure = "renderProduct"
    shares_arrays = True

    def _set_up(
        self,
        output_dir: Any,
        common: CommonOptions,
        *,
        options: SampleOptions,
        splits: Mapping[str, float] | None,
        frames_per_scene: int,
        image_format: str,
        shard_samples: int,
        shard_megabytes: float,
    ) -> None:
        """Check the options of `__init__`, and get ready to write.

        Raises:
            WriterError: one of them cannot be.
        """
        name = type(self).__name__
        for limit, value in (("shard_samples", shard_samples), ("shard_megabytes", shard_megabytes)):
            if not value > 0:
                raise WriterError(f"{name}: {limit} is {value}; expected more than 0.")
        self._options, self._image_format = options.checked(name), checked_image_format(image_format)
        self._splits = Splits(name, splits, frames_per_scene)
        self.annotators = list(options.annotators(common_labels(name, common)))
        self.backend = common_backend(name, output_dir, common)
        size = int(shard_megabytes * 1e6)
        self._packers = {
            split: Packer(partial(self._write_shard, split), samples=shard_samples, size=size)
            for split in self._splits.names
        }
        self._put = dict.fromkeys(self._splits.names, 0)
        self._frame_id = 0
        # Names of the classes at the last frame: the class table ends with its stage, before the last shard is written.
        self._classes: list[str] = []
        # Also if a script ends or is interrupted before its run is complete.
        current().io_queue.call_at_exit(self._finish)

    @abstractmethod
    def _encoded(self, taken: Sample) -> Any:
        """Return a sample as the bytes and values that go into a shard, with its `size`; called on the queue."""

    @abstractmethod
    def _write_shard(self, split: str, number: int, taken: Sequence[Any]) -> None:
        """Write a shard of encoded samples; called on the queue, and at the end."""

    def write(self, data: dict[str, Any]) -> None:
        several = max(len(self.render_products), len(data["renderProducts"])) > 1
        split, table = self._splits.of(self._frame_id), self._table()
        for product, seen in data["renderProducts"].items():
            key = (f"{product}_" if several else "") + f"{self._frame_id:0{_DIGITS}d}"
            made = sample(key, self._frame_id, product, seen, table, self._options)
            self._classes = made.classes
            place, self._put[split] = self._put[split], self._put[split] + 1
            size = sum(each.nbytes for each in made.arrays.values())
            # Not by the backend: one that is a group would have each sample once for each of its members.
            current().io_queue.submit(partial(self._pack, split, place, made), what=key, size=size, owner=self)
        self._frame_id += 1

    def on_final_frame(self) -> None:
        self._finish()

    def detach(self) -> None:
        super().detach()
        if self.backend is not None:
            self._finish()

    def _pack(self, split: str, place: int, made: Sample) -> None:
        self._packers[split].put(place, self._encoded(made))

    def _finish(self) -> None:
        """Write the last shards, after all samples are encoded."""
        current().io_queue.wait_until_done(self)
        for packer in self._packers.values():
            packer.close()

    def _table(self) -> Any:
        return class_places.table_of(self.get_annotator(BOXES).label_filter)

    @property
    def _store(self) -> BaseBackend:
        assert self.backend is not None
        return self.backend
