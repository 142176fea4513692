"""`isaacsim.benchmark.services.datarecorders.rtf_stability`: how evenly simulated time follows the clock."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import groupby

from usdsdg.compat.isaacsim.benchmark.services.datarecorders.app_frametime import subscribe_frames
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.interface import (
    InputContext,
    MeasurementData,
    MeasurementDataRecorder,
    MeasurementDataRecorderRegistry,
)
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.stats_utils import Stats
from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import (
    ListMeasurement,
    Measurement,
    SingleMeasurement,
)
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline

WINDOW = "/exts/isaacsim.benchmark.services/rtf_stability/window_wall_ms"
EXPORT_SAMPLES = "/exts/isaacsim.benchmark.services/rtf_stability/export_window_samples"
DEFAULT_WINDOW = 100.0
TIGHT, LOOSE = 0.01, 0.10


@MeasurementDataRecorderRegistry.register("rtf_stability")
class RtfStabilityRecorder(MeasurementDataRecorder):
    """Records the real-time factor, simulated seconds per second of the clock, of windows of the clock.

    The setting `window_wall_ms` is the least length of a window [ms].
    """

    def __init__(self, context: InputContext | None = None) -> None:
        super().__init__(context)
        self._factors: list[float] = []
        self._phase: str | None = None
        self._end: Callable[[], object] | None = None

    def start_collecting(self) -> None:
        """Begin a phase without windows."""
        self._phase = self.context.phase if self.context else None
        self._factors = []
        self._window = (get_settings().get_as_float(WINDOW) or DEFAULT_WINDOW) / 1000.0
        self._last = time.perf_counter(), get_timeline().get_elapsed_time()
        self._end = subscribe_frames(lambda: self._close_window(self._window))

    def stop_collecting(self) -> None:
        """End the phase, and its last window."""
        if self._end is not None:
            self._end()
            self._end = None
        self._close_window(1e-6)

    def _close_window(self, least: float) -> None:
        now = time.perf_counter(), get_timeline().get_elapsed_time()
        if now[0] - self._last[0] >= least:
            self._factors.append(round((now[1] - self._last[1]) / (now[0] - self._last[0]), 6))
            self._last = now

    def get_data(self) -> MeasurementData:
        """Return mean, spread, and how many windows are near the mean; nothing without windows or in another phase."""
        factors = self._factors
        if not factors or (self.context and self.context.phase != self._phase):
            return MeasurementData()
        stats = Stats.from_samples(factors, trim_outliers=False)
        off = [abs(factor - stats.mean) for factor in factors]
        streak = max((len(list(run)) for outside, run in groupby(off, lambda each: each > TIGHT) if outside), default=0)
        share = {band: round(100.0 * sum(each <= band for each in off) / len(off), 2) for band in (TIGHT, LOOSE)}
        found: list[Measurement] = [
            SingleMeasurement("Mean Windowed RTF", stats.mean, ""),
            SingleMeasurement("Stdev Windowed RTF", stats.stdev, ""),
            SingleMeasurement("Windowed RTF Sample Count", len(factors), ""),
            SingleMeasurement("Max Abs Windowed RTF Deviation from Mean", round(max(off), 6), ""),
            SingleMeasurement("Pct Windowed RTF Within 0.01 of Mean RTF", share[TIGHT], "%"),
            SingleMeasurement("Pct Windowed RTF Within 0.10 of Mean RTF", share[LOOSE], "%"),
            SingleMeasurement("Max Consecutive Windows Outside 0.01 Band of Mean RTF", streak, "windows"),
        ]
        if get_settings().get_as_bool(EXPORT_SAMPLES):
            found.append(ListMeasurement("Windowed RTF Samples", list(factors)))
        return MeasurementData(found)
