"""Functions that run one after the other when a file is written. Mirrors `rep.backends.Sequential`."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
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
        """Run all functions and return what the last one returns; those that take `backend_instance` get it."""
        result: Any = None
        for task in self.tasks:
            call = task.run if isinstance(task, Sequential) else task
            if backend_instance is not None and _takes_backend(task):
                kwargs.setdefault("backend_instance", backend_instance)
            result = call(*args, **kwargs)
            args, kwargs = _arguments(result)
        return result


class Deferred:
    """A call of a `Sequential` that has not happened yet; calling it returns the result."""

    def __init__(self, sequence: Sequential, args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> None:
        self.sequence, self.args, self.kwargs = sequence, args, dict(kwargs)

    def __call__(self) -> Any:
        return self.sequence.run(*self.args, **self.kwargs)


def computed(value: Any) -> Any:
    """Return a value, or the result of one that is deferred."""
    return value() if isinstance(value, Deferred) else value


def _takes_backend(task: Callable[..., Any]) -> bool:
    if isinstance(task, Sequential):
        return True
    try:
        return "backend_instance" in inspect.signature(task).parameters
    except (TypeError, ValueError):  # some built-ins have no signature
        return False


def _arguments(result: Any) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Return what the next function is called with."""
    if isinstance(result, tuple):
        return result, {}
    if isinstance(result, dict):
        return (), dict(result)
    return (result,), {}
