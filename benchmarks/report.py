"""Print benchmark results: the machine first, then a row for each number beside its peer's.

The variable USDSDG_BENCHMARK_JSON names a file that gets the same as lines of JSON: `benchmarks/results` has some, from
which the documentation draws its plots.
"""

from __future__ import annotations

import json
import logging
import os
import platform
from datetime import date
from pathlib import Path

import warp as wp


def begin() -> None:
    """Print the processor, its threads, the load of the last minute and the date."""
    wp.config.log_level = logging.WARNING
    name = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        lines = info.read_text(encoding="utf-8").splitlines()
        name = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), name)
    load, today = round(os.getloadavg()[0], 1), date.today().isoformat()
    print(f"{name}, {os.cpu_count()} threads, load {load}, {today}")
    _keep({"machine": name, "threads": os.cpu_count(), "load": load, "date": today}, mode="w")


def row(what: str, ours: str, peer: str = "", *, ratio: float | None = None, target: str = "") -> None:
    """Print a row: our number, the peer's, how many times better ours is, and the target."""
    line = f"{what:<28} {ours:>24} {peer:>36}"
    if ratio is not None:
        line += f" {ratio:6.2f}x"
    if target:
        line += f"  ({target})"
    print(line.rstrip(), flush=True)
    _keep({"what": what.strip(), "ours": ours, "peer": peer, "ratio": ratio, "target": target})


def _keep(values: dict[str, object], mode: str = "a") -> None:
    """Add a line to the file that USDSDG_BENCHMARK_JSON names, if it does."""
    if path := os.environ.get("USDSDG_BENCHMARK_JSON"):
        with open(path, mode, encoding="utf-8") as file:
            file.write(json.dumps(values) + "\n")
