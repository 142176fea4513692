"""`omni.usd.commands`: commands as classes, `CreatePrimCommand(prim_type="Cube").do()`."""

from __future__ import annotations

import inspect
from typing import Any

from usdsdg.arguments.registry import near_misses
from usdsdg.compat.omni.kit.commands import get_commands_list, registry

_SUFFIX = "Command"


def class_of(name: str) -> type[registry.Command]:
    """Return the class of a command; its instances are what `create` makes, of positional arguments too."""
    parameters = list(inspect.signature(registry.function_of(name)).parameters)

    class Made(registry.Command):
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            self._command = registry.create(name, **dict(zip(parameters, args)), **kwargs)

        def do(self) -> Any:
            """Execute it; return its result."""
            return self._command.do()

    Made.__name__ = Made.__qualname__ = name
    return Made


def __getattr__(name: str) -> type[registry.Command]:
    if name.endswith(_SUFFIX) and name.removesuffix(_SUFFIX) in get_commands_list():
        globals()[name] = class_of(name)
        return globals()[name]
    if name.startswith("__"):
        raise AttributeError(name)
    near = near_misses(name.removesuffix(_SUFFIX), get_commands_list())
    hint = f"; did you mean {' or '.join(f'{each}{_SUFFIX}' for each in near)}?" if near else ""
    raise AttributeError(f"omni.usd.commands of usdsdg has no {name!r}{hint}", name=name)
