"""How fast the renderer is: samples, label passes, coverage. `python -m benchmarks.render_path [--samples 16]`.

Rates are per second of CPU time of the process (steady on a busy machine) and per second of wall time.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from benchmarks import render_scene
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.settings import PathSettings


def timed(work) -> tuple[float, float]:
    """(CPU seconds, wall seconds) of a call."""
    cpu, wall = time.process_time(), time.perf_counter()
    work()
    return time.process_time() - cpu, time.perf_counter() - wall


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--threads", type=int, default=None)
    parser.add_argument("--device", default=None)
    parser.add_argument("--bounces", type=int, default=3)
    parser.add_argument("--png", default=None, help="prefix of pictures to write")
    options = parser.parse_args()
    scene = render_scene.build()
    renderer = WarpRenderer.of_scene(scene, device=options.device)
    renderer.threads = options.threads
    print(f"first sync: {timed(renderer.sync)[0]:.3f} CPU-s")
    scene.touch("transforms")
    print(f"sync after motion: {1e3 * timed(renderer.sync)[0]:.2f} ms CPU")
    settings = PathSettings(bounces=options.bounces)
    groups = [[k] for k in range(12)]
    for view in render_scene.views(scene):
        renderer.labels(view, ["instance"])
        cpu, wall = timed(lambda v=view: renderer.labels(v, ["instance", "distance_to_camera", "normals", "albedo"]))
        pixels = view.width * view.height
        labels = renderer.labels(view, ["instance"])["instance"]
        print(f"{view.prim_path}: {np.mean(labels >= 0):.0%} of pixels hit")
        print(f"  labels {cpu * 1e3:.1f} ms CPU, {wall * 1e3:.1f} ms wall: {pixels / cpu / 1e6:.2f} Mpixel/CPU-s")
        renderer.coverage(view, groups)
        cpu, wall = timed(lambda v=view: renderer.coverage(v, groups))
        print(f"  coverage of 12: {cpu * 1e3:.1f} ms CPU, {wall * 1e3:.1f} ms wall")
        film = renderer.new_film(view.width, view.height)
        renderer.accumulate(film, view, samples=1, settings=settings)
        film = renderer.new_film(view.width, view.height)
        cpu, wall = timed(lambda v=view, f=film: renderer.accumulate(f, v, samples=options.samples, settings=settings))
        n = pixels * options.samples
        print(f"  paths {n / cpu / 1e6:.3f} Msamples/CPU-s, {n / wall / 1e6:.3f} Msamples/s wall")
        if options.png:
            from PIL import Image

            picture = renderer.develop(film)["LdrColor"]
            Image.fromarray(picture[..., :3]).save(f"{options.png}{view.prim_path.rsplit('_', 1)[1]}.png")


if __name__ == "__main__":
    main()
