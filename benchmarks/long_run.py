"""Thousands of captures of a small scene, labels only: growth of memory, open files and time per frame.

python benchmarks/long_run.py OUTPUT_DIR [--frames 10000]
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import numpy as np

import usdsdg as rep
from usdsdg.orchestrator import get_orchestrator

EVERY = 250
# The first captures fill caches and are not counted.
WARM_UP = 500


def author(output_dir: str) -> None:
    draw = rep.distribution
    cubes = rep.create.cube(count=5, semantics=[("class", "cube")])
    with rep.trigger.on_frame(), cubes:
        rep.modify.pose(position=draw.uniform((-1, -1, -1), (1, 1, 1)))
        rep.randomizer.color(draw.uniform((0, 0, 0), (1, 1, 1)))
    camera = rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0), clipping_range=(0.1, 100))
    writer = rep.WriterRegistry.get("BasicWriter")
    labels = dict(bounding_box_2d_tight=True, semantic_segmentation=True, distance_to_camera=True)
    writer.initialize(output_dir=output_dir, **labels)
    writer.attach(rep.create.render_product(camera, (64, 64)))


def resident_kilobytes() -> float:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1024


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output_dir")
    parser.add_argument("--frames", type=int, default=10000)
    options = parser.parse_args()
    rep.set_global_seed(0)
    author(options.output_dir)
    rows: list[tuple[int, float, float, int]] = []

    def record() -> None:
        done = get_orchestrator().captures
        if done % EVERY == 0:
            rows.append((done, resident_kilobytes(), time.perf_counter(), len(os.listdir("/proc/self/fd"))))

    get_orchestrator().on_captured(record)
    rep.orchestrator.run(num_frames=options.frames)
    rep.orchestrator.wait_until_complete()
    frame, memory, clock, files = np.array([row for row in rows if row[0] >= WARM_UP]).T
    milliseconds = np.diff(clock) / EVERY * 1e3
    print(f"{options.frames} captures: memory grows {np.polyfit(frame, memory, 1)[0]:.2f} KB a frame after {WARM_UP}")
    print(f"open files {files[0]:.0f} then, {files[-1]:.0f} at the end")
    early, late = milliseconds[:3].mean(), milliseconds[-3:].mean()
    print(f"ms a frame: {early:.2f} at the beginning, {np.median(milliseconds):.2f} median, {late:.2f} at the end")


if __name__ == "__main__":
    main()
