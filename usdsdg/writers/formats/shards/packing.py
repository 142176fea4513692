"""Packing of encoded samples into shards, in the order of the samples, whatever the order of the encoding threads."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any, Generic, TypeVar

S = TypeVar("S")


class Limits:
    """Where shards end: after `samples` samples, or before the one that would make it larger than `size` bytes.

    So shards depend on the samples alone.
    """

    def __init__(self, samples: int, size: int) -> None:
        self._most, self._size = samples, size
        self.count = self._bytes = 0  # of the shard that is open

    @classmethod
    def of(cls, about: Mapping[str, Any]) -> Limits:
        """Return those that a spool tells of."""
        return cls(about["samples"], about["bytes"])

    def begins_shard(self, size: int) -> bool:
        """Add a sample of so many bytes; return whether it is the first of another shard than the one before."""
        begins = bool(self.count) and (self.count >= self._most or self._bytes + size > self._size)
        if begins:
            self.count = self._bytes = 0
        self.count, self._bytes = self.count + 1, self._bytes + size
        return begins


class InOrder(Generic[S]):
    """Hands samples on in their order; those that come early wait for those before them."""

    def __init__(self, take: Callable[[S], None]) -> None:
        """take: gets one sample after the other, each on the thread that has brought it or one before it."""
        self._take, self._lock = take, threading.Lock()
        self._early: dict[int, S] = {}
        self._next = 0

    def put(self, place: int, sample: S) -> None:
        """Add the sample at a place, counted from 0; called by any thread."""
        with self._lock:
            self._early[place] = sample
            while self._next in self._early:
                self._take(self._early.pop(self._next))
                self._next += 1
