"""The time at which lights and materials are read.

A reading of the stage has one time, and dozens of small readers that would do no more with it than hand it on; so they
ask here.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from pxr import Usd

_now: ContextVar[Usd.TimeCode | None] = ContextVar("time of reading", default=None)  # None: the default time


@contextmanager
def reading_at(time: Usd.TimeCode) -> Iterator[None]:
    """Inside, `value_now` reads at `time`."""
    token = _now.set(time)
    try:
        yield
    finally:
        _now.reset(token)


def value_now(attribute: Usd.Attribute) -> Any:
    """The attribute's value then; outside of a reading, at the default time."""
    time = _now.get()
    return attribute.Get(Usd.TimeCode.Default() if time is None else time)
