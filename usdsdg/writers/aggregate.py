"""Files about all pictures of a dataset, made of the spool of their records at the end of a run."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from usdsdg.session.session import current
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.files import BlobSink, write_parts
from usdsdg.writers.journal.run import get_run
from usdsdg.writers.spool import Records, Spool

Texts = Callable[[], Iterable[str]]


class Aggregate(ABC):
    """Text files that `write` makes of the records so far; it is also called when the program ends.

    Memory and the time of a frame do not depend on the number of frames: records are appended to a spool, and the files
    are streamed from there.
    """

    def __init__(self, backend: BaseBackend, name: str) -> None:
        """name: of the spool."""
        self._backend, self._spool = backend, Spool(backend, name, type(self).__name__)
        self._written = 0  # bytes of the spool of which the files are
        # Also if a script ends or is interrupted before its run is complete.
        current().io_queue.call_at_exit(self.write)

    @staticmethod
    @abstractmethod
    def files(records: Records) -> Mapping[str, Texts]:
        """Return what makes the parts of each file's text, by its path: of the records alone."""

    @classmethod
    def paths(cls, records: Records) -> list[str]:
        """Return the paths of the files that `schedule` writes."""
        return list(cls.files(records))

    def add(self, frame: int, **records: Any) -> None:
        """Add what a picture of a frame adds, which `files` reads; errors are those of `Spool.append`."""
        self._spool.append(frame, records)

    def note(self, **about: Any) -> None:
        """Say what is true of all frames from now on."""
        self._spool.note(about)

    def write(self) -> None:
        """Schedule the files after the pictures that they name, if there are new records; they appear whole."""
        if get_run().is_part or get_run().aggregates_wait:
            return  # they are made of the spools at the end, or when all parts are there
        if self._spool.size == self._written:
            return
        records = self._spool.so_far()
        self.schedule(records, self._backend)
        self._written = records.size

    @classmethod
    def schedule(cls, records: Records, backend: BaseBackend) -> None:
        """Schedule the files that are made of records, after all that is scheduled now."""
        with current().io_queue.of_all_frames():
            for path, texts in cls.files(records).items():
                backend.schedule_after_all(_write, path=path, texts=texts)


def separated(texts: Iterable[str], separator: str = ",\n") -> Iterator[str]:
    """Yield texts with separators between them."""
    for number, text in enumerate(texts):
        yield f"{separator}{text}" if number else text


def _write(path: str, texts: Texts, backend_instance: BlobSink) -> None:
    write_parts(path, texts, backend_instance)
