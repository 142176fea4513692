"""Functions that run one after the other when a file is written. Mirrors `rep.backends.Sequential`."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Hashable, Mapping
from typing import Any


class Sequential:
    """Functions of which each receives what the one before it returned.

    A tuple that a function returns becomes the positional arguments of the next, a dictionary its keyword arguments,
    anything else its one argument. `backend.schedule(Sequential(change, functional.write_image), path, data)` runs
    them on the I/O queue; a call of the sequence gives an argument that is computed there, as in
    `backend.schedule(functional.write_image, path, Sequential(change)(data))`.
    """

    def __init__(self, *tasks: Callable[..., Any]) -> None:
        self.tasks = tasks

    def __call__(self, *args: Any, **kwargs: Any) -> Deferred:
        """Return what computes the result when it is called."""
        return Deferred(self, args, kwargs)

    def run(self, *args: Any, backend_instance: object = None, **kwargs: Any) -> Any:
        """Run all functions and return what the last one returns.

        Those that have a parameter `backend_instance` get it; so does the last one, which writes, if it has `**kwargs`:
        those of the functions before it are the data of transforms.
        """
        result: Any = None
        tasks = self._flat()
        for index, task in enumerate(tasks):
            if backend_instance is not None and takes_backend(task, as_any=index == len(tasks) - 1):
                kwargs.setdefault("backend_instance", backend_instance)
            result = task(*args, **kwargs)
            args, kwargs = _arguments(result)
        return result

    def _flat(self) -> list[Callable[..., Any]]:
        """Return the functions, those of sequences in this one in its place."""
        return [each for task in self.tasks for each in (task._flat() if isinstance(task, Sequential) else [task])]


class Deferred:
    """A call of a `Sequential` that has not happened yet; calling it returns the result."""

    def __init__(self, sequence: Sequential, args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> None:
        self.sequence, self.args, self.kwargs = sequence, args, dict(kwargs)

    def __call__(self) -> Any:
        return self.sequence.run(*self.args, **self.kwargs)


def computed(value: Any) -> Any:
    """Return a value, or the result of one that is deferred."""
    return value() if isinstance(value, Deferred) else value


def takes_backend(fn: Callable[..., Any], *, as_any: bool = True) -> bool:
    """Whether a function takes `backend_instance`: as a parameter or, if `as_any`, as one of its `**kwargs`."""
    return (_has_backend if isinstance(fn, Hashable) else _has_backend.__wrapped__)(fn, as_any)


@functools.lru_cache(maxsize=256)
def _has_backend(fn: Callable[..., Any], as_any: bool) -> bool:
    try:
        parameters = inspect.signature(fn).parameters.values()
    except (TypeError, ValueError):  # some built-ins have no signature
        return False
    return any(each.name == "backend_instance" or (as_any and each.kind is each.VAR_KEYWORD) for each in parameters)


def _arguments(result: Any) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Return what the next function is called with."""
    if isinstance(result, tuple):
        return result, {}
    if isinstance(result, dict):
        return (), dict(result)
    return (result,), {}
