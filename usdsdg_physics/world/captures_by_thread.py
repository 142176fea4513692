"""Keep what one thread records on the CPU apart from what other threads launch meanwhile."""

import threading
from functools import cache

# Of Warp's runtime: the capture on the CPU that is under way, and its graph.
_NAMES = ("_apic_capture", "_apic_graph")


@cache
def keep_captures_by_thread() -> None:
    """Let launches see a capture on the CPU only if their own thread has begun it.

    Warp's native code records the launches of that thread alone, but its Python code finds the capture in the runtime
    from every thread, and registers the arrays and kernels of all of them with it. Registering is not synchronized: an
    array of another thread may get the number of one that the record writes to, and a replay then fails or writes into
    memory that is not its own. Frames are rendered on other threads while physics records a step.

    Raises:
        RuntimeError: this version of Warp keeps captures elsewhere.
    """
    import warp as wp

    wp.init()
    runtime = wp._src.context.runtime
    if missing := [name for name in _NAMES if name not in vars(runtime)]:
        raise RuntimeError(f"this version of Warp has no {missing[0]}, by which captures are kept apart")
    for name in _NAMES:
        setattr(type(runtime), name, _OfThread())


class _OfThread:
    """An attribute with a value in each thread, None until it is set there."""

    def __init__(self) -> None:
        self._values = threading.local()

    def __get__(self, instance: object, owner: type | None = None) -> object:
        return getattr(self._values, "value", None)

    def __set__(self, instance: object, value: object) -> None:
        self._values.value = value
