"""The shards of one part of a dataset, made of the spool of its encoded samples."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import Any

from usdsdg.session.session import current
from usdsdg.writers.aggregate import Aggregate, Texts
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.files import BlobSink
from usdsdg.writers.formats.shards.packing import Limits
from usdsdg.writers.journal.run import get_run
from usdsdg.writers.spool import Records, Spool


class Shards(Aggregate):
    """Shards are written as they fill up; in a part, and in a run that goes on, when all samples are there.

    A record has the "size" of a sample [bytes] and what its shard has of it. Of all frames are known the "split", the
    "classes", and the most "samples" and "bytes" of a shard. No more than one sample or row group is in memory.
    """

    def __init__(self, backend: BaseBackend, name: str, **about: Any) -> None:
        """name: of the spool. about: what is known of all frames, without the classes."""
        super().__init__(backend, name)
        self._name, self._about = name, about
        self._spool = self._new_spool()
        self._limits = Limits.of(about)
        self._last = (0, 0)  # the shard that `write` wrote last, and bytes of the spool then
        self._number = self._start = 0  # of the open shard: its number, and where its samples begin in the spool

    @staticmethod
    def files(records: Records) -> Mapping[str, Texts]:
        """Return nothing: shards are no texts."""
        return {}

    @staticmethod
    @abstractmethod
    def path_of(split: str, number: int) -> str:
        """Return the file of a shard."""

    @staticmethod
    @abstractmethod
    def content(records: Records) -> Iterable[bytes]:
        """Return the bytes of a shard in parts, which may be gone over several times."""

    def add_sample(self, frame: int, classes: list[str], size: int, record: Mapping[str, Any]) -> None:
        """Add a sample, and write the shard that is full without it, if any; errors are those of `Spool.append`.

        Called by one thread at a time.
        """
        self._spool.note({**self._about, "classes": classes})
        before = self._spool.size
        begins = self._limits.begins_shard(size)
        if begins and not self._waits:
            self._write_open()
        if begins:
            self._number, self._start = self._number + 1, before
            if self._spool.is_temporary:
                self._spool, self._start = self._new_spool(), 0
                self._spool.note({**self._about, "classes": classes})
        self._spool.append(frame, {"size": size, **record})

    def write(self) -> None:
        """Write the open shard, which later samples may still enlarge."""
        state = (self._number, self._spool.size)
        if self._waits or not self._limits.count or state == self._last:
            return
        self._write_open()
        self._last = state

    @classmethod
    def schedule(cls, records: Records, backend: BaseBackend) -> None:
        with current().io_queue.of_all_frames():
            for path, shard in cls._runs(records):
                backend.schedule_after_all(partial(_write, content=cls.content), path=path, records=shard)

    @classmethod
    def paths(cls, records: Records) -> list[str]:
        return [path for path, _ in cls._runs(records)]

    @classmethod
    def _runs(cls, records: Records) -> Iterator[tuple[str, Records]]:
        """Yield the path of each shard with its records."""
        limits = Limits.of(records.about)
        for number, shard in enumerate(records.runs(lambda each: limits.begins_shard(each["size"]))):
            yield cls.path_of(records.about["split"], number), shard

    @property
    def _waits(self) -> bool:
        """Whether shards are made of the whole spool at the end."""
        return get_run().is_part or get_run().aggregates_wait or self._spool.goes_on

    def _write_open(self) -> None:
        path, records = self.path_of(self._about["split"], self._number), self._spool.so_far()
        self._wrote(path, records)
        shard = Records(records.file, records.size, self._limits.count, records.about, records.keeps, start=self._start)
        _write(path, shard, self._backend, content=self.content)

    def _wrote(self, path: str, records: Records) -> None:
        """Called when a shard is written before the end of the run."""

    def _new_spool(self) -> Spool:
        return Spool(self._backend, self._name, type(self).__name__, once=True)


def _write(path: str, records: Records, backend_instance: BlobSink, *, content: Any) -> None:
    backend_instance.write_chunks(path, content(records))  # type: ignore[attr-defined]
