"""What of a frame is kernels, on the CPU: 50 shapes with new poses and colors in each frame, one camera of 640x480.

    python -m benchmarks.frame_share [--annotators rgb] [--size 640 480] [--frames 20] [--kernels 5]

CPU time of all threads of the process; that of kernels is what the threads that launch them take for it.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections import defaultdict
from collections.abc import Callable
from typing import Any

from warp._src import context

import usdsdg as rep
from benchmarks import capture_rate, report
from usdsdg.session import devices

WARM_UP = 4


def note_kernels(seconds: dict[str, float]) -> None:
    """Let each launch on the CPU add its CPU seconds to those of its kernel."""
    invoke: Callable[..., Any] = context.invoke

    def timed(kernel: Any, *arguments: Any, **options: Any) -> Any:
        began = time.thread_time()
        try:
            return invoke(kernel, *arguments, **options)
        finally:
            seconds[kernel.key] += time.thread_time() - began

    context.invoke = timed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--annotators", nargs="+", default=["rgb"])
    parser.add_argument("--size", type=int, nargs=2, default=(640, 480))
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--kernels", type=int, default=5, help="how many kernels to list, the longest first")
    options = parser.parse_args()
    report.begin()
    devices.use_device("cpu")
    (product,) = capture_rate.build(1, tuple(options.size))
    for name in options.annotators:
        rep.AnnotatorRegistry.get_annotator(name).attach(product)
    for _ in range(WARM_UP):
        rep.orchestrator.step()
    kernels: dict[str, float] = defaultdict(float)
    note_kernels(kernels)
    frames, walls = [], []
    for _ in range(options.frames):
        wall, cpu = time.perf_counter(), time.process_time()
        rep.orchestrator.step()
        walls.append(time.perf_counter() - wall)
        frames.append(time.process_time() - cpu)
    total, in_kernels = sum(frames), sum(kernels.values())
    what = f"{'x'.join(map(str, options.size))} {'+'.join(options.annotators)}"
    each = f"{1e3 * statistics.median(frames):.1f} ms CPU, {1e3 * statistics.median(walls):.1f} ms"
    report.row(what, f"{100 * (1 - in_kernels / total):.1f} % is not kernels", each, target="15 % of rgb")
    for name, seconds in sorted(kernels.items(), key=lambda item: -item[1])[: options.kernels]:
        report.row(f"  {name}", f"{1e3 * seconds / options.frames:.2f} ms")


if __name__ == "__main__":
    main()
