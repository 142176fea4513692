"""The time code at which lights, materials and images are read.

One update reads a stage at one time code. Dozens of small readers would only hand it on to the next, so they take it
from this context.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from pxr import Usd

_time: ContextVar[Usd.TimeCode | None] = ContextVar("time code", default=None)  # None: the default time


@contextmanager
def time_context(time: Usd.TimeCode) -> Iterator[None]:
    """Inside, `current_value` reads at `time`."""
    token = _time.set(time)
    try:
        yield
    finally:
        _time.reset(token)


def current_value(attribute: Usd.Attribute) -> Any:
    """Return the attribute's value at the time code of the context; outside of one, at the default time."""
    time = _time.get()
    return attribute.Get(Usd.TimeCode.Default() if time is None else time)
