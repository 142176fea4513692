"""Writers with files about all frames: time of a frame at the beginning and at the end of a long run, and memory.

    python -m benchmarks.aggregate_files [--frames 20000] [--writers CocoWriter BopWriter ...]

One small frame with labeled cubes is rendered, and handed to each writer again and again; files of single frames are
dropped, so that what is measured is what grows: the records of frames, and the files that are made of them at the end.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Iterable
from typing import Any

import numpy as np

import usdsdg as rep
from benchmarks.long_run import resident_kilobytes
from usdsdg.session.session import current
from usdsdg.writers.backends.disk import DiskBackend

WRITERS: dict[str, dict[str, Any]] = {
    "CocoWriter": {"plain_names": True, "panoptic": True},
    "BopWriter": {},
    "CvatWriter": {},
    "VocWriter": {},
    "YCBVideoWriter": {"num_frames": 1, "pose": True, "class_name_to_index_map": {"cube": 1}},
}
# Files about all frames; those of single frames are dropped.
KEPT = (".json", ".txt", "annotations.xml")


def drop_files_of_frames() -> None:
    write = DiskBackend._write

    def write_kept(backend: DiskBackend, path: str, chunks: Iterable[bytes | memoryview]) -> None:
        if path.endswith(KEPT):
            write(backend, path, chunks)

    DiskBackend._write = write_kept


def payload_of(name: str, options: dict[str, Any]) -> tuple[Any, Any]:
    """Return a writer and the payload of the one frame that it has received."""
    writer = rep.WriterRegistry.get(name)
    writer.initialize(output_dir=tempfile.mkdtemp(prefix="usdsdg-benchmark-"), **options)
    camera = rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0), clipping_range=(0.1, 100))
    writer.attach(rep.create.render_product(camera, (64, 48)))
    rep.orchestrator.step()
    return writer, writer.get_data()


def measure(name: str, frames: int) -> None:
    writer, payload = payload_of(name, WRITERS[name])
    current().io_queue.wait_until_done()
    times, memory = np.zeros(frames), np.zeros(frames)
    for number in range(frames):
        before = time.perf_counter()
        writer.receive(payload)
        times[number] = time.perf_counter() - before
        memory[number] = resident_kilobytes() if number % 100 == 0 else memory[number - 1]
    current().io_queue.wait_until_done()
    before = time.perf_counter()
    writer.on_final_frame()
    current().io_queue.wait_until_done()
    seconds, part = time.perf_counter() - before, max(frames // 10, 1)
    early, late = (1e3 * np.median(each) for each in (times[:part], times[-part:]))
    # Not from the first frames on, which fill caches.
    growth = (resident_kilobytes() - memory[frames // 5]) / (frames - frames // 5)
    print(
        f"{name}: {early:.3f} ms a frame in the first tenth, {late:.3f} in the last; memory grows {growth:.3f} KB a "
        f"frame; the files of {frames} frames are made in {seconds:.1f} s",
        flush=True,
    )
    writer.detach()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=20_000)
    parser.add_argument("--writers", nargs="+", choices=WRITERS, default=list(WRITERS))
    options = parser.parse_args()
    drop_files_of_frames()
    rep.create.cube(count=5, semantics=[("class", "cube")], position=rep.distribution.uniform((-1,) * 3, (1,) * 3))
    for name in options.writers:
        measure(name, options.frames)


if __name__ == "__main__":
    main()
