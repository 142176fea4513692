"""All kernels of the CPU renderer: CPU seconds to compile them into an empty cache, and to load them from it.

    python -m benchmarks.kernel_cache [--rounds 3]

Each measurement is a process of its own, with a cache of its own.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile

from benchmarks import report

EMPTY_AT_MOST, CACHED_AT_MOST = 12.0, 0.1
# Runs in a fresh process; imports and Warp's own start are timed apart.
SCRIPT = """
import json, time
import warp as wp
wp.config.log_level = 30
start = time.process_time(), time.perf_counter()
wp.init()
ready = time.process_time(), time.perf_counter()
from usdsdg_render.device.precompile import precompile
imported = time.process_time(), time.perf_counter()
precompile("cpu")
done = time.process_time(), time.perf_counter()
print(json.dumps([done[0] - imported[0], done[1] - imported[1], ready[0] - start[0], imported[0] - ready[0]]))
"""


def measured(cache: str) -> list[float]:
    """Return CPU and wall seconds to get kernels ready, and CPU seconds of Warp's start and of imports."""
    environment = {**os.environ, "WARP_CACHE_PATH": cache}
    done = subprocess.run([sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"the process that compiles failed:\n{done.stderr}")
    return json.loads(done.stdout.splitlines()[-1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    report.begin()
    empty, cached = [], []
    for _ in range(options.rounds):
        with tempfile.TemporaryDirectory() as cache:
            empty.append(measured(cache))
            cached.append(measured(cache))
    for name, rows, most in (("empty cache", empty, EMPTY_AT_MOST), ("cached", cached, CACHED_AT_MOST)):
        cpu, wall, start, imports = (statistics.median(column) for column in zip(*rows, strict=True))
        report.row(name, f"{cpu:.3f} CPU-s", f"{wall:.3f} s", target=f"at most {most:g} CPU-s")
        print(f"    besides: Warp's start {start:.2f} CPU-s, imports {imports:.2f}")


if __name__ == "__main__":
    main()
