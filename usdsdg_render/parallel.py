"""Work spread over CPU threads in bands of rows; kernels run outside Python's lock, so threads share it."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from functools import lru_cache

BAND_ROWS = 8

Band = Callable[[int, int], None]


def available_threads() -> int:
    """CPUs that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@lru_cache(maxsize=4)
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="usdsdg-render")


def for_bands(rows: int, band: Band, *, band_rows: int = BAND_ROWS, threads: int | None = None) -> None:
    """Call `band(first_row, row_count)` until all rows are done, from several threads.

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
        # Waking up now and then lets Ctrl-C through on every platform.
        while wait(futures, timeout=0.5, return_when=FIRST_EXCEPTION).not_done:
            if any(future.done() and future.exception() for future in futures):
                break
    finally:
        for _ in queue:
            pass
        wait(futures)
    for future in futures:
        future.result()
