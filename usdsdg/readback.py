"""Pinned readback: copies of GPU arrays in page-locked memory of the host, which is used again.

Copies into new pages wait for a page fault each; copies into page-locked memory run at the full speed of the bus.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from usdsdg.buffers import BufferPool, PooledBuffer

if TYPE_CHECKING:
    import warp as wp

# Limit of page-locked memory; arrays beyond it are copied to pageable memory. What waits to be written may fill half.
MAX_PINNED_BYTES = 1 << 31


def _pinned(size: int) -> wp.array:
    import warp as wp

    byte: Any = wp.uint8  # Warp declares `dtype: type[float]`
    return wp.empty(size, dtype=byte, device="cpu", pinned=True)


_pool = BufferPool(_pinned, MAX_PINNED_BYTES)


class Arrival:
    """Copies from a device that are under way; the device fills them while Python goes on."""

    def __init__(self, copies: dict[str, np.ndarray], device: wp.Device | None) -> None:
        """`device`: that of copies which have begun; None: `begin` tells when others have."""
        self.copies = copies  # without their values before `wait`
        self._event: wp.Event | None = None
        if device is not None:
            self.begin(device)

    def begin(self, device: wp.Device) -> None:
        """Wait, in `wait`, for what a device was told until now."""
        if device.is_cuda:
            self._event = device.stream.record_event()

    def wait(self) -> None:
        """Wait until all copies have their values; any thread may."""
        if (event := self._event) is not None:
            import warp as wp

            wp.synchronize_event(event)
            self._event = None

    def __del__(self) -> None:
        self.wait()  # else the memory would serve another array while it is filled


class Landing:
    """Memory of the host, page-locked where there is some, to which an array of a device will be copied."""

    def __init__(self, shape: tuple[int, ...], dtype: Any, *, page_locked: bool) -> None:
        dtype = np.dtype(dtype)
        size = math.prod(shape) * dtype.itemsize
        self._buffer = buffer = _pool.acquire(size) if page_locked and size else None
        if buffer is None:
            self.copy = np.empty(shape, dtype)
        else:
            self.copy = np.asarray(PooledBuffer(_pool, buffer, size, shape, dtype.str))

    def receive(self, array: wp.array | np.ndarray) -> None:
        """Begin to copy an array of this size; without page-locked memory it is there at once."""
        import warp as wp

        if isinstance(array, np.ndarray):
            self.copy[...] = array
        elif self._buffer is None:
            self.copy[...] = array.numpy()
        else:
            dtype: Any = array.dtype
            place = dict(ptr=self._buffer.ptr, shape=array.shape, dtype=dtype, device="cpu", copy=False, pinned=True)
            wp.copy(wp.array(**place), array)


def read_back(arrays: Mapping[str, wp.array]) -> dict[str, np.ndarray]:
    """Copy contiguous arrays of one device to the host, vectors as a last axis, structs as records.

    CPU arrays are not copied: the results share their memory.
    """
    arrival = start_to_read_back(arrays)
    arrival.wait()
    return arrival.copies


def start_to_read_back(arrays: Mapping[str, wp.array]) -> Arrival:
    """Do as `read_back`, without waiting for the device."""
    import warp as wp

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
    return Arrival(copies, device)


def device_of(name: str) -> wp.Device:
    """Return Warp's device of a name."""
    import warp as wp

    return wp.get_device(name)
