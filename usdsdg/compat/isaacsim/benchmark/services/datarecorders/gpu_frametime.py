"""`isaacsim.benchmark.services.datarecorders.gpu_frametime`: time on the GPU, which is not measured."""

from __future__ import annotations

from collections.abc import Callable

from usdsdg.compat.isaacsim.benchmark.services.datarecorders.frametime_recorder import FrametimeRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.interface import (
    InputContext,
    MeasurementDataRecorderRegistry,
)
from usdsdg.errors import warn_once


@MeasurementDataRecorderRegistry.register("gpu_frametime")
class GPUFrametimeRecorder(FrametimeRecorder):
    """Has no samples: the renderer waits for the GPU in every frame, whose time app_frametime has."""

    kind = "GPU"

    def __init__(self, context: InputContext | None = None, enable_multi_gpu: bool = False) -> None:
        super().__init__(context)
        self.enable_multi_gpu = enable_multi_gpu

    def subscribe(self) -> Callable[[], object]:
        """Warn once that there are no samples."""
        warn_once(
            "gpu_frametime: the time on the GPU is not measured apart; render_frametime and app_frametime have the "
            "time of whole frames"
        )
        return lambda: None
