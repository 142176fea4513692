"""Plots of the performance page, drawn from what benchmarks have written to benchmarks/results."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path

from docs.site.repository_pages import ROOT

RESULTS = ROOT / "benchmarks" / "results"
NUMBER = re.compile(r"([\d.]+) (ms|Mpixel|s\b|pictures/s)")
# Readable on light and on dark pages.
BAR, TEXT = "#e8743b", "#8a8f98"


@dataclass(frozen=True)
class Result:
    """What one benchmark has measured.

    Attributes:
        machine: Processor, threads, load of the last minute and date, as one line.
        rows: What was measured, and the number.
        unit: Of all numbers.
    """

    machine: str
    rows: tuple[tuple[str, float], ...]
    unit: str


def result(name: str) -> Result:
    """Read the result of a benchmark; rows in other units than the first are left out."""
    head, *lines = [json.loads(line) for line in (RESULTS / f"{name}.jsonl").read_text(encoding="utf-8").splitlines()]
    rows, unit = [], ""
    for line in lines:
        if found := NUMBER.match(line["ours"]):
            unit = unit or found[2]
            if unit == found[2]:
                rows.append((line["what"], float(found[1])))
    machine = f"{head['machine']}, {head['threads']} threads, load {head['load']}, {head['date']}"
    return Result(machine, tuple(rows), unit)


def draw(name: str, file: Path) -> None:
    """Draw the rows of a result as bars on a logarithmic axis, with the numbers beside them."""
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot

    measured = result(name)
    names, numbers = zip(*measured.rows, strict=True)
    with pyplot.rc_context({"svg.hashsalt": name, "font.size": 9, "svg.fonttype": "none"}):
        figure, axes = pyplot.subplots(figsize=(7.2, 0.24 * len(names) + 0.7))
        bars = axes.barh(range(len(names)), numbers, color=BAR, height=0.7)
        axes.set_yticks(range(len(names)), names, color=TEXT)
        axes.bar_label(bars, [f"{number:g}" for number in numbers], padding=3, color=TEXT)
        axes.set_xscale("log")
        axes.invert_yaxis()
        axes.margins(x=0.12, y=0.01)
        axes.set_xlabel(f"{measured.unit}, logarithmic", color=TEXT)
        axes.tick_params(axis="x", colors=TEXT)
        axes.spines[:].set_visible(False)
        file.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(file, transparent=True, bbox_inches="tight", metadata={"Date": None})
        pyplot.close(figure)


def draw_all(folder: Path) -> dict[str, str]:
    """Draw the plots of all results to a folder; return the line about the machine of each."""
    names = sorted(file.stem for file in RESULTS.glob("*.jsonl"))
    for name in names:
        draw(name, folder / f"{name}.svg")
    return {name: result(name).machine for name in names}
