"""Buffers: memory of arrays that is used again once no array refers to it.

New memory costs a page fault for every 4 KiB, which takes longer than most kernels need to fill it.
"""

from collections.abc import Callable
from contextlib import suppress
from math import prod
from typing import Any

import numpy as np

# Limit of the host's memory that is kept for images; arrays beyond it are of new memory.
MAX_HOST_BYTES = 1 << 29
# Smaller arrays are of new memory: it comes without page faults.
LEAST_BYTES = 1 << 16


class BufferPool:
    """Buffers that back NumPy arrays, reused by size. Buffers have few sizes, each for arrays that are a bit smaller.

    Args:
        allocate: allocates a buffer of a size in bytes, any object with an address `ptr`.
        max_bytes: limit of all buffers together.
    """

    def __init__(self, allocate: Callable[[int], Any], max_bytes: int) -> None:
        self._allocate, self._max_bytes = allocate, max_bytes
        self._free: dict[int, list[Any]] = {}  # by size in bytes
        self._bytes = 0  # of all buffers, free or in use

    def acquire(self, size: int) -> Any | None:
        """Return a buffer of at least `size` bytes, or None if it would exceed the limit."""
        size = _rounded(size)
        # Arrays are deleted in any thread, so buffers may come and go between two lines.
        with suppress(KeyError, IndexError):
            return self._free[size].pop()
        if self._bytes + size > self._max_bytes:
            self._make_room(size)
        if self._bytes + size > self._max_bytes:
            return None
        self._bytes += size
        return self._allocate(size)

    def release(self, buffer: Any, size: int) -> None:
        """Return a buffer that `acquire` gave for so many bytes to the pool."""
        self._free.setdefault(_rounded(size), []).append(buffer)

    def _make_room(self, size: int) -> None:
        """Free buffers that are not in use, one size after the other, until there is room for so many bytes."""
        for known in list(self._free):
            if self._bytes + size <= self._max_bytes:
                return
            self._bytes -= known * len(self._free.pop(known, ()))


def _rounded(size: int) -> int:
    """Return the size of the buffers of arrays of `size` bytes, by at most an eighth more.

    Arrays whose lengths differ from frame to frame, as those of point clouds, have the same few sizes so: to allocate
    page-locked memory for each takes longer than to compute it.
    """
    step = 1 << max(size.bit_length() - 4, 0)
    return -(-size // step) * step


class PooledBuffer:
    """Array interface of a buffer, which returns to its pool when the last NumPy array that refers to it is deleted."""

    def __init__(self, pool: BufferPool, buffer: Any, size: int, shape: tuple[int, ...], typestr: str) -> None:
        self._pool, self._buffer, self._size = pool, buffer, size
        self.__array_interface__ = {"version": 3, "shape": shape, "typestr": typestr, "data": (buffer.ptr, False)}

    def __del__(self) -> None:
        self._pool.release(self._buffer, self._size)


class _HostMemory:
    """Memory of the host with an address."""

    def __init__(self, size: int) -> None:
        self._values = np.empty(size, np.uint8)
        self.ptr = self._values.ctypes.data


_host = BufferPool(_HostMemory, MAX_HOST_BYTES)


def empty(shape: tuple[int, ...], dtype: Any) -> np.ndarray:
    """Return an array of undefined values, as `np.empty`, whose memory is used again."""
    dtype = np.dtype(dtype)
    size = prod(shape) * dtype.itemsize
    buffer = _host.acquire(size) if size >= LEAST_BYTES else None
    if buffer is None:
        return np.empty(shape, dtype)
    return np.asarray(PooledBuffer(_host, buffer, size, shape, dtype.str))
