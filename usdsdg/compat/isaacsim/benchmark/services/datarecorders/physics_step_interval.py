"""`isaacsim.benchmark.services.datarecorders.physics_step_interval`: the time from one physics step to the next."""

from __future__ import annotations

from collections.abc import Callable

from usdsdg.compat.isaacsim.benchmark.services.datarecorders.frametime_recorder import FrametimeRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.interface import MeasurementDataRecorderRegistry
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.stats_utils import Stats
from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import Measurement, SingleMeasurement
from usdsdg.session import engines
from usdsdg.session.settings.store import get_settings

EXPORT_SAMPLES = "/exts/isaacsim.benchmark.services/physics_step_interval/export_samples"


@MeasurementDataRecorderRegistry.register("physics_step_interval")
class PhysicsStepIntervalRecorder(FrametimeRecorder):
    """Records the wall-clock time between the ends of physics steps."""

    kind = "Physics_Step"

    def subscribe(self) -> Callable[[], object]:
        """Take a sample after every physics step."""
        return engines.subscribe_step(lambda _dt: self.tick())

    def measurements(self, stats: Stats) -> list[Measurement]:
        """Return the measurements of a phase."""
        self.exports_samples = get_settings().get_as_bool(EXPORT_SAMPLES)
        return [
            *super().measurements(stats),
            SingleMeasurement("P99 Physics_Step Frametime", stats.p99, "ms"),
            SingleMeasurement("Physics Step Count", self.sample_count, ""),
        ]
