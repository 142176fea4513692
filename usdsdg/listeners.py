"""Lists of functions that are called when something happens, and what ends each subscription."""

from collections.abc import Callable
from functools import partial
from typing import Any
from weakref import WeakMethod


def subscribe(listeners: list[Callable[..., Any]], listener: Callable[..., Any]) -> Callable[[], None]:
    """Append a function to a list, and return the unsubscriber.

    It ends this subscription alone, also where the same function is subscribed again, and may be called several times.
    """
    # Equal to no other: a function, or a method of an object, equals itself in a later subscription.
    entry = partial(listener)
    listeners.append(entry)

    def unsubscribe() -> None:
        if entry in listeners:
            listeners.remove(entry)

    return unsubscribe


def weakly(method: Callable[[Any], None]) -> Callable[[Any], None]:
    """Return a function that calls a method for as long as its object lives."""
    reference = WeakMethod(method)

    def call(argument: Any) -> None:
        if (alive := reference()) is not None:
            alive(argument)

    return call
