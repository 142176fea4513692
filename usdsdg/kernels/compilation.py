"""Load Warp's modules of kernels: from Warp's cache, or compiled into it on several threads, with progress."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from usdsdg.errors import counted
from usdsdg.kernels import cache

if TYPE_CHECKING:
    import warp as wp

# Called with a label, the number of units done, and the total (None when it is unknown).
Progress = Callable[[str, int, "int | None"], None]

TICK = 0.5  # s between two reports while compilers are at work
# A module that compiles counts as done up to this share of it, however long it takes.
MOST_UNDER_WAY = 0.9
# Prefix of the names of the threads: the command line does not wait for them when it is interrupted.
THREADS = "usdsdg-compile"


@dataclass(frozen=True, eq=False)
class ModuleLoad:
    """A module to load for a device.

    Attributes:
        block: threads of a block, 1 on a CPU.
        seconds: what compiling it took of one core of an AMD EPYC; only ratios matter, for the order and for progress.
    """

    module: wp.Module
    device: wp.Device
    block: int = 1
    seconds: float = 1.0

    def is_cached(self) -> bool:
        """Return whether Warp's cache has the compiled module; Warp must have been initialized."""
        return cache.is_cached(self.module, self.device, self.block)

    def run(self) -> None:
        """Load it, compiled before if need be.

        Raises:
            OutputNotWritable: there is no room for it in the cache.
        """
        if not self.is_cached():
            cache.check_space()
        self.module.load(self.device, self.block)


def load_modules(
    loads: Sequence[ModuleLoad], *, what: str, threads: int, progress: Progress | None = None
) -> list[ModuleLoad]:
    """Load modules on several threads, those first that take longest to compile; return those that were compiled.

    `progress` hears of `what` only if something must be compiled: how many percent of that are done.
    """
    import warp as wp

    # Makes Warp store Clang's version: threads that ask for it at once may read none, miss the cache and compile again.
    if any(load.device.is_cpu for load in loads):
        wp.get_cpu_kernel_cache_key()
    missing = sorted((load for load in loads if not load.is_cached()), key=lambda load: -load.seconds)
    work = _Work(missing, f"compiling {what} (first use), {counted(len(missing), 'module')}, in percent", progress)
    work.report()
    pool = ThreadPoolExecutor(max(1, threads), thread_name_prefix=THREADS)
    try:
        pending = {pool.submit(work.run, load) for load in [*missing, *(load for load in loads if load not in missing)]}
        while pending:
            done, pending = wait(pending, timeout=TICK, return_when=FIRST_COMPLETED)
            for each in done:
                each.result()
            work.report()
    finally:
        # Do not wait for the compiler after Ctrl-C.
        pool.shutdown(wait=False, cancel_futures=True)
    return missing


def kernel_modules(package: str) -> list[wp.Module]:
    """Return the modules of all kernels in files `*_kernels.py` below a package, which are imported."""
    import warp as wp

    root = Path(str(importlib.import_module(package).__file__)).parent
    names = [".".join([package, *file.relative_to(root).with_suffix("").parts]) for file in root.rglob("*_kernels.py")]
    found = [vars(importlib.import_module(name)).values() for name in sorted(names)]
    return list(dict.fromkeys(each.module for values in found for each in values if isinstance(each, wp.Kernel)))


class _Work:
    """Which modules are compiled, and which are being compiled since when."""

    def __init__(self, missing: Sequence[ModuleLoad], label: str, progress: Progress | None) -> None:
        self._label, self._progress = label, progress if missing else None
        self._total = sum(load.seconds for load in missing)
        self._missing = set(missing)
        self._begun: dict[ModuleLoad, float] = {}
        self._took: dict[ModuleLoad, float] = {}
        self._reported = -1

    def run(self, load: ModuleLoad) -> None:
        begun = self._begun[load] = time.monotonic()
        load.run()
        self._took[load] = time.monotonic() - begun

    def report(self) -> None:
        """Report the percentage, if it has changed."""
        if self._progress is None:
            return
        percent = int(100 * self._done(time.monotonic()) / self._total)
        if percent > self._reported:
            self._reported = percent
            self._progress(self._label, percent, 100)

    def _done(self, now: float) -> float:
        """Return the sum of `seconds` that are done, with those under way by the pace of those that have ended."""
        took = {load: seconds for load, seconds in self._took.copy().items() if load in self._missing}
        if len(took) == len(self._missing):
            return self._total
        done = sum(load.seconds for load in took)
        pace = done / sum(took.values()) if took else 1.0
        for load, begun in self._begun.copy().items():
            if load in self._missing and load not in took:
                done += min((now - begun) * pace, MOST_UNDER_WAY * load.seconds)
        return done
