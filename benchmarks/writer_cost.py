"""CPU time of writers: one frame of 1920x1080 with 337 labeled objects, handed to each writer again and again.

    python -m benchmarks.writer_cost [--rounds 9] [--size 1920 1080]

The frame is rendered once, path traced with 4 samples a pixel; its annotators are computed before. A row is what one
frame costs from there to its files: building the payload, encoding, storing, and the frame's record; of all threads
together, and of the thread that renders. `noisy` has the same picture with noise in every pixel, the worst case of PNG.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

import benchmarks.annotators as labeled
import usdsdg as rep
from benchmarks import report
from usdsdg.annotators import named_annotators
from usdsdg.capture.output import WriterOutput
from usdsdg.capture.records.pictures import PICTURES
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.writers import Writer, register_writer
from usdsdg.writers.backends.disk import DiskBackend

NOISE = 3.0  # standard deviation [gray levels]
LIMIT_MS = 20
RECORD = "/usdsdg/labels/record"


def noisy(image: np.ndarray) -> np.ndarray:
    """Return the picture with noise, the same for every call."""
    noise = np.rint(np.random.default_rng(0).normal(0.0, NOISE, (*image.shape[:2], 3)))
    colors = np.clip(image[..., :3] + noise, 0, 255).astype(np.uint8)
    return np.concatenate([colors, image[..., 3:]], axis=-1)


class Files(Writer):
    """Writes one annotator in one form."""

    def __init__(self, output_dir: str, annotator: str, suffix: str, change: Any = None, **options: Any) -> None:
        self.annotators = [named_annotators.get(annotator, options or None)]
        self.backend = DiskBackend(output_dir)
        self._suffix, self._change = suffix, change

    def write(self, data: dict[str, Any]) -> None:
        (name,) = (each.get_name() for each in self.annotators)
        seen = data[name]
        array = seen["data"] if isinstance(seen, dict) else seen
        path = f"{self.num_written:04d}.{self._suffix}"
        write = self.backend.write_array if self._suffix == "npy" else self.backend.write_image
        write(path, array if self._change is None else self._change(array))


MASKS = {"semantic_segmentation": True, "instance_segmentation": True}
BOXES = {"bounding_box_2d_tight": True, "bounding_box_3d": True, "camera_params": True}
# By name: writer and options; the noisy picture is made once, when the first payload is built.
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "rgb, png": ("BasicWriter", {"rgb": True}),
    "rgb, jpg": ("BasicWriter", {"rgb": True, "image_output_format": "jpg"}),
    "normals, png": ("BasicWriter", {"normals": True}),
    "colorized masks": ("BasicWriter", MASKS),
    "masks of ids": ("BasicWriter", {**MASKS, **{f"colorize_{name}": False for name in MASKS}}),
    "depth, npy": ("BasicWriter", {"distance_to_camera": True}),
    "depth, exr": ("Files", {"annotator": "distance_to_camera", "suffix": "exr"}),
    "boxes and camera": ("BasicWriter", BOXES),
    "COCO": ("CocoWriter", {}),
}


class Watch:
    """Hands every frame to its writer `rounds` times, and times it: in all threads, and in the caller's."""

    def __init__(self, rounds: int) -> None:
        self.rounds = rounds
        self.total: dict[str, float] = {}
        self.caller: dict[str, float] = {}
        self.names: dict[int, str] = {}

    @contextmanager
    def watching(self) -> Iterator[None]:
        write = WriterOutput.write

        def timed(output: WriterOutput, writer: Writer, *arguments: Any) -> None:
            totals, callers = [], []
            for number in range(self.rounds + 1):
                for frame in arguments[0].values():
                    frame.memo.pop(PICTURES, None)  # what records of one frame share is made anew
                before, mine = time.process_time(), time.thread_time()
                write(output, writer, *arguments)
                callers.append(time.thread_time() - mine)
                current().io_queue.wait_until_done()
                totals.append(time.process_time() - before)
                if number == 0:
                    totals.clear(), callers.clear()
            name = self.names[id(writer)]
            self.total[name], self.caller[name] = (1e3 * statistics.median(each) for each in (totals, callers))

        WriterOutput.write = timed
        try:
            yield
        finally:
            WriterOutput.write = write


class NoisyWriter(Writer):
    """As BasicWriter with rgb, of a picture with noise."""

    shares_arrays = True

    def __init__(self, output_dir: str) -> None:
        self.annotators = [named_annotators.get("rgb")]
        self.backend = DiskBackend(output_dir)
        self._picture: np.ndarray | None = None

    def write(self, data: dict[str, Any]) -> None:
        self._picture = noisy(data["rgb"]) if self._picture is None else self._picture
        self.backend.write_image(f"rgb_{self.num_written:04d}.png", self._picture)


def measure(rounds: int, folder: Path, *, record: bool) -> Watch:
    """Render the frame, and time what its writers do with it."""
    get_settings().set(RECORD, record)
    watch = Watch(rounds)
    product = rep.create.render_product(labeled.CAMERA, labeled.SIZE)
    for name, (kind, options) in {**CASES, "rgb, png, noisy": ("NoisyWriter", {})}.items():
        writer = rep.WriterRegistry.get(kind)
        writer.initialize(output_dir=str(folder / f"{name} {record}".replace(", ", "_").replace(" ", "_")), **options)
        writer.attach(product)
        watch.names[id(writer)] = name
    with watch.watching():
        rep.orchestrator.step()
    rep.WriterRegistry.detach_all()
    return watch


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--size", type=int, nargs=2, default=(1920, 1080))
    options = parser.parse_args()
    labeled.SIZE = tuple(options.size)
    for kind in (Files, NoisyWriter):
        register_writer(kind)
    report.begin()
    get_settings().set("/rtx/rendermode", "PathTracing")
    get_settings().set("/rtx/pathtracing/totalSpp", 4)
    with tempfile.TemporaryDirectory() as folder:
        labeled.labeled_stage(Path(folder))
        rep.create.light(light_type="Dome", intensity=1000)
        rep.create.light(light_type="Distant", intensity=2000, rotation=(30, 20, 0))
        alone = measure(options.rounds, Path(folder), record=False)
        recorded = measure(options.rounds, Path(folder), record=True)
    for name, ms in alone.total.items():
        target = f"at most {LIMIT_MS} ms" if name.startswith("rgb, png") else ""
        on_caller = f"{alone.caller[name]:.1f} ms on the caller; with the record {recorded.total[name]:.1f}, "
        report.row(name, f"{ms:.1f} ms CPU", f"{on_caller}{recorded.caller[name]:.1f}", target=target)


if __name__ == "__main__":
    main()
