"""Recorders of durations: samples in milliseconds between `start_collecting` and `stop_collecting`."""

from __future__ import annotations

import time
from collections.abc import Callable

from usdsdg.compat.isaacsim.benchmark.services.datarecorders.interface import (
    InputContext,
    MeasurementData,
    MeasurementDataRecorder,
)
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.stats_utils import Stats
from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import (
    ListMeasurement,
    Measurement,
    SingleMeasurement,
)


class FrametimeRecorder(MeasurementDataRecorder):
    """Collects samples; `kind` is the word in the names of its measurements ("Mean <kind> Frametime").

    The first sample of a phase is dropped: it includes what the phase began with, such as compilation.
    """

    kind = ""
    exports_samples = True

    def __init__(self, context: InputContext | None = None) -> None:
        super().__init__(context)
        self._samples: list[float] = []
        self._phase: str | None = None
        self._last = 0.0
        self._end: Callable[[], object] | None = None

    def start_collecting(self) -> None:
        """Begin a phase without samples."""
        self._phase = self.context.phase if self.context else None
        self._samples = []
        self._last = time.perf_counter()
        self._end = self.subscribe()

    def stop_collecting(self) -> None:
        """End the phase."""
        if self._end is not None:
            self._end()
            self._end = None
        del self._samples[:1]

    def subscribe(self) -> Callable[[], object]:
        """Call `add` or `tick` whenever there is a sample, and return what ends that."""
        raise NotImplementedError

    def add(self, milliseconds: float) -> None:
        """Add a duration."""
        self._samples.append(round(milliseconds, 6))

    def tick(self) -> None:
        """Add the wall-clock time since the last call, or since the start."""
        now = time.perf_counter()
        self.add((now - self._last) * 1000.0)
        self._last = now

    @property
    def samples(self) -> list[float]:
        """The durations of the phase [ms]."""
        return self._samples

    @property
    def sample_count(self) -> int:
        """Number of samples of the phase."""
        return len(self._samples)

    def get_data(self) -> MeasurementData:
        """Return the statistics of the phase; nothing without samples or in another phase."""
        if not self._samples or (self.context and self.context.phase != self._phase):
            return MeasurementData()
        return MeasurementData(measurements=self.measurements(Stats.from_samples(self._samples, trim_outliers=False)))

    def measurements(self, stats: Stats) -> list[Measurement]:
        """Return the measurements of a phase."""
        found: list[Measurement] = [
            SingleMeasurement(f"{word} {self.kind} Frametime", value, "ms")
            for word, value in (("Mean", stats.mean), ("Stdev", stats.stdev), ("Min", stats.min), ("Max", stats.max))
        ]
        if self.exports_samples:
            found.append(ListMeasurement(f"{self.kind} Frametime Samples", list(self._samples)))
        return found
