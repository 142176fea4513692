"""Python's lock while a GPU renders: the thread that makes frames has it back soon from those that write files."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from usdsdg.session.session import current

# For so long a thread may run Python while others wait [s]; Python's own value is 0.005. A frame gives the lock away in
# each of some hundred calls of native code, and would wait as often.
INTERVAL = 1e-4


@contextmanager
def switching_soon() -> Iterator[None]:
    """Let threads take turns at running Python after `INTERVAL`, unless the program has them do so sooner.

    Only where a GPU renders: on CPUs the kernels take the cores, and switching often costs a few percent. A renderer
    that is not there yet is not made for that.
    """
    before, renderer = sys.getswitchinterval(), current().engines.renderer
    if before <= INTERVAL or renderer is None or renderer.device == "cpu":
        yield
        return
    sys.setswitchinterval(INTERVAL)
    try:
        yield
    finally:
        sys.setswitchinterval(before)
