"""Captures per second while bodies fall, against captures of the same scene standing still.

    python -m benchmarks.physics_capture [--device cuda:0] [--physics cpu] [--bodies 337] [--frames 40]

`--physics` is the device of the simulation, by default that of the renderer. Times are wall times.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from pxr import Sdf

import usdsdg as rep
from benchmarks.physics_speed import maker
from usdsdg.session import devices, engines
from usdsdg.session.stage_context import set_stage
from usdsdg.session.timeline import get_timeline

WARM_UP = 12
SIZE = (1024, 768)


def captures_per_second(frames: int, *, moving: bool) -> float:
    """Return the rate of captures; a playing timeline advances by one time code for each where bodies move."""
    seconds = []
    for frame in range(WARM_UP + frames):
        start = time.perf_counter()
        rep.orchestrator.step(pause_timeline=False, delta_time=None if moving else 0.0)
        if frame >= WARM_UP:
            seconds.append(time.perf_counter() - start)
    return 1.0 / float(np.median(seconds))


def main() -> None:
    parser = argparse.ArgumentParser(description="Captures while bodies fall.")
    parser.add_argument("--device", default=None)
    parser.add_argument("--physics", default=None)
    parser.add_argument("--bodies", type=int, default=337)
    parser.add_argument("--frames", type=int, default=40)
    options = parser.parse_args()
    devices.use_device(options.device)
    if options.physics:
        engines.physics_device = lambda: options.physics
    stage = set_stage(maker(options.bodies).stage)
    stage.RemovePrim(Sdf.Path("/World/Walls/wall_1n"))
    rep.create.light(light_type="dome", intensity=1000)
    camera = rep.create.camera(position=(0, -12, 2), look_at=(0, 0, 0))
    annotators = [rep.AnnotatorRegistry.get_annotator(name) for name in ("rgb", "semantic_segmentation")]
    product = rep.create.render_product(camera, SIZE)
    for annotator in annotators:
        annotator.attach(product)
    still = captures_per_second(options.frames, moving=False)
    get_timeline().play()
    moving = captures_per_second(options.frames, moving=True)
    print(f"{options.bodies} bodies: {still:.2f} captures a second standing still, {moving:.2f} while they fall")
    print(f"physics step: {1e3 * engines.physics().step_seconds:.2f} ms on {devices.physics_device()}")


if __name__ == "__main__":
    main()
