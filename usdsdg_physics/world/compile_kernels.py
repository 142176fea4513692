"""Compile the kernels that stepping needs on several threads, and report progress."""

from __future__ import annotations

import gc
import os
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import newton
    import warp as wp

# Called with a label, the number of units done, and the total (None when it is unknown).
Progress = Callable[[str, int, int | None], None]

LABEL = "compiling physics kernels (first use)"
# Modules that take long to compile, longest first. Those not listed compile at their first launch.
_MODULES = (
    "newton._src.solvers.steel.kernels",
    "newton._src.solvers.steel.friction_patches",
    "usdsdg_physics.queries.overlap_kernels",
    "newton._src.sim.articulation",
    "usdsdg_physics.solver.sweep_kernels",
    "usdsdg_physics.corrections.bodies.stabilization_kernels",
    "usdsdg_physics.corrections.contacts.tunneling_guard_kernels",
    "newton._src.solvers.steel.solver_steel",
    "usdsdg_physics.corrections.bodies.free_flight_kernels",
    "usdsdg_physics.corrections.contacts.impacts_kernels",
    "usdsdg_physics.solver.response_kernels",
    "usdsdg_physics.solver.separated_pairs_kernels",
    "usdsdg_physics.corrections.contacts.squeezes_kernels",
)
# With gradients, which are not needed, this module alone takes three times as long.
_WITHOUT_GRADIENTS = "newton._src.sim.articulation"

# Modules of this name take long to compile on CUDA; the others begin after them.
_SLOW = "narrow_phase"
_DEFAULT_BLOCK = 256  # threads of a launch that does not say how many
MAX_CUDA_COMPILERS = 16

# Devices whose kernels are loaded, and whether those of triangle meshes are: Warp keeps them for the whole process.
_loaded: set[tuple[str, bool]] = set()
# Likewise on CUDA, where a module is compiled for each number of threads in a block.
_loaded_variants: set[tuple[str, str, int]] = set()


def prepare_newton() -> None:
    """Import Newton and our kernels, and set the options that they are compiled with."""
    _import_newton()
    import warp as wp

    import usdsdg_physics.corrections.bodies.free_flight_kernels
    import usdsdg_physics.corrections.bodies.stabilization_kernels
    import usdsdg_physics.corrections.contacts.impacts_kernels
    import usdsdg_physics.corrections.contacts.squeezes_kernels
    import usdsdg_physics.corrections.contacts.tunneling_guard_kernels
    import usdsdg_physics.queries.overlap_kernels
    import usdsdg_physics.solver.response_kernels
    import usdsdg_physics.solver.separated_pairs_kernels

    with suppress(ImportError):  # another version of Newton has its functions elsewhere
        import usdsdg_physics.solver.sweep_kernels  # noqa: F401

    if _WITHOUT_GRADIENTS in sys.modules:
        wp.set_module_options({"enable_backward": False}, module=sys.modules[_WITHOUT_GRADIENTS])


def _import_newton() -> None:
    """Import Newton with the garbage collector off, and keep its objects out of later collections.

    Newton makes half a million objects that stay. Collections during its import take 0.8 s of 2, and each full one
    after it 0.2 s, in the middle of a frame.
    """
    if "newton" in sys.modules:
        return
    was_on = gc.isenabled()
    gc.collect()  # what is garbage now would be kept forever
    gc.disable()
    try:
        import newton  # noqa: F401

        gc.freeze()
    finally:
        if was_on:
            gc.enable()


