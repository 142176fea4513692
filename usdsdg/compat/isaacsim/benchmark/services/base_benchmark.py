"""`isaacsim.benchmark.services.base_benchmark`: a benchmark in phases."""

from __future__ import annotations

import tempfile
import time
import unittest
from typing import Any

from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.benchmark.services.datarecorders import (
    InputContext,
    MeasurementDataRecorder,
    MeasurementDataRecorderRegistry,
    RuntimeRecorder,
)
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.frametime_recorder import FrametimeRecorder
from usdsdg.compat.isaacsim.benchmark.services.datarecorders.rtf_stability import RtfStabilityRecorder
from usdsdg.compat.isaacsim.benchmark.services.metrics.backend import MetricsBackend
from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import (
    AnyMetadata,
    Measurement,
    StringMetadata,
    TestPhase,
)
from usdsdg.compat.isaacsim.benchmark.services.metrics.report import Report
from usdsdg.compat.isaacsim.benchmark.services.utils import get_kit_version_branch
from usdsdg.errors import UsdsdgError, warn_once
from usdsdg.session import stage_context
from usdsdg.session.settings.store import get_settings

DEFAULT_RECORDERS = ["app_frametime", "physics_frametime", "runtime", "memory", "cpu_continuous", "hardware"]

SETTINGS = "/exts/isaacsim.benchmark.services/metrics"
# Recorders that `start_recording_frametime` switches.
FRAMETIME_RECORDERS = (FrametimeRecorder, RtfStabilityRecorder)


def set_sync_mode() -> None:
    """Do nothing: stages and materials are always loaded before anything is rendered."""


class _Phases:
    """The phases of a benchmark and their recorders, for scripts and for asynchronous tests."""

    def _begin(
        self,
        benchmark_name: str,
        backend_type: str,
        report_generation: bool,
        workflow_metadata: dict[str, Any] | None,
        recorders: list[str] | None,
    ) -> None:
        version = get_kit_version_branch()[0]
        self.benchmark_name, self.report = benchmark_name, report_generation
        self.benchmark_start_time = time.time()
        self.context: InputContext = InputContext(f"{benchmark_name}_{version}", version, "benchmark")
        self.recorders = _made(DEFAULT_RECORDERS if recorders is None else recorders, self.context)
        self._active: list[MeasurementDataRecorder] = []
        self._phases: list[TestPhase] = []
        self._backend = MetricsBackend.get_instance(backend_type)
        self._metadata: list[AnyMetadata] = [StringMetadata("workflow_name", benchmark_name)]
        if workflow_metadata:
            self._metadata += TestPhase.metadata_from_dict({"metadata": workflow_metadata.get("metadata", ())})

    @property
    def assets_root_path(self) -> str | None:
        """The folder or URL of assets, None where there is none."""
        try:
            return stage_context.assets_root()
        except UsdsdgError as error:
            warn_once(f"assets_root_path is None: {error}")
            return None

    def _start(self, phase: str, frametime: bool, runtime: bool) -> None:
        if self._active:
            warn_once(f"set_phase({phase!r}): the phase before was not stored; call store_measurements at its end")
        self.context.phase = phase
        self._active = [each for each in self.recorders if _is_wanted(each, frametime, runtime)]
        for recorder in self._active:
            start = getattr(recorder, "start_collecting", None)
            if start is not None:
                start()

    def _store(self) -> None:
        for recorder in self._active:
            stop = getattr(recorder, "stop_collecting", None)
            if stop is not None:
                stop()
        found = [recorder.get_data() for recorder in self._active]
        phase = self._new_phase(self.context.phase)
        phase.measurements = [each for data in found for each in data.measurements]
        phase.metadata[:0] = [each for data in found for each in data.metadata]
        self._active = []

    def _new_phase(self, name: str) -> TestPhase:
        phase = TestPhase(name, metadata=[*self._metadata, StringMetadata("phase", name)])
        self._phases.append(phase)
        return phase

    def _store_own(self, phase_name: str, measurement: Measurement) -> None:
        known = next((phase for phase in self._phases if phase.phase_name == phase_name), None)
        (known or self._new_phase(phase_name)).measurements.append(measurement)

    def _finish(self) -> None:
        if not self._phases:
            warn_once(f"{self.benchmark_name}: no phase was stored, so nothing is written; call store_measurements")
            return
        report = Report()
        for phase in self._phases:
            self._backend.add_metrics(phase)
            report.add_metric_phase(phase)
        settings = get_settings()
        folder = settings.get_as_string(f"{SETTINGS}/metrics_output_folder") or tempfile.gettempdir()
        self._backend.finalize(folder, settings.get_as_bool(f"{SETTINGS}/randomize_filename_prefix"))
        if self.report:
            report.create_report()
        self.recorders = []


