"""Compile the kernels that stepping needs on several threads, and report progress."""

from __future__ import annotations

import gc
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from usdsdg.kernels.compilation import ModuleLoad, Progress, kernel_modules, load_modules
from usdsdg.parallel import available_threads

if TYPE_CHECKING:
    import newton
    import warp as wp

WHAT = "physics kernels"
# Modules that every scene needs on the CPU, with what compiling them takes [s]. Others compile at their first launch.
_MODULES = {
    "newton._src.solvers.steel.kernels": 9.0,
    "newton._src.solvers.steel.friction_patches": 2.5,
    "newton._src.sim.articulation": 1.3,
    "newton._src.solvers.steel.kernels.kinematics": 1.0,
    "usdsdg_physics.queries.overlap_kernels": 1.0,
    "usdsdg_physics.solver.sweep_kernels": 1.0,
    "usdsdg_physics.corrections.overlaps.squeezes_kernels": 0.6,
    "usdsdg_physics.guards.tunneling_guard_kernels": 0.5,
    "usdsdg_physics.corrections.bodies.stabilization_kernels": 0.5,
    "usdsdg_physics.corrections.contacts.impacts_kernels": 0.5,
    "usdsdg_physics.corrections.contacts.far_ends_kernels": 0.5,
    "usdsdg_physics.corrections.bodies.free_flight_kernels": 0.5,
    "newton._src.solvers.steel.kernels.inverse_dynamics": 0.4,
    "newton._src.solvers.steel.kernels.mass_dynamics": 0.4,
    "newton._src.solvers.steel.solver_steel": 0.4,
    "usdsdg_physics.solver.separated_pairs_kernels": 0.5,
    "usdsdg_physics.solver.sweep_pairs_kernels": 0.5,
    "usdsdg_physics.solver.response_kernels": 0.4,
}
# Newton's narrow phase has several modules, named by their options; by parts of names.
_NARROW_PHASE = {"gjk_mpr": 7.0, "mesh_tri": 6.0, "primitive": 2.5}
# With gradients, which are not needed, this module alone takes three times as long.
_WITHOUT_GRADIENTS = "newton._src.sim.articulation"

# Newton's broad phase of 64 to 512 shapes sorts with one of three kernels, each launched with as many threads.
_SORTS = (128, 256, 512)

_DEFAULT_BLOCK = 256  # threads of a launch that does not say how many
MAX_COMPILERS, MAX_CUDA_COMPILERS = 4, 16

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
    import usdsdg_physics.corrections.contacts.far_ends_kernels
    import usdsdg_physics.corrections.contacts.impacts_kernels
    import usdsdg_physics.corrections.overlaps.squeezes_kernels
    import usdsdg_physics.guards.tunneling_guard_kernels
    import usdsdg_physics.queries.overlap_kernels
    import usdsdg_physics.solver.response_kernels
    import usdsdg_physics.solver.separated_pairs_kernels

    with suppress(ImportError):  # another version of Newton has its functions elsewhere
        import usdsdg_physics.solver.sweep_kernels
        import usdsdg_physics.solver.sweep_pairs_kernels  # noqa: F401

    # Only once: Warp takes any setting for a change, and reads all kernels of the module again.
    module = sys.modules.get(_WITHOUT_GRADIENTS)
    if module is not None and wp.get_module_options(module)["enable_backward"] is not False:
        wp.set_module_options({"enable_backward": False}, module)


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
    # Newton generates its narrow phase for the shapes of a scene, triangle meshes or none, and the arguments of its
    # first launch.
    with _launches_noted() as noted:
        pipeline.collide(pipeline.model.state(), pipeline.contacts())
    modules = dict.fromkeys([*modules, *(kernel.module for kernel, _ in noted)])
    loads = [ModuleLoad(module, device, seconds=_seconds(module)) for module in modules]
    load_modules(loads, what=WHAT, threads=min(MAX_COMPILERS, available_threads()), progress=progress)


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
    loads = [ModuleLoad(module, device, block, seconds=_seconds(module)) for (_, _, block), module in variants.items()]
    if is_first:
        # Queries look at few shapes, so they stay on the CPU.
        queries = wp.get_module("usdsdg_physics.queries.overlap_kernels")
        loads.append(ModuleLoad(queries, wp.get_device("cpu"), seconds=_seconds(queries)))
    load_modules(loads, what=WHAT, threads=min(MAX_CUDA_COMPILERS, available_threads()), progress=progress)


def load_all_kernels(device: str | None, *, progress: Progress | None = None) -> None:
    """Compile, or load from Warp's cache, also those of our kernels that only some scenes need."""
    import warp as wp

    target, cpu = wp.get_device(device), wp.get_device("cpu")
    on_target = [
        each for room in ("corrections", "guards", "world") for each in kernel_modules(f"usdsdg_physics.{room}")
    ]
    on_cpu = kernel_modules("usdsdg_physics.queries")
    if target.is_cpu:
        on_cpu += kernel_modules("usdsdg_physics.solver")
    block = _DEFAULT_BLOCK if target.is_cuda else 1
    loads = [ModuleLoad(module, target, block, _seconds(module)) for module in on_target]
    loads += [ModuleLoad(module, cpu, 1, _seconds(module)) for module in on_cpu]
    if target.is_cuda:  # on the CPU `sweep_pairs_alone` sorts
        loads += [ModuleLoad(module, target, size) for size, module in sort_modules().items()]
    load_modules(loads, what=WHAT, threads=min(MAX_COMPILERS, available_threads()), progress=progress)


def sort_modules() -> dict[int, wp.Module]:
    """Return the modules of the broad phase's sorts, by their number of shapes and threads.

    Each collision pipeline makes its own, of the same name and content, so that it finds these in the cache.
    """
    with suppress(ImportError):  # another version of Newton has it elsewhere
        from newton._src.geometry.broad_phase_sap import _create_tile_sort_kernel

        return {size: _create_tile_sort_kernel(size).module for size in _SORTS}
    return {}


def _seconds(module: wp.Module) -> float:
    """Return about how long a module compiles [s]."""
    if "narrow_phase" in module.name:
        return next((seconds for part, seconds in _NARROW_PHASE.items() if part in module.name), 1.0)
    return _MODULES.get(module.name, 0.5)


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
