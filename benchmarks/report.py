"""Print benchmark results: the machine first, then a row for each number beside its peer's."""

from __future__ import annotations

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
    print(f"{name}, {os.cpu_count()} threads, load {os.getloadavg()[0]:.1f}, {date.today().isoformat()}")


def row(what: str, ours: str, peer: str = "", *, ratio: float | None = None, target: str = "") -> None:
    """Print a row: our number, the peer's, how many times better ours is, and the target."""
    line = f"{what:<28} {ours:>24} {peer:>36}"
    if ratio is not None:
        line += f" {ratio:6.2f}x"
    if target:
        line += f"  ({target})"
    print(line.rstrip(), flush=True)
