"""Compile kernels before the first image on a machine; later, load them from Warp's cache."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed

import warp as wp

from usdsdg.parallel import CUDA_BLOCK, available_threads
from usdsdg_render.bvh import build, compress
from usdsdg_render.kernels.labels import coverage, label_kernels, lens_motion, screen_bounds, sight
from usdsdg_render.kernels.path import cpu_path, tone_map, wavefront, wavelet_denoiser
from usdsdg_render.kernels.scene import instance_transforms

Progress = Callable[[str, int, "int | None"], None]
_ready: set[str] = set()
# More do not help: each thread precompiles Warp's headers itself, and two modules make up most of the work.
MAX_THREADS = 3


def precompile(device: str = "cpu", progress: Progress | None = None) -> None:
    """Compile or load every kernel of the renderer for a device, and report `progress` (label, done, total)."""
    if device in _ready:
        return
    loads = _loads(wp.get_device(device))
    for module, *_ in loads:
        without_bfloat16(module)
    # Makes Warp store Clang's version: threads that ask for it at once may read none, miss the cache and compile again.
    wp.get_cpu_kernel_cache_key()
    label = "render kernels (compiled on first use)"
    report = progress or (lambda *_: None)
    report(label, 0, len(loads))
    pool = ThreadPoolExecutor(min(MAX_THREADS, available_threads()), thread_name_prefix="usdsdg-compile")
    try:
        running = [pool.submit(module.load, *where) for module, *where in loads]
        for done, load in enumerate(as_completed(running)):
            load.result()
            report(label, done + 1, len(loads))
    finally:
        # Do not wait for the compiler after Ctrl-C.
        pool.shutdown(wait=False, cancel_futures=True)
    _ready.add(device)


def _loads(target: wp.Device) -> list[tuple[wp.Module, wp.Device, int]]:
    """List modules with their device and block size, those that take longest to compile first."""
    kernels = [wavefront.intersect_closest if target.is_cuda else cpu_path.add_samples]
    kernels += [label_kernels.label_pixels, label_kernels.label_materials, label_kernels.label_hemispheres]
    kernels += [lens_motion.label_lens_motion, screen_bounds.bound_on_screen, coverage.fill_mask_words]
    kernels += [sight.follow_points]
    kernels += [wavelet_denoiser.atrous_pass, tone_map.tone_map_pixels]
    # Transforms of instances are set, and BVHs are built, on the CPU for either device.
    host = [build.build_tree, instance_transforms.set_instance_transforms] + [compress.compress_tree] * target.is_cuda
    # Several kernels may share a module.
    modules = dict.fromkeys(kernel.module for kernel in kernels)
    loads = [(module, target, CUDA_BLOCK if target.is_cuda else 1) for module in modules]
    return loads + [(kernel.module, wp.get_device("cpu"), 1) for kernel in host]


def without_bfloat16(module: wp.Module) -> None:
    """Compile a module without bfloat16, which no kernel uses: Warp's headers precompile in a third less time."""
    if wp.get_module_options(module)["cpu_compiler_flags"] is None:
        flags = wp.config.cpu_compiler_flags
        flags = "-march=native" if flags is None else flags
        wp.set_module_options({"cpu_compiler_flags": f"{flags} -DWP_NO_BFLOAT16="}, module)
