"""Functions that are called when something happens."""

import itertools
from collections.abc import Callable
from typing import Any


class Listeners:
    """Functions in the order in which they subscribed."""

    def __init__(self) -> None:
        self._functions: dict[int, Callable[..., Any]] = {}
        self._heard: dict[int, Callable[[], bool]] = {}
        self._keys = itertools.count()

    def __bool__(self) -> bool:
        """Return whether anybody hears of what happens now."""
        return any(key not in self._heard or self._heard[key]() for key in self._functions)

    def subscribe(self, listener: Callable[..., Any], *, heard: Callable[[], bool] | None = None) -> Callable[[], None]:
        """Add a listener and return the function that removes it.

        `heard` tells of a listener that passes on what it hears whether there is anybody to pass it to.
        """
        key = next(self._keys)
        self._functions[key] = listener
        if heard is not None:
            self._heard[key] = heard

        def unsubscribe() -> None:
            self._functions.pop(key, None)
            self._heard.pop(key, None)

        return unsubscribe

    def call(self, *arguments: Any) -> None:
        """Call all listeners; one may subscribe others, or unsubscribe those that are called after it."""
        for key in list(self._functions):  # of pairs it would not be made at once: garbage may be collected meanwhile
            if (listener := self._functions.get(key)) is not None:
                listener(*arguments)
