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
    flatten,
    material_aov,
    path,
)
from usdsdg_render.parallel import CUDA_BLOCK, available_threads
from usdsdg_render.trace import build

Progress = Callable[[str, int, "int | None"], None]
_ready: set[str] = set()


def precompile(device: str = "cpu", progress: Progress | None = None) -> None:
    """Compile or load every kernel of the renderer for a device; says so through `progress`."""
    if device in _ready:
        return
    kernels = [build.build_tree] if device == "cpu" else [flatten.place_triangles]
    kernels += [path.add_samples, aov.label_pixels, material_aov.label_materials, ambient_aov.label_ambient]
    kernels += [curved_motion.label_curved_motion, coverage.cover_strips, develop.develop_pixels, denoise.smooth]
    block_dim = 1 if device == "cpu" else CUDA_BLOCK
    modules = [kernel.module for kernel in kernels]
    label = "render kernels (compiled on first use)"
    report = progress or (lambda *_: None)
    report(label, 0, len(modules))
    with ThreadPoolExecutor(min(len(modules), available_threads())) as pool:
        loads = [pool.submit(module.load, wp.get_device(device), block_dim) for module in modules]
        for done, load in enumerate(as_completed(loads)):
            load.result()
            report(label, done + 1, len(modules))
    _ready.add(device)
