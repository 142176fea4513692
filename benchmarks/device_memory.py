"""The most device memory that a benchmark has used."""

from __future__ import annotations

import warp as wp


class PeakMemory:
    """Memory of the first CUDA device since the process began, by Warp's pool and by the driver."""

    def __init__(self) -> None:
        self._device = wp.get_device("cuda:0") if wp.is_cuda_available() else None

    def described(self) -> str:
        """Return the peak of Warp's pool, and what the driver says is in use now, by all processes."""
        if self._device is None:
            return "device memory: no CUDA device"
        used = self._device.total_memory - self._device.free_memory
        high = wp.get_mempool_used_mem_high(self._device)
        return f"device memory: {high / 1e9:.2f} GB at most in Warp's pool, {used / 1e9:.2f} GB in use on the device"
