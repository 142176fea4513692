"""The option `--threads`: the most threads that each pool of the process may have."""

import os
import sys

import click

from usdsdg.cli.options.values import WholeRange

# Libraries read these when they are loaded: NumPy, OpenCV, PyTorch and others.
_OF_LIBRARIES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")

threads_option = click.option(
    "--threads",
    type=WholeRange(min=1),
    help="Threads that render, write files or compile at a time, in USD and other libraries too.",
    show_default="the CPUs that it may use",
)


def limit_threads(count: int | None) -> None:
    """Let each pool have at most `count` threads; call this before NumPy is loaded. None: as many as there are CPUs."""
    if count is None:
        return
    os.environ.update(dict.fromkeys(_OF_LIBRARIES, str(count)))
    from pxr import Work

    # USD starts threads when plugins are registered: a limit of 1 that comes later would let one of them spin for ever.
    has_started = "usdsdg.stage.schemas" in sys.modules
    Work.SetConcurrencyLimit(max(count, 2) if has_started else count)

    from usdsdg import parallel
    from usdsdg.session.session import current
    from usdsdg.writers.backends.io_queue import THREADS

    parallel.limit_threads(count)
    current().io_queue.set_threads(min(THREADS, count))
