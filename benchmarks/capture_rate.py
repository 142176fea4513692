"""Pictures a second of 50 shapes that get new poses and colors in each frame, as in Isaac Sim's benchmark_sdg.py.

    python -m benchmarks.capture_rate [--device cuda:0] [--cameras 1] [--size 1280 720] [--annotators rgb ...]
        [--to FOLDER|memory] [--frames 60]

Times are wall times of whole frames, from the first randomizer to the files; the time of processors is that of all
threads of the process. The first frames are not counted.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
import time

import numpy as np
import warp as wp

import usdsdg as rep
from benchmarks import report
from usdsdg.session import devices
from usdsdg.session.session import current

WARM_UP, SHAPES = 8, 50


def build(cameras: int, size: tuple[int, int]) -> list[object]:
    """Make the shapes with their randomizers; return a render product for each camera."""
    rep.create.light(light_type="dome", intensity=1000)
    kinds = (rep.create.cube, rep.create.sphere, rep.create.cone, rep.create.cylinder, rep.create.torus)
    per_kind = SHAPES // len(kinds)
    shapes = [make(count=per_kind, semantics=[("class", make.__name__)]) for make in kinds]
    with rep.trigger.on_frame():
        for group in shapes:
            with group:
                rep.modify.pose(
                    position=rep.distribution.uniform((-4, -4, -2), (4, 4, 2)),
                    rotation=rep.distribution.uniform((0, 0, 0), (360, 360, 360)),
                )
                rep.randomizer.color(colors=rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
    eyes = [(12 * np.cos(turn), 12 * np.sin(turn), 4.0) for turn in np.arange(cameras) * 2 * np.pi / cameras]
    return [rep.create.render_product(rep.create.camera(position=eye, look_at=(0, 0, 0)), size) for eye in eyes]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--device", default=None)
    parser.add_argument("--cameras", type=int, default=1)
    parser.add_argument("--size", type=int, nargs=2, default=(1280, 720))
    parser.add_argument("--annotators", nargs="+", default=["rgb"])
    parser.add_argument("--to", default=None)
    parser.add_argument("--frames", type=int, default=60)
    options = parser.parse_args()
    report.begin()
    devices.use_device(options.device)
    products = build(options.cameras, tuple(options.size))
    folder = tempfile.mkdtemp(dir=None if options.to == "memory" else options.to)
    if options.to == "memory":
        for product in products:
            for name in options.annotators:
                rep.AnnotatorRegistry.get_annotator(name).attach(product)
    else:
        chosen = {name: True for name in options.annotators} | {"rgb": "rgb" in options.annotators}
        rep.writers.get("BasicWriter", init_params={"output_dir": folder, **chosen}).attach(products)
    for _ in range(WARM_UP):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    started, cpu = time.perf_counter(), time.process_time()
    for _ in range(options.frames):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    seconds, cpu = time.perf_counter() - started, time.process_time() - cpu
    current().close_run()
    shutil.rmtree(folder)
    size, names = "x".join(map(str, options.size)), "+".join(options.annotators)
    what = f"{options.cameras} x {size} {names} to {options.to or 'disk'}"
    each = f"{1e3 * seconds / options.frames:.1f} ms a frame, {1e3 * cpu / options.frames:.1f} ms of processors"
    report.row(what, f"{options.frames * options.cameras / seconds:.1f} pictures/s", each)
    if wp.is_cuda_available() and options.device != "cpu":
        free, total = wp.get_device("cuda:0").free_memory, wp.get_device("cuda:0").total_memory
        print(f"device memory in use: {(total - free) / 1e9:.2f} GB")


if __name__ == "__main__":
    main()
