"""Frames a second of a job by several processes of a thread each, by one such process, and by one without a limit.

    python -m benchmarks.workers [--config FILE] [--frames 4 16] [--workers 2] [--set KEY=VALUE ...]

Each contender makes the job twice, with fewer and with more frames. The rate with start-up is that of the longer run,
from the command to its end; the rate without it is that of the frames between the two runs, in the time between them.
Parts that are episodes share no simulation: give `--set frames_per_episode=N`. Kernels and assets are loaded into the
caches by a run before.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks import report

REPOSITORY = Path(__file__).parents[1]
COUNT, OUTPUT = "num_frames", "writer_kwargs.output_dir"


def seconds(config: Path, overrides: list[str], frames: int, options: list[str]) -> float:
    """Return the wall time of the command that makes so many frames."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "usdsdg", "generate", "-q", str(config), *options]
        for each in (*overrides, f"{COUNT}={frames}", f"{OUTPUT}={folder}/out"):
            command += ["--set", each]
        started = time.perf_counter()
        done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(command)} failed:\n{done.stderr}")
        return time.perf_counter() - started


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", type=Path, default=REPOSITORY / "configs/object_based.yaml")
    parser.add_argument("--frames", type=int, nargs=2, default=[4, 16], metavar=("FEWER", "MORE"))
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--device", default="cpu")
    arguments = parser.parse_args()
    contenders = {
        "one process": [],
        "one process, 1 thread": ["--threads", "1"],
        f"{arguments.workers} processes, 1 thread each": ["--workers", str(arguments.workers), "--threads", "1"],
    }
    device = ["--device", arguments.device]
    report.begin()
    seconds(arguments.config, arguments.set, 1, device)
    rates: dict[str, tuple[float, float]] = {}
    fewer, more = sorted(arguments.frames)
    for name, options in contenders.items():
        short, long = (seconds(arguments.config, arguments.set, count, [*device, *options]) for count in (fewer, more))
        rates[name] = more / long, (more - fewer) / (long - short)
        print(f"{name}: {short:.1f} s for {fewer} frames, {long:.1f} s for {more}", flush=True)
    whole, one, several = rates.values()
    for name, each in rates.items():
        report.row(name, f"{each[0]:.2f} frames/s", f"{each[1]:.2f} without start-up")
    print(
        f"{arguments.workers} processes against one of a thread: {several[0] / one[0]:.2f}, {several[1] / one[1]:.2f}"
    )
    print(f"{arguments.workers} processes against one: {several[0] / whole[0]:.2f}, {several[1] / whole[1]:.2f}")


if __name__ == "__main__":
    main()
