"""Pictures and labels a second of many worlds of the 50-shape scene of `capture_rate`, to the memory of the device.

    python -m benchmarks.worlds [--device cuda:0] [--worlds 256] [--cameras 1] [--size 128 128] [--samples 4]
        [--steps 20] [--annotators bounding_box_2d_tight ...]

Every step draws new poses and colors for all worlds, and makes rgb, semantic ids, depth and 2D boxes of each camera in
each world, or what --annotators names. Times are wall times of whole steps, up to the arrays being there, of all steps
but the first ones. The rows after the first say where the time goes; in these, the device is waited for after each
part, so that they add up to more.
"""

from __future__ import annotations

import argparse
import time

import warp as wp

import usdsdg as rep
from benchmarks import report
from benchmarks.capture_rate import SHAPES, build
from benchmarks.device_memory import PeakMemory
from usdsdg.capture import worlds as capture_worlds
from usdsdg.capture.render_settings import render_mode
from usdsdg.session import devices, engines
from usdsdg.session.session import current

WARM_UP = 3
ANNOTATORS = ("rgb", "semantic_segmentation", "distance_to_image_plane", "bounding_box_2d_tight")


def set_samples(samples: int) -> None:
    """Path-trace so many samples per pixel, without a denoiser."""
    settings = rep.settings
    settings.set_render_pathtraced(samples_per_pixel=samples)
    settings.carb_settings("/rtx/pathtracing/optixDenoiser/enabled", False)


class Steps:
    """Steps of worlds of the current stage."""

    def __init__(self, count: int, annotators: tuple[str, ...]) -> None:
        self.batches: list[capture_worlds.WorldBatch] = []
        current().worlds = self.tap = capture_worlds.WorldTap(count, annotators, self.batches.append)

    def run(self, steps: int) -> float:
        """Return the seconds that so many steps take."""
        started = time.perf_counter()
        for _ in range(steps):
            rep.orchestrator.step()
            # At most two steps are under way, as when a trainer takes them.
            for batch in self.batches[:-1]:
                batch.wait()
            del self.batches[:-1]
        for batch in self.batches:
            batch.wait()
        return time.perf_counter() - started

    def parts(self, steps: int) -> dict[str, float]:
        """Return the mean seconds of the parts of a step, each waited for."""
        sums: dict[str, float] = {}

        def timed(name: str, work):
            started = time.perf_counter()
            result = work()
            wp.synchronize()
            sums[name] = sums.get(name, 0.0) + (time.perf_counter() - started) / steps
            return result

        renderer, product = engines.renderer(), capture_worlds._products()[0]
        view = capture_worlds.read_camera(capture_worlds.current_stage(), product.camera_path, product.resolution)
        mode = render_mode(1)
        settings = capture_worlds.path_settings(mode, 0, with_light_aovs=False)
        tone = capture_worlds.tone_settings(mode)
        for _ in range(steps):
            frame = current().orchestrator.captures
            values = timed("draw", lambda frame=frame: self.tap.draw(frame))
            timed("read and upload", lambda values=values: renderer.place_worlds(values))
            timed("labels", lambda: renderer.world_labels(view, ("instance", "distance_to_image_plane")))
            timed("pictures", lambda: renderer.world_pictures(view, samples=mode.samples, settings=settings, tone=tone))
            current().orchestrator.captures += self.tap.count
        return sums


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--device", default=None)
    parser.add_argument("--worlds", type=int, default=256)
    parser.add_argument("--cameras", type=int, default=1)
    parser.add_argument("--size", type=int, nargs=2, default=(128, 128))
    parser.add_argument("--samples", type=int, default=4)
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--annotators", nargs="+")
    options = parser.parse_args()
    report.begin()
    devices.use_device(options.device)
    build(options.cameras, tuple(options.size))
    set_samples(options.samples)
    memory = PeakMemory()
    what = f"{options.worlds} worlds of {SHAPES} shapes, {options.cameras} x {options.size[0]}x{options.size[1]}"
    for names in [tuple(options.annotators)] if options.annotators else (ANNOTATORS, ANNOTATORS[1:]):
        steps = Steps(options.worlds, names)
        steps.run(WARM_UP)
        seconds = steps.run(options.steps) / options.steps
        shown = "+".join(names) + (f", {options.samples} spp" if "rgb" in names else "")
        rate = options.worlds * options.cameras / seconds
        report.row(f"{what}: {shown}", f"{rate:.0f} pictures/s", f"{1e3 * seconds:.1f} ms a step")
    for name, seconds in steps.parts(max(2, options.steps // 4)).items():
        report.row(f"{what}: {name}", f"{1e3 * seconds:.1f} ms", "alone")
    current().worlds = None
    print(memory.described())


if __name__ == "__main__":
    main()
