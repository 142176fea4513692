"""The time code at which lights, materials and images are read.

One update reads a stage at one time code. Dozens of small readers would only hand it on to the next, so they take it
from this context.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from pxr import Usd

_DEFAULT = Usd.TimeCode.Default()
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
    return current_values([attribute])[0]


def current_values(attributes: Sequence[Usd.Attribute]) -> list[Any]:
    """Return `current_value` of many attributes."""
    time = _time.get()
    time = _DEFAULT if time is None else time
    return [attribute.Get(time) for attribute in attributes]
