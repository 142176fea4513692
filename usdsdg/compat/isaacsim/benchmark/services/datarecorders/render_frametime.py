"""`isaacsim.benchmark.services.datarecorders.render_frametime`: the time between captured frames."""

from __future__ import annotations

from collections.abc import Callable

from usdsdg.app.frame_loop import get_orchestrator
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.frametime_recorder import FrametimeRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.interface import MeasurementDataRecorderRegistry
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.stats_utils import Stats
from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import Measurement, SingleMeasurement


@MeasurementDataRecorderRegistry.register("render_frametime")
class RenderFrametimeRecorder(FrametimeRecorder):
    """Records the time between captured frames: there is no render thread, and only captures render."""

    kind = "Render"
    exports_samples = False

    def subscribe(self) -> Callable[[], object]:
        """Take a sample after every captured frame."""
        return get_orchestrator().on_captured(self.tick)

    def measurements(self, stats: Stats) -> list[Measurement]:
        """Return the measurements of a phase."""
        rate = [SingleMeasurement("Render Thread FPS", round(1000.0 / stats.mean, 3), "FPS")] if stats.mean > 0 else []
        return [*super().measurements(stats), *rate]
