"""Two threads against one: paths and labels of the benchmark scene, wall seconds.

    python -m benchmarks.render_threads [--threads 2] [--samples 16] [--rounds 5] [--quick]

As a control, checksums of memory on as many threads show what the machine can give.
"""

from __future__ import annotations

import argparse
import zlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from benchmarks import render_scene, report
from benchmarks.render_labels import LABELS
from benchmarks.timing import in_turns
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.settings import PathSettings

AT_LEAST = 1.9
# Checksums of the control, and the bytes of each.
CONTROL_PARTS, CONTROL_BYTES = 200, 4_000_000


def control(threads: int) -> None:
    """Compute checksums on several threads, without Python's lock."""
    data = bytes(CONTROL_BYTES)
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(lambda _: zlib.crc32(data), range(CONTROL_PARTS)))


def compare(name: str, work: Callable[[int], object], threads: int, rounds: int, target: str = "") -> None:
    """Print a row of `work(threads)` with one thread and with several."""
    contenders = {str(count): lambda _, count=count: work(count) for count in (1, threads)}
    timings = in_turns(contenders, rounds=rounds)
    one, many = timings["1"], timings[str(threads)]
    numbers = f"{1e3 * many.wall:.0f} ms on {threads} threads", f"{1e3 * one.wall:.0f} ms on one"
    report.row(name, *numbers, ratio=one.wall / many.wall, target=target)
    print(f"    CPU time of {threads} threads is {many.cpu / one.cpu:.2f} times that of one")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--quick", action="store_true", help="images of 160x120")
    options = parser.parse_args()
    report.begin()
    scene = render_scene.build()
    views = render_scene.views(scene, (160, 120) if options.quick else (640, 480))
    renderer = WarpRenderer.of_scene(scene, device="cpu")
    renderer.sync()

    def paths(threads: int) -> None:
        renderer.threads = threads
        for view in views:
            film = renderer.new_film(view.width, view.height)
            renderer.accumulate(film, view, samples=options.samples, settings=PathSettings())

    def labels(threads: int) -> None:
        renderer.threads = threads
        renderer.labels_of(views, LABELS)

    target = f"at least {AT_LEAST}x" if options.threads == 2 else ""
    compare("paths", paths, options.threads, options.rounds, target)
    compare("labels", labels, options.threads, options.rounds, target)
    compare("control", control, options.threads, options.rounds)


if __name__ == "__main__":
    main()