def load_kernels(pipeline: newton.CollisionPipeline, *, progress: Progress | None = None) -> None:
    """Compile, or load from Warp's cache, what stepping with this collision pipeline needs on the CPU.

    On CUDA a module has variants that are chosen at launch: see `load_launched_kernels`.
    """
    import newton
    import warp as wp

    device = pipeline.device
    if device.is_cuda:
        return
    types = pipeline.model.shape_type
    has_meshes = types is not None and bool((types.numpy() == int(newton.GeoType.MESH)).any())
    is_first = not _loaded & {(str(device), False), (str(device), True)}
    if not is_first and (not has_meshes or (str(device), True) in _loaded):
        return
    _loaded.add((str(device), has_meshes))
    # A name that this version of Newton does not have gives an empty module.
    modules = [module for module in map(wp.get_module, _MODULES) if module.kernels] if is_first else []
    tasks: list[Callable[[], object]] = [partial(wp.load_module, module, device) for module in modules]
    # Newton generates its narrow phase for the shapes of a scene, triangle meshes or none, and the arguments of its
    # first launch.
    tasks.insert(1, lambda: pipeline.collide(pipeline.model.state(), pipeline.contacts()))
    _run(tasks, threads=2, progress=progress)


def load_launched_kernels(launch: Callable[[], object], device: wp.Device, *, progress: Progress | None = None) -> None:
    """Compile, or load from Warp's cache, the kernels that `launch()` launches on a CUDA device; none of them runs."""
    import warp as wp

    variants: dict[tuple[str, str, int], wp.Module] = {}
    with _launches_noted() as noted:
        launch()
    for kernel, block in noted:
        key = (str(device), kernel.module.name, block)
        if key not in _loaded_variants:
            variants.setdefault(key, kernel.module)
    if not variants:
        return
    is_first = not any(name == str(device) for name, _, _ in _loaded_variants)
    _loaded_variants.update(variants)
    tasks: list[Callable[[], object]] = [
        partial(wp.load_module, module, device, block_dim=block)
        for (_, name, block), module in sorted(variants.items(), key=lambda item: _SLOW not in item[0][1])
    ]
    if is_first:
        # Queries look at few shapes, so they stay on the CPU.
        tasks.insert(0, partial(wp.load_module, "usdsdg_physics.queries.overlap_kernels", "cpu"))
    _run(tasks, threads=min(MAX_CUDA_COMPILERS, os.cpu_count() or 1), progress=progress)


@contextmanager
def _launches_noted() -> Iterator[list[tuple[wp.Kernel, int]]]:
    """Within it, this thread's launches are noted, as kernel and threads of a block, instead of taking place."""
    import warp as wp

    noted: list[tuple[wp.Kernel, int]] = []
    owner = threading.get_ident()
    real = {name: getattr(wp, name) for name in ("launch", "launch_tiled")}

    def noting(real_launch: Callable[..., object]) -> Callable[..., object]:
        def launch(
            kernel: wp.Kernel,
            dim: object,
            inputs: Sequence[object] = (),
            outputs: Sequence[object] = (),
            *args: object,
            block_dim: int | None = None,
            **options: object,
        ) -> object:
            if threading.get_ident() != owner:
                return real_launch(kernel, dim, inputs, outputs, *args, block_dim=block_dim, **options)
            if kernel.is_generic:
                kernel.add_overload(kernel.infer_argument_types([*inputs, *outputs]))
            noted.append((kernel, block_dim or _DEFAULT_BLOCK))
            return None

        return launch

    for name, function in real.items():
        setattr(wp, name, noting(function))
    try:
        yield noted
    finally:
        for name, function in real.items():
            setattr(wp, name, function)


def _run(tasks: Sequence[Callable[[], object]], *, threads: int, progress: Progress | None) -> None:
    """Run tasks on a few threads, and report how many are done."""
    if progress:
        progress(LABEL, 0, len(tasks))
    pool = ThreadPoolExecutor(max_workers=threads, thread_name_prefix="usdsdg-compile")
    try:
        for done, task in enumerate(as_completed([pool.submit(task) for task in tasks]), start=1):
            task.result()
            if progress:
                progress(LABEL, done, len(tasks))
    finally:
        # Do not wait for compilers after Ctrl-C.
        pool.shutdown(wait=False, cancel_futures=True)