class BaseIsaacBenchmark(_Phases):
    """The benchmark of a script: set_phase, run, store_measurements, for each phase; at last stop.

    Args:
        benchmark_name: Of the report and its file.
        backend_type: "OmniPerfKPIFile", "OsmoKPIFile", "JSONFileMetrics" or "LocalLogMetrics".
        report_generation: Whether `stop` prints a summary.
        workflow_metadata: {"metadata": [{"name": ..., "data": ...}, ...]}, which every phase gets.
        recorders: Names of recorders; None for DEFAULT_RECORDERS. Unknown names are left out, with a warning.
        gpu_frametime: Of Isaac Sim 5; ignored, with a warning.
    """

    def __init__(
        self,
        benchmark_name: str = "BaseIsaacBenchmark",
        backend_type: str = "OmniPerfKPIFile",
        report_generation: bool = True,
        workflow_metadata: dict[str, Any] | None = None,
        recorders: list[str] | None = None,
        *,
        gpu_frametime: bool = False,
    ) -> None:
        if gpu_frametime:
            warn_once("BaseIsaacBenchmark: gpu_frametime is ignored; times of app updates include those of the GPU")
        self._begin(benchmark_name, backend_type, report_generation, workflow_metadata, recorders)

    def set_phase(
        self,
        phase: str,
        start_recording_frametime: bool = True,
        start_recording_runtime: bool = True,
        warmup_frames: int = 0,
    ) -> None:
        """Begin a phase and its recorders, after `warmup_frames` app updates."""
        self.run_warmup(warmup_frames)
        self._start(phase, start_recording_frametime, start_recording_runtime)

    def run_warmup(self, n_frames: int) -> None:
        """Run app updates that are not recorded."""
        for _ in range(n_frames):
            get_app().update()

    def store_measurements(self) -> None:
        """End the phase and keep what was recorded."""
        self._store()

    def store_custom_measurement(self, phase_name: str, custom_measurement: Measurement) -> None:
        """Add a measurement to a phase; a phase of a new name is made."""
        self._store_own(phase_name, custom_measurement)

    def fully_load_stage(self, usd_path: str) -> None:
        """Open a stage and run one app update.

        Raises:
            AssetError: the file is missing or cannot be read.
        """
        stage_context.open_stage(usd_path)
        get_app().update()

    def stop(self) -> None:
        """Write the measurements and print the summary."""
        self._finish()


class BaseIsaacBenchmarkAsync(_Phases, unittest.IsolatedAsyncioTestCase):
    """The benchmark of an asynchronous test case: its methods are those of BaseIsaacBenchmark, awaited."""

    async def setUp(  # type: ignore[override]
        self,
        backend_type: str = "JSONFileMetrics",
        report_generation: bool = False,
        workflow_metadata: dict[str, Any] | None = None,
        recorders: list[str] | None = None,
    ) -> None:
        """Open a new stage and begin a benchmark with the name of the test."""
        stage_context.new_stage()
        await get_app().next_update_async()
        name = self._testMethodName
        self._begin(name, backend_type, report_generation, workflow_metadata, recorders)

    async def set_phase(
        self,
        phase: str,
        start_recording_frametime: bool = True,
        start_recording_runtime: bool = True,
        warmup_frames: int = 0,
    ) -> None:
        """Begin a phase and its recorders, after `warmup_frames` app updates."""
        await self.run_warmup(warmup_frames)
        self._start(phase, start_recording_frametime, start_recording_runtime)

    async def run_warmup(self, n_frames: int) -> None:
        """Wait for app updates that are not recorded."""
        for _ in range(n_frames):
            await get_app().next_update_async()

    async def store_measurements(self) -> None:
        """End the phase and keep what was recorded."""
        self._store()

    async def store_custom_measurement(self, phase_name: str, custom_measurement: Measurement) -> None:
        """Add a measurement to a phase; a phase of a new name is made."""
        self._store_own(phase_name, custom_measurement)

    async def fully_load_stage(self, usd_path: str) -> None:
        """Open a stage and wait for one app update."""
        stage_context.open_stage(usd_path)
        await get_app().next_update_async()

    async def tearDown(self) -> None:  # type: ignore[override]
        """Write the measurements and print the summary."""
        self._finish()


def _made(names: list[str], context: InputContext) -> list[MeasurementDataRecorder]:
    unknown = [name for name in names if MeasurementDataRecorderRegistry.get(name) is None]
    if unknown:
        known = ", ".join(MeasurementDataRecorderRegistry.list_available())
        warn_once(f"recorders: there is no {', '.join(unknown)}, so it is left out; there are {known}")
    return [each(context) for each in MeasurementDataRecorderRegistry.get_many(names)]


def _is_wanted(recorder: MeasurementDataRecorder, frametime: bool, runtime: bool) -> bool:
    if isinstance(recorder, FRAMETIME_RECORDERS):
        return frametime
    return runtime or not isinstance(recorder, RuntimeRecorder)
