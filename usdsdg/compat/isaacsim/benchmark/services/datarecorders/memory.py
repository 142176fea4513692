"""`isaacsim.benchmark.services.datarecorders.memory`: the memory of the process and of its GPU."""

from __future__ import annotations

import sys

from usdsdg.compat.isaacsim.benchmark.services.datarecorders.interface import (
    MeasurementData,
    MeasurementDataRecorder,
    MeasurementDataRecorderRegistry,
)
from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import SingleMeasurement
from usdsdg.operating_system import memory_of_process

GIGABYTE = 1 << 30


@MeasurementDataRecorderRegistry.register("memory")
class MemoryRecorder(MeasurementDataRecorder):
    """Records memory at the end of a phase [GB of 2^30 bytes].

    RSS is what is in physical memory, VMS what is mapped, USS what no other process shares. The latter two are known on
    Linux only; elsewhere the largest RSS so far stands for RSS. GPU memory is that of Warp on the first CUDA device.
    """

    def get_data(self) -> MeasurementData:
        """Return what is known on this system."""
        found = {**_process_memory(), **_gpu_memory()}
        return MeasurementData([SingleMeasurement(name, round(n / GIGABYTE, 3), "GB") for name, n in found.items()])


def _process_memory() -> dict[str, int]:
    """Return bytes by name."""
    return {f"System Memory {name.upper()}": size for name, size in memory_of_process().items()}


def _gpu_memory() -> dict[str, int]:
    """Return bytes by name; nothing without a CUDA device, or before anything has been rendered."""
    if "warp" not in sys.modules:
        return {}
    import warp

    if not warp.is_cuda_available():
        return {}
    device = warp.get_device("cuda:0")
    return {
        "GPU Memory Tracked": warp.get_mempool_used_mem_current(device) if device.is_mempool_enabled else 0,
        "GPU Memory Dedicated": device.total_memory - device.free_memory,
    }
