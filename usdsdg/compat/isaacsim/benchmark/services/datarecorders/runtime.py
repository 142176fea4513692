"""`isaacsim.benchmark.services.datarecorders.runtime`: the wall-clock time of a phase."""

from __future__ import annotations

import time

from usdsdg.compat.isaacsim.benchmark.services.datarecorders.interface import (
    InputContext,
    MeasurementData,
    MeasurementDataRecorder,
    MeasurementDataRecorderRegistry,
)
from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import SingleMeasurement


@MeasurementDataRecorderRegistry.register("runtime")
class RuntimeRecorder(MeasurementDataRecorder):
    """Records the time from `start_collecting` to `stop_collecting` [ms]."""

    def __init__(self, context: InputContext | None = None) -> None:
        super().__init__(context)
        self._elapsed: float | None = None
        self._phase: str | None = None

    def start_collecting(self) -> None:
        """Start the clock."""
        self._phase = self.context.phase if self.context else None
        self._start = time.perf_counter()

    def stop_collecting(self) -> None:
        """Stop the clock."""
        self._elapsed = (time.perf_counter() - self._start) * 1000.0

    def get_data(self) -> MeasurementData:
        """Return the time; nothing before `stop_collecting` or in another phase."""
        if self._elapsed is None or (self.context and self.context.phase != self._phase):
            return MeasurementData()
        return MeasurementData([SingleMeasurement("Runtime", round(self._elapsed, 3), "ms")])
