"""The time code at which attributes are read.

One update of the renderer, or of the physics, reads a stage at one time code. Dozens of small readers would only hand
it on to the next, so they take it from this context.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from pxr import Usd

_DEFAULT = Usd.TimeCode.Default()
_time = ContextVar("time code", default=_DEFAULT)


@contextmanager
def time_context(time: Usd.TimeCode) -> Iterator[None]:
    """Inside, `current_value` reads at `time`."""
    token = _time.set(time)
    try:
        yield
    finally:
        _time.reset(token)


def current_time() -> Usd.TimeCode:
    """Return the time code of the context; outside of one, the default time."""
    return _time.get()


def current_value(attribute: Usd.Attribute) -> Any:
    """Return the attribute's value at the time code of the context; outside of one, at the default time."""
    return attribute.Get(_time.get())


def current_values(attributes: Sequence[Usd.Attribute]) -> list[Any]:
    """Return `current_value` of many attributes."""
    time = current_time()
    return [attribute.Get(time) for attribute in attributes]


def default_or_current_time(attribute: Usd.Attribute) -> Usd.TimeCode:
    """Return the default time where the attribute has an authored default value, else that of the context."""
    source = attribute.GetResolveInfo(_DEFAULT).GetSource()
    return _DEFAULT if source == Usd.ResolveInfoSourceDefault else current_time()
