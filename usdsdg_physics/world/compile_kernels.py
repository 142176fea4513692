"""Compile the kernels that stepping needs on two threads, and report progress."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import newton

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
    "usdsdg_physics.corrections.stabilization_kernels",
    "usdsdg_physics.corrections.tunneling_guard_kernels",
    "newton._src.solvers.steel.solver_steel",
    "usdsdg_physics.corrections.free_flight_kernels",
    "usdsdg_physics.corrections.impacts_kernels",
    "usdsdg_physics.solver.response_kernels",
    "usdsdg_physics.solver.separated_pairs_kernels",
    "usdsdg_physics.corrections.squeezes_kernels",
)
# With gradients, which are not needed, this module alone takes three times as long.
_WITHOUT_GRADIENTS = "newton._src.sim.articulation"

# Devices whose kernels are loaded, and whether those of triangle meshes are: Warp keeps them for the whole process.
_loaded: set[tuple[str, bool]] = set()


def prepare_newton() -> None:
    """Import Newton and our kernels, and set the options that they are compiled with."""
    _import_newton()
    import warp as wp

    import usdsdg_physics.corrections.free_flight_kernels
    import usdsdg_physics.corrections.impacts_kernels
    import usdsdg_physics.corrections.squeezes_kernels
    import usdsdg_physics.corrections.stabilization_kernels
    import usdsdg_physics.corrections.tunneling_guard_kernels
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
    """Compile, or load from Warp's cache, what stepping with this collision pipeline needs.

    On CUDA a module has variants that are chosen at launch, so each compiles at its first launch; `progress` then gets
    the label without a total.
    """
    import newton
    import warp as wp

    device = pipeline.device
    types = pipeline.model.shape_type
    has_meshes = types is not None and bool((types.numpy() == int(newton.GeoType.MESH)).any())
    is_first = not _loaded & {(str(device), False), (str(device), True)}
    if not is_first and (not has_meshes or (str(device), True) in _loaded):
        return
    _loaded.add((str(device), has_meshes))
    if device.is_cuda:
        if progress:
            progress(LABEL, 0, None)
        return
    # A name that this version of Newton does not have gives an empty module.
    modules = [module for module in map(wp.get_module, _MODULES) if module.kernels] if is_first else []
    tasks: list[Callable[[], object]] = [partial(wp.load_module, module, device) for module in modules]
    # Newton generates its narrow phase for the shapes of a scene, triangle meshes or none, and the arguments of its
    # first launch.
    tasks.insert(1, lambda: pipeline.collide(pipeline.model.state(), pipeline.contacts()))
    if progress:
        progress(LABEL, 0, len(tasks))
    pool = ThreadPoolExecutor(max_workers=2, thread_name_prefix="usdsdg-compile")
    try:
        for done, task in enumerate(as_completed([pool.submit(task) for task in tasks]), start=1):
            task.result()
            if progress:
                progress(LABEL, done, len(tasks))
    finally:
        # Do not wait for compilers after Ctrl-C.
        pool.shutdown(wait=False, cancel_futures=True)
