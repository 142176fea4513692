"""Compile kernels before the first image on a machine; later, load them from Warp's cache."""

from concurrent.futures import Future, ThreadPoolExecutor

import warp as wp

from usdsdg.image_files.run_kernels import deflate_runs
from usdsdg.kernels.compilation import THREADS, ModuleLoad, Progress, load_modules
from usdsdg.parallel import CUDA_BLOCK, available_threads
from usdsdg_render.bvh import build, compress, forest
from usdsdg_render.kernels.labels import label_boxes, label_kernels, label_tiles, parts
from usdsdg_render.kernels.path import cpu_path, tone_map, wavefront, wavelet_denoiser
from usdsdg_render.kernels.scene import instance_transforms

# More do not help: each thread precompiles Warp's headers itself, and two modules make up most of the work.
MAX_THREADS = 3
# On fewer cores, kernels that are compiled beside others delay those.
ENOUGH_CORES = 8
_ready: set[tuple[str, bool]] = set()
_beside: dict[str, Future[int]] = {}  # by device
_awaited: set[str] = set()  # devices for which a call of `precompile` waits


def precompile(device: str = "cpu", progress: Progress | None = None, *, everything: bool = False) -> int:
    """Compile or load the kernels of the renderer, and that of PNG files; return how many modules were compiled.

    Args:
        progress: called with (label, done, total), only if something must be compiled.
        everything: also those that only some scenes need, which otherwise wait for such a scene.
    """
    if device in _beside:
        _awaited.add(device)
        _beside.pop(device).result()
    return _precompile(device, progress, everything=everything)


def precompile_beside(device: str, progress: Progress | None = None) -> None:
    """Begin `precompile` on another thread, for CUDA and where there are cores for it; its next call waits for that.

    progress: is called while a call of `precompile` waits.
    """
    if device == "cpu" or available_threads() < ENOUGH_CORES or device in _beside or (device, False) in _ready:
        return

    def heard(label: str, done: int, total: int | None) -> None:
        if progress is not None and device in _awaited:
            progress(label, done, total)

    pool = ThreadPoolExecutor(1, thread_name_prefix=THREADS)
    _beside[device] = pool.submit(_precompile, device, heard)
    pool.shutdown(wait=False)


def _precompile(device: str, progress: Progress | None, *, everything: bool = False) -> int:
    if {(device, everything), (device, True)} & _ready:
        return 0
    loads = _prepared_loads(device, everything=everything)
    compiled = load_modules(
        loads, what="render kernels", threads=min(MAX_THREADS, available_threads()), progress=progress
    )
    _ready.add((device, everything))
    return len(compiled)


def cold_modules(device: str) -> list[str]:
    """Return the names of the modules that the first image on a device would compile."""
    loads = _prepared_loads(device)
    return [load.module.name for load in loads if not load.is_cached()]


def _prepared_loads(device: str, *, everything: bool = False) -> list[ModuleLoad]:
    """Return `module_loads`, with the options of all modules set, also of those that compile at their first launch.

    Else the cache would have these under other names than those that were compiled with everything else.
    """
    target = wp.get_device(device)
    every = module_loads(target, everything=True)
    for load in every:
        without_bfloat16(load.module)
    return every if everything else module_loads(target)


def module_loads(target: wp.Device, *, everything: bool = False) -> list[ModuleLoad]:
    """List the modules that rendering on a device needs, each for the device where it runs."""
    cuda, cpu = target.is_cuda, target if target.is_cpu else wp.get_device("cpu")
    block = CUDA_BLOCK if cuda else 1
    # Several kernels share the module of labels.
    loads = [
        ModuleLoad(wavefront.shade.module, target, wavefront.BLOCK, 12.0)
        if cuda
        else ModuleLoad(cpu_path.add_samples.module, target, block, 4.5),
        ModuleLoad(label_kernels.label_pixels.module, target, block, 3.0),
        ModuleLoad(wavelet_denoiser.atrous_pass.module, target, block, 1.0),
        ModuleLoad(tone_map.tone_map_pixels.module, target, block, 0.3),
    ]
    if not cuda:
        loads.append(ModuleLoad(label_tiles.label_tiles.module, target, block, 1.0))
    if everything:
        loads.append(ModuleLoad(parts.tell_parts_apart.module, target, block, 3.0))
        loads.append(ModuleLoad(label_boxes.label_boxes.module, target, block, 0.3))
    # Transforms of instances are set, BVHs built and images compressed on the CPU for either device.
    on_host = [build.build_tree, instance_transforms.set_instance_transforms, deflate_runs]
    on_host += [compress.compress_tree] * cuda
    on_host += [forest.build_forest] * everything
    return loads + [ModuleLoad(kernel.module, cpu, seconds=0.3) for kernel in on_host]


def without_bfloat16(module: wp.Module) -> None:
    """Compile a module without bfloat16, which no kernel uses: Warp's headers precompile in a third less time."""
    if wp.get_module_options(module)["cpu_compiler_flags"] is None:
        flags = wp.config.cpu_compiler_flags
        flags = "-march=native" if flags is None else flags
        wp.set_module_options({"cpu_compiler_flags": f"{flags} -DWP_NO_BFLOAT16="}, module)
