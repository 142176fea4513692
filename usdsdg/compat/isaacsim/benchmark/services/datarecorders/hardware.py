"""`isaacsim.benchmark.services.datarecorders.hardware`: the machine."""

from __future__ import annotations

import os

from usdsdg.compat.isaacsim.benchmark.services.datarecorders.interface import (
    MeasurementData,
    MeasurementDataRecorder,
    MeasurementDataRecorderRegistry,
)
from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import SingleMeasurement
from usdsdg.warp_start import quiet_warp


@MeasurementDataRecorderRegistry.register("hardware")
class HardwareSpecRecorder(MeasurementDataRecorder):
    """Records the number of CPU cores and the name of the first GPU, "Unknown" where there is none."""

    def get_data(self) -> MeasurementData:
        """Return both."""
        quiet_warp()
        import warp

        devices = [device.name for device in warp.get_cuda_devices()] if warp.is_cuda_available() else []
        return MeasurementData(
            [
                SingleMeasurement("num_cpus", os.cpu_count() or 1, ""),
                SingleMeasurement("gpu_device_name", devices[0] if devices else "Unknown", ""),
            ]
        )
