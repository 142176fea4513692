"""Memory that the host writes and kernels read."""

from typing import Any

import numpy as np
import warp as wp

# Bytes of a cache line: vector loads of nodes and blocks assume this alignment.
LINE = 64


def aligned(shape: tuple[int, ...], dtype: Any) -> np.ndarray:
    """An uninitialized array whose first element starts a cache line."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    raw = np.empty(size + LINE, np.uint8)
    start = -raw.ctypes.data % LINE
    return raw[start : start + size].view(dtype).reshape(shape)


def shared(values: np.ndarray, dtype: Any) -> wp.array:
    """A contiguous array as kernels on a CPU read and write it, where it lies."""
    return wp.array(values, dtype=dtype, device="cpu", copy=False)


class Mirror:
    """Bytes that are written on the host and sent to a device in one piece; for a CPU both are one."""

    def __init__(self, size: int, device: str) -> None:
        self.host = aligned((size,), np.uint8)
        self._host = shared(self.host, wp.uint8)
        self._device = self._host if device == "cpu" else wp.empty(size, dtype=wp.uint8, device=device)

    def address(self, offset: int) -> int:
        """Where a byte is on the device."""
        return int(self._device.ptr) + offset

    def array(self, offset: int, count: int, dtype: Any) -> wp.array:
        """So many elements as kernels on the device read them; valid while the mirror is."""
        return wp.array(ptr=self.address(offset), dtype=dtype, shape=(count,), device=self._device.device)

    def send(self, size: int) -> None:
        """Bring the first bytes up to date on the device. What is written later is not sent with them."""
        if self._device is not self._host:
            wp.copy(self._device, self._host, count=size)
