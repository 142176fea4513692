"""Asks a store again that does not answer, for as long as it may take to come back."""

from __future__ import annotations

import os
import random
import time
from collections.abc import Callable
from typing import TypeVar

from usdsdg.errors import StoreError, warn_once
from usdsdg.stores.failures import Failure

RETRY_SECONDS = 120.0
VARIABLE = "USDSDG_STORE_RETRY_SECONDS"
_FIRST_PAUSE, _LONGEST_PAUSE = 0.1, 5.0  # seconds
QUIET_SECONDS = 1.0  # seconds without an answer that nobody is told of

T = TypeVar("T")


class Unanswered(Exception):
    """A request failed in a way that may pass."""

    def __init__(self, failure: Failure, cause: Exception) -> None:
        super().__init__(failure.reason)
        self.failure, self.cause = failure, cause


def retry_seconds() -> float:
    """Return how long a store that does not answer is asked again [s].

    Raises:
        StoreError: the environment has something else than a number of seconds.
    """
    text = os.environ.get(VARIABLE, "")
    try:
        seconds = float(text or RETRY_SECONDS)
    except ValueError:
        seconds = -1.0
    if not 0 <= seconds < float("inf"):
        raise StoreError(f"{VARIABLE} is {text!r}; expected a number of seconds, as 120.")
    return seconds


def patiently(attempt: Callable[[], T], *, seconds: float, url: str) -> T:
    """Return what `attempt` returns, which is called again while it raises `Unanswered`; raise its last one.

    What takes longer than a second is warned of, so that nobody waits without knowing for what.
    """
    start, pause = time.monotonic(), _FIRST_PAUSE
    while True:
        try:
            return attempt()
        except Unanswered as unanswered:
            left = start + seconds - time.monotonic()
            if left <= 0:
                raise
            if time.monotonic() - start > QUIET_SECONDS:
                warn_once(
                    f"{url} is asked again for up to {seconds:.0f} s, since {unanswered.failure.reason}. "
                    f"{VARIABLE} changes how long."
                )
        # Workers that lost the same store do not come back all at once.
        time.sleep(min(left, pause * random.uniform(0.5, 1.0)))
        pause = min(pause * 2, _LONGEST_PAUSE)
