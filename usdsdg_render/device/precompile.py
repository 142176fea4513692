"""Kernels ready before the first picture: compiled on first use of a machine, else loaded from Warp's cache."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed

import warp as wp

from usdsdg_render.bvh import build, compress
from usdsdg_render.device.parallel import CUDA_BLOCK, available_threads
from usdsdg_render.kernels.labels import coverage, label_kernels, lens_motion, screen_bounds
from usdsdg_render.kernels.path import cpu_path, tone_map, wavefront, wavelet_denoiser
from usdsdg_render.kernels.scene import place

Progress = Callable[[str, int, "int | None"], None]
_ready: set[str] = set()
# Each thread precompiles Warp's headers for itself, and two modules make up most of the work.
MOST_THREADS = 3


def precompile(device: str = "cpu", progress: Progress | None = None) -> None:
    """Compile or load every kernel of the renderer for a device; says so through `progress`."""
    if device in _ready:
        return
    loads = _loads(wp.get_device(device))
    for module, *_ in loads:
        without_bfloat16(module)
    # Warp remembers Clang's version now. Threads that ask at once may read none, miss the cache and compile again.
    wp.get_cpu_kernel_cache_key()
    label = "render kernels (compiled on first use)"
    report = progress or (lambda *_: None)
    report(label, 0, len(loads))
    pool = ThreadPoolExecutor(min(MOST_THREADS, available_threads()), thread_name_prefix="usdsdg-compile")
    try:
        running = [pool.submit(module.load, *where) for module, *where in loads]
        for done, load in enumerate(as_completed(running)):
            load.result()
            report(label, done + 1, len(loads))
    finally:
        # Nobody waits for a compiler after Ctrl-C.
        pool.shutdown(wait=False, cancel_futures=True)
    _ready.add(device)


def _loads(target: wp.Device) -> list[tuple[wp.Module, wp.Device, int]]:
    """Modules with the device and the size of a block that they are wanted for, those that take longest first."""
    kernels = [wavefront.intersect_closest if target.is_cuda else cpu_path.add_samples]
    kernels += [label_kernels.label_pixels, label_kernels.label_materials, label_kernels.label_hemispheres]
    kernels += [lens_motion.label_lens_motion, screen_bounds.bound_on_screen, coverage.fill_mask_words]
    kernels += [wavelet_denoiser.atrous_pass, tone_map.tone_map_pixels]
    # Instances are placed and trees are built on the CPU for either device.
    host = [build.build_tree, place.place] + [compress.compress_tree] * target.is_cuda
    # Several kernels may share a module.
    modules = dict.fromkeys(kernel.module for kernel in kernels)
    loads = [(module, target, CUDA_BLOCK if target.is_cuda else 1) for module in modules]
    return loads + [(kernel.module, wp.get_device("cpu"), 1) for kernel in host]


def without_bfloat16(module: wp.Module) -> None:
    """Let Clang skip a kind of number that no kernel here uses: Warp's headers precompile in a third less time."""
    if wp.get_module_options(module)["cpu_compiler_flags"] is None:
        flags = wp.config.cpu_compiler_flags
        flags = "-march=native" if flags is None else flags
        wp.set_module_options({"cpu_compiler_flags": f"{flags} -DWP_NO_BFLOAT16="}, module)
