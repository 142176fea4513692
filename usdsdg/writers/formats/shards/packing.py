"""Packing of encoded samples into shards, in the order of the samples, whatever the order of the encoding threads."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Generic, Protocol, TypeVar

T = TypeVar("T")


class Sized(Protocol):
    """An encoded sample."""

    @property
    def size(self) -> int: ...


S = TypeVar("S", bound=Sized)


class Packer(Generic[S]):
    """Collects the samples of one part of a dataset, and writes each shard when it is full.

    A shard ends after `samples` samples, or before the one that would make it larger than `size` bytes; so shards
    depend on the samples alone. Samples that come early wait for those before them.
    """

    def __init__(self, write: Callable[[int, Sequence[S]], None], *, samples: int, size: int) -> None:
        """write: gets the number of a shard, from 0, and its samples."""
        self._write, self._most, self._size = write, samples, size
        self._lock = threading.Lock()
        self._early: dict[int, S] = {}
        self._open: list[S] = []
        self._bytes = 0  # of these
        self._next = 0
        self.counts: list[int] = []  # samples of each shard that is written

    def put(self, place: int, sample: S) -> None:
        """Add the sample at a place, counted from 0; called by any thread."""
        with self._lock:
            self._early[place] = sample
            while self._next in self._early:
                self._add(self._early.pop(self._next))
                self._next += 1

    def close(self) -> None:
        """Write what is left as a last shard."""
        with self._lock:
            self._finish()

    def _add(self, sample: S) -> None:
        if self._open and self._bytes + sample.size > self._size:
            self._finish()
        self._open.append(sample)
        self._bytes += sample.size
        if len(self._open) >= self._most:
            self._finish()

    def _finish(self) -> None:
        if self._open:
            full, self._open, self._bytes = self._open, [], 0
            self._write(len(self.counts), full)
            self.counts.append(len(full))
