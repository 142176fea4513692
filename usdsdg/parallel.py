"""Parallel work on CPU threads, in bands of rows; kernels release Python's lock while they run."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from functools import lru_cache
from typing import Any

BAND_ROWS = 8
# Threads of a CUDA block: larger blocks leave the path tracer too few registers. On a CPU, blocks have one thread.
CUDA_BLOCK = 64

Band = Callable[[int, int], None]


def available_threads() -> int:
    """Return the number of CPUs that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@lru_cache(maxsize=4)
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="usdsdg")


def for_bands(rows: int, band: Band, *, band_rows: int = BAND_ROWS, threads: int | None = None) -> None:
    """Call `band(first_row, row_count)` for all rows, from several threads.

    Bands are handed out as threads become free. An exception (or Ctrl-C) stops the rest: bands that have begun are
    finished, no other one is started, and the exception is raised here.
    """
    threads = threads or available_threads()
    firsts = range(0, rows, band_rows)
    if threads == 1 or len(firsts) == 1:
        for first in firsts:
            band(first, min(band_rows, rows - first))
        return
    queue = iter(firsts)

    def work() -> None:
        # next() on a range iterator is atomic under Python's lock.
        for first in queue:
            band(first, min(band_rows, rows - first))

    futures = [_pool(threads).submit(work) for _ in range(min(threads, len(firsts)))]
    try:
        # Without a timeout, Ctrl-C would not interrupt the wait on every platform.
        while wait(futures, timeout=0.5, return_when=FIRST_EXCEPTION).not_done:
            if any(future.done() and future.exception() for future in futures):
                break
    finally:
        for _ in queue:
            pass
        wait(futures)
    for future in futures:
        future.result()


def launch_rows(
    kernel: Any,
    shape: tuple[int, ...],
    inputs: Sequence[Any],
    outputs: Sequence[Any],
    *,
    device: str,
    threads: int | None = None,
    band_rows: int = BAND_ROWS,
) -> None:
    """Launch a kernel over an array: in one launch on CUDA, in bands of rows over threads on a CPU.

    Args:
        kernel: its thread indices range over `shape`; its last input is the first row of the band, which it must add
            to the first index.
        inputs: all inputs except that last one.
    """

    import warp as wp

    def band(first_row: int, rows: int) -> None:
        wp.launch(
            kernel,
            dim=(rows, *shape[1:]),
            inputs=[*inputs, first_row],
            outputs=outputs,
            device=device,
            block_dim=CUDA_BLOCK,
        )

    if device == "cpu":
        for_bands(shape[0], band, band_rows=band_rows, threads=threads)
    elif shape[0] > 0:
        band(0, shape[0])
