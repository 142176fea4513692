"""`isaacsim.benchmark.services.datarecorders`: what a benchmark can record."""

from usdsdg.compat.isaacsim.benchmark.services.datarecorders.app_frametime import AppFrametimeRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.cpu_continuous import CPUContinuousRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.gpu_frametime import GPUFrametimeRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.hardware import HardwareSpecRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.interface import (
    InputContext,
    MeasurementData,
    MeasurementDataRecorder,
    MeasurementDataRecorderRegistry,
)
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.memory import MemoryRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.physics_frametime import PhysicsFrametimeRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.physics_step_interval import PhysicsStepIntervalRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.render_frametime import RenderFrametimeRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.rtf_stability import RtfStabilityRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.runtime import RuntimeRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.stats_utils import Stats

__all__ = [
    "AppFrametimeRecorder", "CPUContinuousRecorder", "GPUFrametimeRecorder", "HardwareSpecRecorder", "InputContext",
    "MeasurementData", "MeasurementDataRecorder", "MeasurementDataRecorderRegistry", "MemoryRecorder",
    "PhysicsFrametimeRecorder", "PhysicsStepIntervalRecorder", "RenderFrametimeRecorder", "RtfStabilityRecorder",
    "RuntimeRecorder", "Stats",
]  # fmt: skip
