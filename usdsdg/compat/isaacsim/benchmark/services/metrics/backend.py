"""`isaacsim.benchmark.services.metrics.backend`: what the measurements of all phases are written to."""

from __future__ import annotations

import copy
import json
import tempfile
from datetime import datetime
from pathlib import Path
from typing import Any

from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import (
    SingleMeasurement,
    TestPhase,
    TestPhaseEncoder,
)
from usdsdg.compat.isaacsim.benchmark.services.utils import get_kit_version_branch, set_up_logging
from usdsdg.errors import Unsupported

_log = set_up_logging(__name__)


class MetricsBackendInterface:
    """Takes phases with `add_metrics` and writes them with `finalize`."""

    def __init__(self) -> None:
        self.phases: list[TestPhase] = []

    def add_metrics(self, test_phase: TestPhase) -> None:
        """Keep a phase until `finalize`."""
        self.phases.append(test_phase)

    def finalize(self, metrics_output_folder: str, randomize_filename_prefix: bool = False, **kwargs: Any) -> None:
        """Write the phases below `metrics_output_folder`, under a name of its own if `randomize_filename_prefix`."""


class LocalLogMetrics(MetricsBackendInterface):
    """Logs every phase and writes no file."""

    def add_metrics(self, test_phase: TestPhase) -> None:
        _log.info("%s", test_phase)


class JSONFileMetrics(MetricsBackendInterface):
    """Writes everything, samples too, as a list of phases in `metrics_<benchmark>.json`."""

    def finalize(self, metrics_output_folder: str, randomize_filename_prefix: bool = False, **kwargs: Any) -> None:
        phases = copy.deepcopy(self.phases)
        for phase in phases:
            prefix = f"{phase.get_metadata_field('workflow_name')} {phase.get_metadata_field('phase')} "
            for entry in (*phase.measurements, *phase.metadata):
                entry.name = prefix + entry.name
        if phases:
            name = f"metrics_{_benchmark_of(self.phases)}"
            _write(metrics_output_folder, name, phases, randomize_filename_prefix)
        self.phases.clear()


class OsmoKPIFile(MetricsBackendInterface):
    """Writes metadata and single measurements of each phase as one object in `kpis_<benchmark>_<phase>.json`."""

    def finalize(self, metrics_output_folder: str, randomize_filename_prefix: bool = False, **kwargs: Any) -> None:
        for phase in self.phases:
            name = f"kpis_{_benchmark_of([phase])}_{phase.get_metadata_field('phase')}"
            _write(metrics_output_folder, name, _values(phase), randomize_filename_prefix)


class OmniPerfKPIFile(MetricsBackendInterface):
    """Writes metadata and single measurements as one object for each phase in `kpis_<benchmark>.json`."""

    def finalize(self, metrics_output_folder: str, randomize_filename_prefix: bool = False, **kwargs: Any) -> None:
        if not self.phases:
            return
        version, branch, full = get_kit_version_branch()
        document: dict[str, Any] = {
            "App Info": [version, "", branch],
            "timestamp": datetime.now().isoformat(),
            "Kit": full,
        }
        document |= {phase.get_metadata_field("phase"): _values(phase) for phase in self.phases}
        _write(metrics_output_folder, f"kpis_{_benchmark_of(self.phases)}", document, randomize_filename_prefix)


_BACKENDS = {each.__name__: each for each in (LocalLogMetrics, JSONFileMetrics, OsmoKPIFile, OmniPerfKPIFile)}


class MetricsBackend:
    """The backends by name."""

    @classmethod
    def get_instance(cls, instance_type: str | None = None) -> MetricsBackendInterface:
        """Return a new backend; JSONFileMetrics for None and names that are not known.

        Raises:
            Unsupported: KitGenericTelemetry, since nothing is sent anywhere.
        """
        if instance_type == "KitGenericTelemetry":
            raise Unsupported(
                "KitGenericTelemetry: there is no telemetry; use one of " + ", ".join(map(repr, _BACKENDS))
            )
        return _BACKENDS.get(instance_type or "", JSONFileMetrics)()


def _benchmark_of(phases: list[TestPhase]) -> str:
    return str(phases[-1].get_metadata_field("workflow_name"))


def _values(phase: TestPhase) -> dict[str, Any]:
    """Return metadata and single measurements by name."""
    singles = [each for each in phase.measurements if isinstance(each, SingleMeasurement)]
    return {each.name: each.data for each in phase.metadata} | {each.name: each.value for each in singles}


def _write(folder: str, name: str, content: Any, unique: bool) -> None:
    Path(folder).mkdir(parents=True, exist_ok=True)
    if unique:
        handle, path = tempfile.mkstemp(dir=folder, prefix=name, suffix=".json", text=True)
        with open(handle, "w", encoding="utf-8") as file:
            json.dump(content, file, indent=4, cls=TestPhaseEncoder)
    else:
        path = str(Path(folder) / f"{name}.json")
        Path(path).write_text(json.dumps(content, indent=4, cls=TestPhaseEncoder), encoding="utf-8")
    print(f"Metrics of the benchmark: {path}")
