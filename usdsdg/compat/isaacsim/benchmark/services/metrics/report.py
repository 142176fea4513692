"""`isaacsim.benchmark.services.metrics.report`: the summary that a benchmark prints at its end."""

from __future__ import annotations

import textwrap

from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import Measurement, SingleMeasurement, TestPhase

# Characters between the borders of the box.
WIDTH = 50
# Measurements of the machine: printed once, among the metadata.
_OF_THE_MACHINE = ("num_cpus", "gpu_device_name")
# Measurements that are only in the files.
_NOT_PRINTED = ("GPU Memory Dedicated",)
_STATISTICS = ("Mean", "Stdev", "Min", "Max")


class Report:
    """Collects phases and prints them as one box of text."""

    def __init__(self) -> None:
        self._phases: list[TestPhase] = []

    def add_metric_phase(self, test_phase: TestPhase) -> None:
        """Add a phase; it must have the metadata "phase"."""
        self._phases.append(test_phase)

    def create_report(self) -> None:
        """Print metadata, then for each phase: run time, own measurements, memory, CPU use and frame times."""
        ruler = "|" + "-" * (WIDTH + 2) + "|"
        lines = [ruler, f"| {'Summary Report':^{WIDTH}} |", ruler, *self._metadata()]
        for phase in self._phases:
            lines += [ruler, *_phase_lines(phase)]
        print("\n".join([*lines, ruler]))

    def _metadata(self) -> list[str]:
        if not self._phases:
            return []
        # The last entry is the name of the phase.
        entries = [f"{entry.name}: {entry.data}" for entry in self._phases[0].metadata[:-1]]
        for phase in self._phases:
            for each in _singles(phase):
                if each.name in _OF_THE_MACHINE and _text(each) not in entries:
                    entries.append(_text(each))
        return [line for entry in entries for line in _boxed(entry)]


def _phase_lines(phase: TestPhase) -> list[str]:
    singles = [each for each in _singles(phase) if each.name not in (*_OF_THE_MACHINE, *_NOT_PRINTED)]
    frame_times = [each for each in singles if _is_statistic(each.name, " Frametime")]
    cpu = [each for each in singles if _is_statistic(each.name, " CPU Usage")]
    others = [each for each in singles if each not in (*frame_times, *cpu)]
    run_time = [each for each in others if "Runtime" in each.name]
    memory = [each for each in others if "Memory" in each.name]
    own = [each for each in others if each not in (*run_time, *memory)]

    lines = _boxed(f"Phase: {phase.get_metadata_field('phase')}")
    listed = [*run_time, *sorted(own, key=_group_and_name), *sorted(memory, key=lambda each: each.name)]
    for each in listed:
        lines += _boxed(_text(each))
    if cpu:
        lines += _table("CPU (%)", {"Process": cpu})
    if frame_times:
        rows: dict[str, list[SingleMeasurement]] = {}
        for each in frame_times:
            rows.setdefault(each.name.split(" ")[1], []).append(each)
        lines += _table("Frametimes (ms)", rows)
    return lines


def _singles(phase: TestPhase) -> list[SingleMeasurement]:
    entries: list[Measurement] = phase.measurements
    return [each for each in entries if isinstance(each, SingleMeasurement)]


def _is_statistic(name: str, ending: str) -> bool:
    """Return whether a name is "Mean <one word><ending>" or that of another statistic."""
    return name.endswith(ending) and name.startswith(_STATISTICS)


def _group_and_name(measurement: SingleMeasurement) -> tuple[str, str]:
    return measurement.name.split(" ")[0], measurement.name


def _text(measurement: SingleMeasurement) -> str:
    return f"{measurement.name}: {measurement.value} {measurement.unit}".rstrip()


def _boxed(text: str) -> list[str]:
    rows = textwrap.wrap(text, width=WIDTH, break_on_hyphens=False) or [""]
    return [f"| {row:<{WIDTH}} |" for row in rows]


def _table(title: str, rows: dict[str, list[SingleMeasurement]]) -> list[str]:
    """Return lines with mean, standard deviation, minimum and maximum of each row."""
    lines = [f"{title + ':':<16}{'mean':>7} | {'stdev':>6} | {'min':>6} | {'max':>6}"]
    for name, entries in rows.items():
        values = {entry.name.split(" ")[0]: f"{float(entry.value):.2f}" for entry in entries}
        mean, stdev, least, most = (values.get(statistic, "-") for statistic in _STATISTICS)
        lines.append(f"{name:<16}{mean:>7} | {stdev:>6} | {least:>6} | {most:>6}")
    return [f"| {line:<{WIDTH}} |" for line in lines]
