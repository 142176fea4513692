"""Arrays of a GPU on the host, in page-locked memory that is used again once nobody looks at it.

Copies into fresh pages of a process wait for each page to be made; these take the bus at its full speed.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import warp as wp

# Of page-locked memory; what does not fit goes into ordinary pages.
MOST_BYTES = 1 << 30


class Pool:
    """Buffers of bytes that are lent to NumPy arrays.

    Args:
        allocate: makes a buffer of so many bytes, any object with an address `ptr`.
        most: bytes in all buffers together.
    """

    def __init__(self, allocate: Callable[[int], Any], most: int = MOST_BYTES) -> None:
        self._allocate, self._most = allocate, most
        self._free: dict[int, list[Any]] = {}
        self._bytes = 0  # of all buffers, free or lent

    def take(self, size: int) -> Any | None:
        """A buffer of `size` bytes, or None where there is no room."""
        free = self._free.get(size)
        if free:
            return free.pop()
        if self._bytes + size > self._most:
            self._let_go()
        if self._bytes + size > self._most:
            return None
        self._bytes += size
        return self._allocate(size)

    def give(self, buffer: Any, size: int) -> None:
        """Take a buffer back."""
        self._free.setdefault(size, []).append(buffer)

    def _let_go(self) -> None:
        """Free what is not lent."""
        for size, buffers in self._free.items():
            self._bytes -= size * len(buffers)
        self._free.clear()


class Loan:
    """A buffer as NumPy sees it; it goes back to its pool with the last array that shows a part of it."""

    def __init__(self, pool: Pool, buffer: Any, size: int, shape: tuple[int, ...], typestr: str) -> None:
        self._pool, self._buffer, self._size = pool, buffer, size
        self.__array_interface__ = {"version": 3, "shape": shape, "typestr": typestr, "data": (buffer.ptr, False)}

    def __del__(self) -> None:
        self._pool.give(self._buffer, self._size)


_pool = Pool(lambda size: wp.empty(size, dtype=wp.uint8, device="cpu", pinned=True))


def fetch(arrays: Mapping[str, wp.array]) -> dict[str, np.ndarray]:
    """Contiguous arrays of one device on the host, vectors as a last axis, structs as records.

    On a CPU they are the arrays themselves.
    """
    fetched: dict[str, np.ndarray] = {}
    device = None
    for name, array in arrays.items():
        size = array.size * wp.types.type_size_in_bytes(array.dtype)
        buffer = _pool.take(size) if array.device.is_cuda and size else None
        if buffer is None:
            fetched[name] = array.numpy()
            continue
        lent = wp.array(ptr=buffer.ptr, shape=array.shape, dtype=array.dtype, device="cpu", copy=False, pinned=True)
        wp.copy(lent, array)
        device = array.device
        like = lent.__array_interface__
        loan = Loan(_pool, buffer, size, like["shape"], like["typestr"])
        fetched[name] = np.asarray(loan).view(lent.numpy().dtype)  # records have names again
    if device is not None:
        wp.synchronize_stream(wp.get_stream(device))
    return fetched
