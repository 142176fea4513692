"""Ctrl-C within a frame of the main thread: other threads capture none until it is known whether that ends the run.

A frame that was cut off ends the journal where the run ends with it. Where the script goes on, the frame counts with
the files that it has, and a whole frame of another thread would say that it did.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from usdsdg.session.turns import turns

# A script that catches Ctrl-C may wait for its threads without another frame of its own; an interrupt that ends the
# run has told so long before.
SECONDS = 1.0


class InterruptedFrame:
    """When a frame of the main thread was cut off, until that thread captures again."""

    def __init__(self) -> None:
        self._since: float | None = None

    @contextmanager
    def noticed(self) -> Iterator[None]:
        """Capture a frame, in turn; in another thread, once the main thread has got over an interrupt."""
        if threading.current_thread() is not threading.main_thread():
            self._wait()
            yield
            return
        self._since = None
        try:
            yield
        except KeyboardInterrupt:
            self._since = time.monotonic()
            raise

    def _wait(self) -> None:
        while (since := self._since) is not None and time.monotonic() - since < SECONDS:
            with turns.set_aside():
                time.sleep(0.01)
