"""`isaacsim.benchmark.services.datarecorders.cpu_continuous`: the CPU time that the process uses."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

from usdsdg.compat.isaacsim.benchmark.services.datarecorders.app_frametime import subscribe_frames
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.interface import (
    InputContext,
    MeasurementData,
    MeasurementDataRecorder,
    MeasurementDataRecorderRegistry,
)
from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import SingleMeasurement


@MeasurementDataRecorderRegistry.register("cpu_continuous")
class CPUContinuousRecorder(MeasurementDataRecorder):
    """Records CPU time per time of the clock [%] of every `sample_interval_frames` frames; 400 % is four cores."""

    def __init__(self, context: InputContext | None = None, sample_interval_frames: int = 10) -> None:
        super().__init__(context)
        self.sample_interval_frames = sample_interval_frames
        self._samples: list[float] = []
        self._phase: str | None = None
        self._end: Callable[[], object] | None = None

    def start_collecting(self) -> None:
        """Begin a phase without samples."""
        self._phase = self.context.phase if self.context else None
        self._samples, self._frames = [], 0
        self._last = time.process_time(), time.perf_counter()
        self._end = subscribe_frames(self._on_frame)

    def stop_collecting(self) -> None:
        """End the phase; one that is shorter than the interval has one sample, of all of it."""
        if self._end is not None:
            self._end()
            self._end = None
        if not self._samples:
            self._take()

    def _on_frame(self) -> None:
        self._frames += 1
        if self._frames % self.sample_interval_frames == 0:
            self._take()

    def _take(self) -> None:
        cpu, clock = time.process_time(), time.perf_counter()
        if clock > self._last[1]:
            self._samples.append(100.0 * (cpu - self._last[0]) / (clock - self._last[1]))
        self._last = cpu, clock

    def get_data(self) -> MeasurementData:
        """Return mean, extremes and spread; nothing without samples or in another phase."""
        if not self._samples or (self.context and self.context.phase != self._phase):
            return MeasurementData()
        spread = statistics.stdev(self._samples) if len(self._samples) > 1 else 0.0
        found = (
            ("Mean", statistics.mean(self._samples)), ("Max", max(self._samples)), ("Min", min(self._samples)),
            ("Stdev", spread),
        )  # fmt: skip
        return MeasurementData([SingleMeasurement(f"{word} CPU Usage", round(value, 2), "%") for word, value in found])
