"""Staging buffers: host memory that is uploaded to a device in one copy."""

from typing import Any

import numpy as np
import warp as wp

# Bytes. Vector loads of BVH nodes and triangle blocks assume this alignment.
CACHE_LINE = 64


def aligned(shape: tuple[int, ...], dtype: Any) -> np.ndarray:
    """Return an uninitialized array that starts at a cache line."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    raw = np.empty(size + CACHE_LINE, np.uint8)
    start = -raw.ctypes.data % CACHE_LINE
    return raw[start : start + size].view(dtype).reshape(shape)


def shared(values: np.ndarray, dtype: Any) -> wp.array:
    """Wrap a contiguous array for CPU kernels, without a copy."""
    return wp.array(values, dtype=dtype, device="cpu", copy=False)


class StagingBuffer:
    """Bytes on the host and their copy on a device; on a CPU both are the same memory."""

    def __init__(self, size: int, device: str) -> None:
        self.host = aligned((size,), np.uint8)
        self._host = shared(self.host, wp.uint8)
        self._device = self._host if device == "cpu" else wp.empty(size, dtype=wp.uint8, device=device)

    def address(self, offset: int) -> int:
        """Return the device address of a byte."""
        return int(self._device.ptr) + offset

    def array(self, offset: int, count: int, dtype: Any) -> wp.array:
        """Return a view of `count` elements on the device; valid as long as the staging buffer lives."""
        return wp.array(ptr=self.address(offset), dtype=dtype, shape=(count,), device=self._device.device)

    def upload(self, size: int) -> None:
        """Copy the first `size` bytes to the device."""
        if self._device is not self._host:
            wp.copy(self._device, self._host, count=size)
