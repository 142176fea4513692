"""Have Newton make the kernels of its narrow phase once in a process."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from functools import wraps

_MODULE = "newton._src.geometry.narrow_phase"
_USER = "newton._src.sim.collide"
# What Newton would choose on CUDA by the kinds and number of shapes; each combination would compile for half a minute.
_ONE_CHOICE = {"use_lean_gjk_mpr": False, "split_gjk_mpr": True, "sparse_gjk_pairs": True}
_CONVEX = "create_narrow_phase_kernel_gjk_mpr"
_PREFIXES = ("create_", "_create_")

_made: dict[Hashable, object] = {}  # by function and arguments


@contextmanager
def narrow_phase_kernels_made_once() -> Iterator[None]:
    """Within it, Newton's collision pipelines share kernels that are made from the same arguments.

    Newton makes its narrow phase anew for each pipeline, hashes all that it calls and loads it, although the kernels
    are equal: a third of the time in which a scene of 300 bodies is built. A version of Newton without these functions
    makes them as it does.
    """
    import importlib

    try:
        module = importlib.import_module(_MODULE)
    except ImportError:
        yield
        return
    functions = {
        name: function
        for name, function in vars(module).items()
        if name.startswith(_PREFIXES) and getattr(function, "__module__", "").startswith("newton.")
    }
    for name, function in functions.items():
        setattr(module, name, _once(function))
    try:
        yield
    finally:
        for name, function in functions.items():
            setattr(module, name, function)


@contextmanager
def narrow_phase_of_fast_hulls() -> Iterator[None]:
    """Within it, pipelines on the CPU look at several corners of a hull at a time, to the same bits.

    A quarter of the narrow phase's time; versions of Newton that have its functions elsewhere go without.
    """
    import importlib

    try:
        module = importlib.import_module(_MODULE)
        from usdsdg_physics.solver.hull_corners import support_with_fast_hulls
    except ImportError:
        yield
        return
    real, slow = getattr(module, _CONVEX, None), getattr(module, "support_map", None)
    if real is None or slow is None or "support_func" not in inspect.signature(real).parameters:
        yield
        return

    def create(*args: object, support_func: object = None, **options: object) -> object:
        return real(*args, support_func=support_with_fast_hulls if support_func is slow else support_func, **options)

    setattr(module, _CONVEX, create)
    try:
        yield
    finally:
        setattr(module, _CONVEX, real)


@contextmanager
def narrow_phase_of_one_kind() -> Iterator[None]:
    """Within it, Newton's collision pipelines on CUDA use the same kernels for all scenes without triangle meshes."""
    import importlib

    try:
        module = importlib.import_module(_USER)
    except ImportError:
        yield
        return
    real = getattr(module, "NarrowPhase", None)
    if real is None:
        yield
        return
    known = inspect.signature(real).parameters
    choice = {name: value for name, value in _ONE_CHOICE.items() if name in known}
    module.__dict__["NarrowPhase"] = lambda **options: real(**{**options, **choice})
    try:
        yield
    finally:
        module.__dict__["NarrowPhase"] = real


def _once(make: Callable[..., object]) -> Callable[..., object]:
    """Return a function that returns what it returned for the same arguments before."""

    @wraps(make)
    def made(*args: object, **options: object) -> object:
        key = (make, args, tuple(sorted(options.items())))
        try:
            known = key in _made
        except TypeError:  # an argument without a hash
            return make(*args, **options)
        if not known:
            _made[key] = make(*args, **options)
        return _made[key]

    return made
