"""Python's lock while a frame is made: the thread that makes it has the lock back soon from those that write files."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

# For so long a thread may run Python while others wait [s]; Python's own value is 0.005. A frame gives the lock away in
# each of some hundred calls of native code, and would wait as often.
INTERVAL = 1e-4


@contextmanager
def switching_soon() -> Iterator[None]:
    """Let threads take turns at running Python after `INTERVAL`, unless the program has them do so sooner."""
    before = sys.getswitchinterval()
    if before <= INTERVAL:
        yield
        return
    sys.setswitchinterval(INTERVAL)
    try:
        yield
    finally:
        sys.setswitchinterval(before)
