"""Kernels ready before the first picture: compiled on first use of a machine, else loaded from Warp's cache."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed

import warp as wp

from usdsdg_render.kernels import (
    ambient_aov,
    aov,
    coverage,
    curved_motion,
    denoise,
    develop,
    material_aov,
    path,
    place,
    tangents,
    wavefront,
)
from usdsdg_render.parallel import CUDA_BLOCK, available_threads
from usdsdg_render.trace import build, compress

Progress = Callable[[str, int, "int | None"], None]
_ready: set[str] = set()


def precompile(device: str = "cpu", progress: Progress | None = None) -> None:
    """Compile or load every kernel of the renderer for a device; says so through `progress`."""
    if device in _ready:
        return
    kernels = [path.add_samples if device == "cpu" else wavefront.trace]
    kernels += [aov.label_pixels, material_aov.label_materials, ambient_aov.label_ambient]
    kernels += [curved_motion.label_curved_motion, tangents.draw_octagons, coverage.cover_strips]
    kernels += [develop.develop_pixels, denoise.smooth]
    target = wp.get_device(device)
    # Instances are placed and trees are built on the CPU for either device.
    host = [build.build_tree, place.place] + [compress.compress_tree] * target.is_cuda
    loads = [(kernel.module, wp.get_device("cpu"), 1) for kernel in host]
    loads += [(kernel.module, target, CUDA_BLOCK if target.is_cuda else 1) for kernel in kernels]
    label = "render kernels (compiled on first use)"
    report = progress or (lambda *_: None)
    report(label, 0, len(loads))
    with ThreadPoolExecutor(min(len(loads), available_threads())) as pool:
        running = [pool.submit(module.load, *where) for module, *where in loads]
        for done, load in enumerate(as_completed(running)):
            load.result()
            report(label, done + 1, len(loads))
    _ready.add(device)
