"""Modules that can be imported and whose names say what they are when a script uses them.

Harmless uses work, since scripts make them at module level or in code that does not run: classes are inherited from,
constants are read (`ui.Alignment.CENTER`), names stand in annotations. Calls, and attributes of functions, raise.
"""

import abc
import functools
from types import ModuleType
from typing import Any, NoReturn

from usdsdg.compat.foreign_names import OutOfScope, out_of_scope
from usdsdg.errors import Unsupported


class PlaceholderModule(ModuleType):
    """A module that is out of scope; each of its names is a placeholder.

    Python cannot tell a module from a class by its name, so a module stands for a class, too, where a script uses it
    as one.
    """

    def __init__(self, name: str, subject: OutOfScope) -> None:
        super().__init__(name, f"Out of scope: {subject.message(name)}")
        self.__dict__["_subject"] = subject

    def __getattr__(self, name: str) -> type:
        if name.startswith("__"):
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        own = f"{self.__name__}.{name}"  # which may have a row of its own
        return placeholder(own, out_of_scope(own) or self.__dict__["_subject"])

    def __call__(self, *args: Any, **kwargs: Any) -> NoReturn:
        _refuse(self._as_class())

    def __mro_entries__(self, bases: tuple[Any, ...]) -> tuple[type]:
        return (self._as_class(),)

    def __instancecheck__(self, instance: object) -> bool:
        return False

    def _as_class(self) -> Any:
        return placeholder(self.__name__, self.__dict__["_subject"])


@functools.cache
def placeholder(name: str, subject: OutOfScope) -> type:
    """Return a class that stands for `name`: it can be inherited from, and raises `Unsupported` when it is called."""
    module, _, last = name.rpartition(".")
    members = {"__doc__": subject.message(name), "__module__": module, "_stands_for": (name, subject)}
    return _Placeholder(last, (), members)


class _Placeholder(abc.ABCMeta):
    """Type of placeholders and of the classes that scripts derive from them."""

    _stands_for: tuple[str, OutOfScope]

    def __call__(cls, *args: Any, **kwargs: Any) -> NoReturn:
        _refuse(cls)

    def __getattr__(cls, name: str) -> type:
        own, subject = cls._stands_for
        if name.startswith("__"):
            raise AttributeError(f"{own} has no attribute {name!r}")
        # By Python's conventions `own` is a function, or a module that `from parent import own` gave.
        if own.rpartition(".")[2][:1].islower() and name[:1].islower():
            _refuse(cls)
        return placeholder(f"{own}.{name}", subject)

    def __iter__(cls) -> NoReturn:
        _refuse(cls)

    def __len__(cls) -> NoReturn:
        _refuse(cls)

    def __getitem__(cls, key: Any) -> type:
        return cls

    def __int__(cls) -> NoReturn:
        _refuse(cls)

    def __float__(cls) -> NoReturn:
        _refuse(cls)

    def __enter__(cls) -> NoReturn:
        _refuse(cls)

    def __exit__(cls, *error: object) -> None: ...

    def __bool__(cls) -> bool:
        return True


def _refuse(cls: _Placeholder) -> NoReturn:
    name, subject = cls._stands_for
    raise Unsupported(subject.message(name))


def is_placeholder(value: object) -> bool:
    """Return whether a value stands for a name that is out of scope."""
    return isinstance(value, (PlaceholderModule, _Placeholder))
