"""Pinned readback pool: page-locked host memory for copies of GPU arrays, reused once no NumPy array refers to it.

Copies into new pages wait for a page fault each; copies into page-locked memory run at the full speed of the bus.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import warp as wp

# Limit of page-locked memory; arrays beyond it are copied to pageable memory.
MAX_PINNED_BYTES = 1 << 30


class ReadbackPool:
    """Buffers that back NumPy arrays, reused by size.

    Args:
        allocate: allocates a buffer of a size in bytes, any object with an address `ptr`.
        max_bytes: limit of all buffers together.
    """

    def __init__(self, allocate: Callable[[int], Any], max_bytes: int = MAX_PINNED_BYTES) -> None:
        self._allocate, self._max_bytes = allocate, max_bytes
        self._free: dict[int, list[Any]] = {}  # by size in bytes
        self._bytes = 0  # of all buffers, free or in use

    def acquire(self, size: int) -> Any | None:
        """Return a buffer of `size` bytes, or None if it would exceed the limit."""
        free = self._free.get(size)
        if free:
            return free.pop()
        if self._bytes + size > self._max_bytes:
            self._free_unused()
        if self._bytes + size > self._max_bytes:
            return None
        self._bytes += size
        return self._allocate(size)

    def release(self, buffer: Any, size: int) -> None:
        """Return a buffer to the pool."""
        self._free.setdefault(size, []).append(buffer)

    def _free_unused(self) -> None:
        """Free all buffers that are not in use."""
        for size, buffers in self._free.items():
            self._bytes -= size * len(buffers)
        self._free.clear()


class PooledBuffer:
    """Array interface of a buffer, which returns to its pool when the last NumPy array that refers to it is deleted."""

    def __init__(self, pool: ReadbackPool, buffer: Any, size: int, shape: tuple[int, ...], typestr: str) -> None:
        self._pool, self._buffer, self._size = pool, buffer, size
        self.__array_interface__ = {"version": 3, "shape": shape, "typestr": typestr, "data": (buffer.ptr, False)}

    def __del__(self) -> None:
        self._pool.release(self._buffer, self._size)


_pool = ReadbackPool(lambda size: wp.empty(size, dtype=wp.uint8, device="cpu", pinned=True))


def read_back(arrays: Mapping[str, wp.array]) -> dict[str, np.ndarray]:
    """Copy contiguous arrays of one device to the host, vectors as a last axis, structs as records.

    CPU arrays are not copied: the results share their memory.
    """
    copies: dict[str, np.ndarray] = {}
    device = None
    for name, array in arrays.items():
        assert array.device is not None
        size = array.size * wp.types.type_size_in_bytes(array.dtype)
        buffer = _pool.acquire(size) if array.device.is_cuda and size else None
        if buffer is None:
            copies[name] = array.numpy()
            continue
        target = wp.array(ptr=buffer.ptr, shape=array.shape, dtype=array.dtype, device="cpu", copy=False, pinned=True)
        wp.copy(target, array)
        device = array.device
        interface = target.__array_interface__
        pooled = PooledBuffer(_pool, buffer, size, interface["shape"], interface["typestr"])
        copies[name] = np.asarray(pooled).view(target.numpy().dtype)  # restores the field names of records
    if device is not None:
        wp.synchronize_stream(wp.get_stream(device))
    return copies
