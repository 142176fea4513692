"""Members of foreign classes that exist there and raise `Unsupported` here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NoReturn

from usdsdg.errors import Unsupported


class Refused:
    """A member that raises `Unsupported` when it is read."""

    def __init__(self, name: str, why: str) -> None:
        self._message = f"{name}: {why}"

    def __get__(self, instance: object, owner: type | None = None) -> Any:
        if instance is None:
            return self
        raise Unsupported(self._message)


class RefusedNames:
    """A `__getattr__` that raises `Unsupported` for names with these beginnings, and AttributeError for others."""

    def __init__(self, owner: str, beginnings: tuple[str, ...], why: str) -> None:
        self._owner, self._beginnings, self._why = owner, beginnings, why

    def __get__(self, instance: object, owner: type | None = None) -> Any:
        return self._raise

    def _raise(self, name: str) -> NoReturn:
        if name.startswith(self._beginnings):
            raise Unsupported(f"{self._owner}.{name}: {self._why}")
        raise AttributeError(f"{self._owner} has no attribute {name!r}")


def refused_function(name: str, why: str) -> Callable[..., NoReturn]:
    """Return a function that raises `Unsupported` when it is called."""

    def refuse(*_: object, **__: object) -> NoReturn:
        raise Unsupported(f"{name}: {why}")

    refuse.__doc__ = f"Raise `Unsupported`: {why}."
    return refuse
