"""Frames a second of a job by several processes of a thread each, by one such process, and by one without a limit.

    python -m benchmarks.workers [--config FILE] [--frames 4 16] [--workers 2] [--threads 1] [--set KEY=VALUE ...]
        [--device cuda:0] [--only one several] [--annotators rgb,bounding_box_2d_tight [--cameras 1] [--size 1280 720]]

With --annotators it is the script of 50 shapes, `benchmarks/capture_script.py`, with these, in place of a job.

Each contender makes the job twice, with fewer and with more frames. The rate with start-up is that of the longer run,
from the command to its end; the rate without it is that of the frames between the two runs, in the time between them.
Parts that are episodes share no simulation: give `--set frames_per_episode=N`. Kernels and assets are loaded into the
caches by a run before. Processor time tells, on a machine where others work too, what is made twice: with a core for
each process, a dataset takes the time of its process that has most to do.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from benchmarks import report

REPOSITORY = Path(__file__).parents[1]
COUNT, OUTPUT = "num_frames", "writer_kwargs.output_dir"


@dataclass(frozen=True)
class Cost:
    """Seconds of a command: on the clock, and of all its processes together."""

    wall: float
    cpu: float

    def __sub__(self, other: Cost) -> Cost:
        return Cost(self.wall - other.wall, self.cpu - other.cpu)


def job(config: Path, overrides: list[str], frames: int, folder: str) -> list[str]:
    """Return what `usdsdg` is given to make so many frames of a job."""
    settings = (*overrides, f"{COUNT}={frames}", f"{OUTPUT}={folder}/out")
    return ["generate", "-q", str(config), *(part for each in settings for part in ("--set", each))]


def script(annotators: str, views: tuple[int, int, int], frames: int, folder: str) -> list[str]:
    """Return what `usdsdg` is given to make so many frames of 50 shapes; views: how many cameras, width and height."""
    file = f"{REPOSITORY}/benchmarks/capture_script.py"
    return ["run", "-q", file, str(frames), f"{folder}/out", annotators, *map(str, views)]


def cost(made: Callable[[int, str], list[str]], frames: int, options: list[str]) -> Cost:
    """Return what the command costs that makes so many frames.

    made: of a number of frames and a folder, the name and the arguments of the command.
    """
    with tempfile.TemporaryDirectory() as folder:
        name, *arguments = made(frames, folder)
        command = [sys.executable, "-m", "usdsdg", name, *options, *arguments]
        started, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(command)} failed:\n{done.stderr}")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return Cost(time.perf_counter() - started, cpu)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", type=Path, default=REPOSITORY / "configs/object_based.yaml")
    parser.add_argument("--frames", type=int, nargs=2, default=[4, 16], metavar=("FEWER", "MORE"))
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--annotators", default="")
    parser.add_argument("--cameras", type=int, default=1)
    parser.add_argument("--size", type=int, nargs=2, default=[1280, 720])
    parser.add_argument("--only", nargs="+", choices=["one", "thread", "several"], default=["one", "thread", "several"])
    arguments = parser.parse_args()
    bound = ["--threads", str(arguments.threads)]
    contenders = {
        "one": ("one process", []),
        "thread": (f"one, --threads {arguments.threads}", bound),
        "several": (
            f"{arguments.workers}, --threads {arguments.threads}",
            ["--workers", str(arguments.workers), *bound],
        ),
    }
    report.begin()
    device = ["--device", arguments.device]
    views = (arguments.cameras, *arguments.size)
    shapes, config = partial(script, arguments.annotators, views), partial(job, arguments.config, arguments.set)
    made = shapes if arguments.annotators else config
    cost(made, 1, device)
    fewer, more = sorted(arguments.frames)
    rates: dict[str, tuple[float, float]] = {}
    for key, (name, options) in contenders.items():
        if key in arguments.only:
            short, long = (cost(made, count, [*device, *options]) for count in (fewer, more))
            between = long - short
            rates[key] = more / long.wall, (more - fewer) / between.wall
            report.row(name, f"{rates[key][0]:.2f} frames/s", f"{rates[key][1]:.2f} without start-up")
            each = between.cpu / (more - fewer)
            report.row(
                "  processor time", f"{short.cpu:.1f} s for {fewer}", f"{long.cpu:.1f} s for {more}, {each:.2f} each"
            )
    for key in sorted(rates.keys() - {"several"}) if "several" in rates else ():
        ratios = [mine / other for mine, other in zip(rates["several"], rates[key], strict=True)]
        report.row(
            f"{arguments.workers} against {contenders[key][0]}", f"{ratios[0]:.2f}x", f"{ratios[1]:.2f}x without"
        )


if __name__ == "__main__":
    main()
