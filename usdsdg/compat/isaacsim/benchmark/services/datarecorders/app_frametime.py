"""`isaacsim.benchmark.services.datarecorders.app_frametime`: the time between frames of the application."""

from __future__ import annotations

import time
from collections.abc import Callable

from usdsdg.app.app import get_app
from usdsdg.app.frame_loop import get_orchestrator
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.frametime_recorder import FrametimeRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.interface import MeasurementDataRecorderRegistry
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.stats_utils import Stats
from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import Measurement, SingleMeasurement
from usdsdg.session.timeline import get_timeline


def subscribe_frames(listener: Callable[[], None]) -> Callable[[], None]:
    """Call `listener()` after every app update and every frame that `orchestrator.step` captures outside of one.

    In Omniverse a step runs app updates; here it does not, so both count as a frame. Returns the unsubscriber.
    """
    app = get_app()
    seen = app.get_update_number()

    def on_update(_dt: float) -> None:
        nonlocal seen
        seen = app.get_update_number()
        listener()

    def on_captured() -> None:
        # A capture inside of an update, as on play, is followed by `on_update`.
        if app.get_update_number() == seen:
            listener()

    ends = (app.subscribe_update(on_update), get_orchestrator().on_captured(on_captured))

    def unsubscribe() -> None:
        for end in ends:
            end()

    return unsubscribe


@MeasurementDataRecorderRegistry.register("app_frametime")
class AppFrametimeRecorder(FrametimeRecorder):
    """Records the time between frames, their rate, and the time of the timeline per time of the clock."""

    kind = "App_Update"

    def start_collecting(self) -> None:
        """Begin a phase without samples."""
        super().start_collecting()
        self._started = self._last
        self._timeline_start = get_timeline().get_elapsed_time()
        self._real_time_factor = 0.0

    def stop_collecting(self) -> None:
        """End the phase."""
        super().stop_collecting()
        elapsed = time.perf_counter() - self._started
        if elapsed > 0.0:
            self._real_time_factor = (get_timeline().get_elapsed_time() - self._timeline_start) / elapsed

    def subscribe(self) -> Callable[[], object]:
        """Take a sample after every frame."""
        return subscribe_frames(self.tick)

    def measurements(self, stats: Stats) -> list[Measurement]:
        """Return the measurements of a phase."""
        rate = round(1000.0 / stats.mean, 3) if stats.mean > 0.0 else 0.0
        found = [
            *super().measurements(stats),
            SingleMeasurement("Mean FPS", rate, "FPS"),
            SingleMeasurement("Num App Updates", self.sample_count, ""),
        ]
        if self._real_time_factor > 0.0:
            found.append(SingleMeasurement("Real Time Factor", round(self._real_time_factor, 3), ""))
        return found
