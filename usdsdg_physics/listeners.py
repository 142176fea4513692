"""Functions that are called when something happens."""

import itertools
from collections.abc import Callable
from typing import Any


class Listeners:
    """Functions in the order in which they subscribed."""

    def __init__(self) -> None:
        self._functions: dict[int, Callable[..., Any]] = {}
        self._keys = itertools.count()

    def __bool__(self) -> bool:
        return bool(self._functions)

    def subscribe(self, listener: Callable[..., Any]) -> Callable[[], None]:
        """Add a listener and return the function that removes it."""
        key = next(self._keys)
        self._functions[key] = listener

        def unsubscribe() -> None:
            self._functions.pop(key, None)

        return unsubscribe

    def call(self, *arguments: Any) -> None:
        """Call all listeners; one may subscribe or unsubscribe others."""
        for listener in list(self._functions.values()):
            listener(*arguments)
