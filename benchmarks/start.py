"""Seconds from the command to its first picture on the disk: one cube by a script, and the default job.

    python -m benchmarks.start [--rounds 3] [--empty] [--cores 2] [--only cube] [--cache FOLDER]

Warm runs share one cache of kernels and assets, filled before by a run whose time is printed too; with `--empty` each
run begins with none. A run is a process of its own, on as many CPUs as `--cores` says.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks import report

REPOSITORY = Path(__file__).parents[1]
CUBE = """
import usdsdg as rep

rep.create.light(light_type="Dome")
rep.create.cube(semantics=[("class", "cube")])
camera = rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0))
writer = rep.writers.get("BasicWriter")
writer.initialize(output_dir=OUT, rgb=True)
writer.attach(rep.create.render_product(camera, (640, 480)))
rep.orchestrator.step()
"""
TARGETS = {("cube", False): 4, ("job", False): 10, ("cube", True): 30, ("job", True): 75}
POLL = 0.005


def command(what: str, out: Path) -> list[str]:
    """Return the command line of a run that writes below `out`."""
    program = [sys.executable, "-m", "usdsdg"]
    if what == "cube":
        script = out.parent / "cube.py"
        script.write_text(CUBE.replace("OUT", repr(str(out))), encoding="utf-8")
        return [*program, "run", str(script)]
    job = str(REPOSITORY / "configs/object_based.yaml")
    return [*program, "generate", job, "--set", f"writer_kwargs.output_dir={out}"]


def first_picture(what: str, cache: Path, cores: int, *, verbose: bool) -> tuple[float, float]:
    """Return the wall and CPU seconds from the start of a process to its first PNG, and end it there."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        log = Path(folder) / "log"
        environment = {
            **os.environ, "WARP_CACHE_PATH": str(cache / "warp"), "XDG_CACHE_HOME": str(cache),
            "PYTHONPATH": os.pathsep.join([str(REPOSITORY), *filter(None, [os.environ.get("PYTHONPATH")])]),
        }  # fmt: skip
        started = time.perf_counter()
        with log.open("w") as stream:
            process = subprocess.Popen(
                command(what, out), env=environment, stdout=stream, stderr=stream, cwd=folder,
                preexec_fn=lambda: os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:cores]),
            )  # fmt: skip
        try:
            while not any(out.rglob("*.png")):
                if process.poll() is not None and not any(out.rglob("*.png")):
                    raise RuntimeError(f"the run ended without a picture:\n{log.read_text()}")
                time.sleep(POLL)
            seconds = time.perf_counter() - started
        finally:
            process.kill()
            process.wait()
        if verbose:
            print(log.read_text())
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return seconds, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description="Seconds to the first picture.")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--empty", action="store_true", help="begin each run with empty caches")
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--only", choices=("cube", "job"))
    parser.add_argument("--cache", type=Path, help="folder of the caches of warm runs, kept for later")
    parser.add_argument("--verbose", action="store_true", help="print what the runs print")
    options = parser.parse_args()
    report.begin()
    with tempfile.TemporaryDirectory() as warm:
        for what in (options.only,) if options.only else ("cube", "job"):
            if not options.empty:
                wall, cpu = first_picture(what, options.cache or Path(warm), options.cores, verbose=options.verbose)
                report.row(f"{what}, fills the caches", f"{wall:.1f} s", f"{cpu:.1f} CPU-s")
            runs = []
            for _ in range(options.rounds):
                with tempfile.TemporaryDirectory() as empty:
                    cache = Path(empty) if options.empty else options.cache or Path(warm)
                    runs.append(first_picture(what, cache, options.cores, verbose=options.verbose))
            name = f"{what}, {'empty caches' if options.empty else 'warm'}"
            target = TARGETS[what, options.empty]
            walls, cpus = zip(*runs, strict=True)
            spread = f"{min(walls):.1f} to {max(walls):.1f}, {statistics.median(cpus):.1f} CPU-s"
            report.row(name, f"{statistics.median(walls):.1f} s", spread, target=f"at most {target} s")


if __name__ == "__main__":
    main()
