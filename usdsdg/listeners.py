"""Lists of functions that are called when something happens, and what ends each subscription."""

from collections.abc import Callable
from functools import partial
from typing import Any
from weakref import WeakMethod

from usdsdg.errors import name_callback


class _Entry(partial):
    """One subscription. It equals no other, while a function, or a method, equals itself in a later subscription."""

    order = 0
    has_ended = False

    def __call__(self, /, *args: Any, **kwargs: Any) -> Any:
        if self.has_ended:  # by one that was called before
            return None
        try:
            return super().__call__(*args, **kwargs)
        except Exception as error:
            name_callback(error, "which was subscribed")
            raise


def subscribe(
    listeners: list[Callable[..., Any]], listener: Callable[..., Any], *, order: int = 0
) -> Callable[[], None]:
    """Add a function to a list behind those of its `order` and of lower ones, and return the unsubscriber.

    It ends this subscription alone, also where the same function is subscribed again, and may be called several times,
    also by what is called before this function. An error of a script's function gets a note with its name and place.
    """
    entry = _Entry(listener)
    entry.order = order
    listeners.insert(sum(getattr(each, "order", 0) <= order for each in listeners), entry)

    def unsubscribe() -> None:
        entry.has_ended = True
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
