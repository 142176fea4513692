"""Parallel work on CPU threads, in bands of rows; kernels release Python's lock while they run."""

import threading
from collections.abc import Callable, Sequence
from queue import SimpleQueue
from typing import Any

from usdsdg.operating_system import around_fork, usable_cores

BAND_ROWS = 8
# Rows of a band of cheap pixels, as those of filters: fewer pixels cost more to hand out than they take.
CHEAP_PIXELS = 1 << 14
# Bands shrink to `band_rows` toward the end, from this many times that: few launches, and threads that end together.
LARGEST_BAND = 4
# Threads of a CUDA block: larger blocks leave the path tracer too few registers. On a CPU, blocks have one thread.
CUDA_BLOCK = 64

Band = Callable[[int, int], None]

_limit: int | None = None


def available_threads() -> int:
    """Return how many threads work may be spread over: the CPUs that this process may use, `limit_threads` at most."""
    return usable_cores() if _limit is None else min(usable_cores(), _limit)


def limit_threads(count: int | None) -> None:
    """Let at most `count` threads work at a time, from now on; None: as many as there are CPUs."""
    global _limit
    _limit = None if count is None else max(1, count)


def for_bands(rows: int, band: Band, *, band_rows: int = BAND_ROWS, threads: int | None = None) -> None:
    """Call `band(first_row, row_count)` for all rows, from several threads, this one among them.

    Bands are handed out as threads become free, of `band_rows` at least but for the last. An exception (or Ctrl-C)
    stops the rest: bands that have begun are finished, no other one is started, and the exception is raised here.
    """
    threads = threads or available_threads()
    work = _Bands(rows, band, band_rows, threads)
    helpers = min(threads, -(-rows // band_rows)) - 1
    if helpers > 0:
        _helpers.call(work.help, helpers)
    try:
        work.run()
    finally:
        work.finish()
    work.raise_failure()


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
        band_rows: rows of the smallest bands; see `cheap_rows`.
    """

    import warp as wp

    def launch(rows: int, first_row: int, *, record: bool = False) -> Any:
        return wp.launch(
            kernel,
            dim=(rows, *shape[1:]),
            inputs=[*inputs, first_row],
            outputs=outputs,
            device=device,
            block_dim=CUDA_BLOCK,
            record_cmd=record,
        )

    recorded = threading.local()

    def band(first_row: int, rows: int) -> None:
        # Packing the arguments takes longer than many a band: a thread does it once.
        if not hasattr(recorded, "launch"):
            recorded.launch = launch(rows, first_row, record=True)
        recorded.launch.set_dim((rows, *shape[1:]))
        recorded.launch.set_param_at_index(len(inputs), first_row)
        recorded.launch.launch()

    if 0 in shape:
        return
    if device == "cpu":
        # Warp unloads a kernel's code once nothing refers to it, and a recorded launch may refer to code that another
        # thread has loaded since: so this call refers to it until all bands are done.
        code = load_on_cpu(kernel)
        for_bands(shape[0], band, band_rows=band_rows, threads=threads)
        del code
    else:
        launch(shape[0], 0)


def load_on_cpu(kernel: Any) -> Any:
    """Load the code of a kernel for the CPU and return it; threads wait for the one that compiles or loads it."""
    import warp as wp

    with _loading.lock:
        return kernel.module.load(wp.get_device("cpu"), 1)


def cheap_rows(width: int) -> int:
    """Return the `band_rows` of kernels that take little time for each of the `width` pixels of a row."""
    return max(1, CHEAP_PIXELS // max(1, width))


class Later:
    """A call that another thread makes, after earlier ones."""

    def __init__(self, call: Callable[[], None]) -> None:
        self._call, self._ended = call, threading.Event()
        self._failure: BaseException | None = None
        _open.add(self)
        _background.call(self._run, 1)

    def wait(self) -> None:
        """Wait for its end, and raise its failure."""
        self.join()
        if self._failure is not None:
            raise self._failure

    def join(self) -> None:
        """Wait for its end, however it ends."""
        # Without a timeout, Ctrl-C would not interrupt the wait on every platform.
        while not self._ended.wait(timeout=0.5):
            pass

    def _run(self) -> None:
        try:
            self._call()
        except BaseException as error:  # noqa: BLE001 - raised by those who wait
            self._failure = error
        del self._call  # with what it keeps alive
        _open.discard(self)
        self._ended.set()


class _Bands:
    """Rows that threads take band by band, and the first failure of a band."""

    def __init__(self, rows: int, band: Band, least: int, threads: int) -> None:
        self._rows, self._band, self._least, self._threads = rows, band, least, threads
        self._next = 0
        self._helping = 0
        self._failure: BaseException | None = None
        # Taken by itself: the `with` of a Condition is Python code, in which Ctrl-C can leave it taken for ever.
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)

    def run(self) -> None:
        """Work until no row is left."""
        while (taken := self._take()) is not None:
            self._band(*taken)

    def help(self) -> None:
        """As `run`, on another thread, which keeps its failure for the one that has asked."""
        with self._lock:
            self._helping += 1
        try:
            self.run()
        except BaseException as error:  # noqa: BLE001 - raised by the thread that has asked
            self._stop(error)
        finally:
            with self._lock:
                self._helping -= 1
                self._changed.notify_all()

    def finish(self) -> None:
        """Hand out no more rows, and wait for those who work; a helper that is late finds nothing to do."""
        self._stop(None)
        with self._lock:
            while self._helping:
                # Without a timeout, Ctrl-C would not interrupt the wait on every platform.
                self._changed.wait(timeout=0.5)

    def raise_failure(self) -> None:
        if self._failure is not None:
            raise self._failure

    def _stop(self, failure: BaseException | None) -> None:
        with self._lock:
            self._next = self._rows
            self._failure = self._failure or failure

    def _take(self) -> tuple[int, int] | None:
        """Return the first row and the count of the next band; None: no row is left."""
        with self._lock:
            first, left = self._next, self._rows - self._next
            if left <= 0:
                return None
            fair = min(left // (2 * self._threads), LARGEST_BAND * self._least)
            count = min(left, max(fair, self._least))
            self._next += count
            return first, count


class _Helpers:
    """Threads that make calls, first in, first out. Daemons, so that they still work while the program ends."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._calls: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._threads = 0
        self._lock = threading.Lock()

    def call(self, function: Callable[[], None], times: int) -> None:
        """Call `function` on so many threads, each as soon as it is free; it must raise nothing."""
        with self._lock:
            while self._threads < times:
                name = f"{self._name}-{self._threads}"
                threading.Thread(target=self._work, args=(self._calls,), name=name, daemon=True).start()
                self._threads += 1
        for _ in range(times):
            self._calls.put(function)

    def forget(self) -> None:
        """Begin anew, without the threads."""
        self.__init__(self._name)

    @staticmethod
    def _work(calls: SimpleQueue) -> None:
        while True:
            call = calls.get()
            call()
            del call  # with the arrays that it keeps alive


class _Loading:
    """One thread at a time loads code."""

    def __init__(self) -> None:
        self.lock = threading.Lock()


_loading = _Loading()
_helpers, _background = _Helpers("usdsdg"), _Helpers("usdsdg-later")
_open: set[Later] = set()  # those that have not ended


def _end_all() -> None:
    for each in tuple(_open):
        each.join()


# A forked process has none of its parent's threads, and would wait for them for ever.
around_fork(before=_end_all, in_child=_helpers.forget)
around_fork(in_child=_background.forget)
around_fork(in_child=_loading.__init__)
