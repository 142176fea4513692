"""Misspelled keyword arguments of public functions: the error names the parameter that was meant."""

from __future__ import annotations

import functools
import inspect
import sys
from collections.abc import Callable, Mapping, Sequence
from types import FunctionType
from typing import Any

from usdsdg.arguments.misplaced import explaining
from usdsdg.arguments.near_arguments import near_arguments
from usdsdg.session.turns import in_turn

# Attribute of functions that name near misses already.
_MARK = "_names_parameters"


def name_parameters(module: dict[str, Any], *, without_turns: Sequence[str] | None = ()) -> None:
    """Let the public functions of a family's module name near misses of keyword arguments that they do not have.

    Calls of several threads run one after the other (`session.turns`).

    The module says of names that it does not have where they are.

    Python's TypeError stays a TypeError: only its message is another. Functions keep their signature, documentation and
    name; where they are defined they are replaced too, so that they can be pickled. A call costs one call more.

    module: globals, at the end of the module. without_turns: names of functions of which threads may call several at
    once; None: of all.
    """
    here = module["__name__"]
    module.setdefault("__getattr__", explaining(module))
    listed = module.get("__all__")
    for name, value in list(module.items()):
        is_public = name in listed if listed is not None else not name.startswith("_")
        if not isinstance(value, FunctionType) or not is_public or hasattr(value, _MARK):
            continue
        if listed is None and value.__module__ != here:
            continue  # it was only imported
        takes_turns = without_turns is not None and name not in without_turns
        naming = _naming(in_turn(value) if takes_turns and not inspect.iscoroutinefunction(value) else value)
        origin = vars(sys.modules[value.__module__])
        if origin.get(value.__name__) is value:
            origin[value.__name__] = naming
        module[name] = naming


def _naming(function: Callable[..., Any]) -> Callable[..., Any]:
    naming = (_naming_later if inspect.iscoroutinefunction(function) else _naming_now)(function)
    setattr(naming, _MARK, True)
    return naming


def _naming_now(function: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(function)
    def naming(*args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, **kwargs)
        except TypeError:
            _check_names(function, kwargs)
            raise

    return naming


def _naming_later(function: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(function)
    async def naming(*args: Any, **kwargs: Any) -> Any:
        try:
            return await function(*args, **kwargs)
        except TypeError:
            _check_names(function, kwargs)
            raise

    return naming


def _check_names(function: Callable[..., Any], given: Mapping[str, Any]) -> None:
    """Raise a TypeError that names what was meant, if a function has no parameter of a given name."""
    parameters = inspect.signature(function).parameters.values()
    if any(each.kind is each.VAR_KEYWORD for each in parameters):
        return
    known = [each.name for each in parameters if each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)]
    for name in given:
        if name not in known:
            close = near_arguments(name, known)
            hint = (
                f"did you mean {' or '.join(map(repr, close))}?" if close else f"it takes {', '.join(known) or 'none'}"
            )
            called = function.__name__
            raise TypeError(f"{called}() got an unexpected keyword argument {name!r}; {hint}") from None
