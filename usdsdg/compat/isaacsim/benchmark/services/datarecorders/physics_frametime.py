"""`isaacsim.benchmark.services.datarecorders.physics_frametime`: how long a physics step takes."""

from __future__ import annotations

from collections.abc import Callable

from usdsdg.compat.isaacsim.benchmark.services.datarecorders.frametime_recorder import FrametimeRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.interface import MeasurementDataRecorderRegistry
from usdsdg.compat.omni.physics.core import PhysicsProfileStats, get_physics_benchmarks_interface


@MeasurementDataRecorderRegistry.register("physics_frametime")
class PhysicsFrametimeRecorder(FrametimeRecorder):
    """Records the time of each physics step, from reading the stage to writing it."""

    kind = "Physics"

    def subscribe(self) -> Callable[[], object]:
        """Take a sample after every physics step."""
        return get_physics_benchmarks_interface().subscribe_profile_stats_events(self._on_stats).unsubscribe

    def _on_stats(self, stats: list[PhysicsProfileStats]) -> None:
        for each in stats:
            self.add(each.ms)
