"""The commands by name, and how one is executed."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from types import ModuleType
from typing import Any, TypeVar

from usdsdg.arguments.registry import near_misses
from usdsdg.compat import foreign_names
from usdsdg.errors import Unsupported, warn_once

Function = TypeVar("Function", bound=Callable[..., Any])

_SUFFIX = "Command"
# Arguments that name an undo state, the user interface or the only context; they change nothing.
_IGNORED = frozenset({
    "context_name", "usd_context", "usd_context_name", "select_new_prim", "old_selected_paths", "expand_in_stage",
    "prev", "old_transform_matrix", "old_translation", "old_rotation_euler", "old_rotation_order", "old_scale",
    "had_transform_at_key", "prepend_default_prim",
})  # fmt: skip

# By a word of a command's name, a module of the subject that it belongs to.
_OUT_OF_SCOPE = {
    "lidar": "isaacsim.sensors.rtx", "radar": "isaacsim.sensors.rtx", "ultrasonic": "isaacsim.sensors.rtx",
    "lightbeam": "isaacsim.sensors.physx", "rangesensor": "isaacsim.sensors.physx", "idsensor": "isaacsim.sensors.rtx",
    "urdf": "isaacsim.asset", "mjcf": "isaacsim.asset", "ros1": "isaacsim.ros1", "ros2": "isaacsim.ros2",
    "surfacegripper": "isaacsim.robot", "deformable": "omni.physx.scripts.deformableUtils",
    "particle": "omni.physx.scripts.particleUtils", "graphnode": "omni.graph.tools",
}  # fmt: skip

_functions: dict[str, Callable[..., Any]] = {}


class Command:
    """The base of a script's own commands: `do` is called by `execute`, with the object made of its arguments."""

    def do(self) -> Any:
        """Do what the command is for."""

    def undo(self) -> None:
        """Undo it; nothing calls this."""


_classes: dict[str, type[Command]] = {}


def command(name: str) -> Callable[[Function], Function]:
    """Make the decorated function the command of that name."""

    def decorator(function: Function) -> Function:
        _functions[name] = function
        return function

    return decorator


def register(command_class: type[Command]) -> None:
    """Add a script's own command under the name of its class, with and without "Command" at its end."""
    _classes[command_class.__name__.removesuffix(_SUFFIX)] = command_class


def unregister(command_class: type[Command]) -> None:
    """Remove a script's own command."""
    _classes.pop(command_class.__name__.removesuffix(_SUFFIX), None)


def register_all_commands_in_module(module: ModuleType) -> Callable[[], None]:
    """Register all classes of commands in a module; return what removes them."""
    found = [each for each in vars(module).values() if inspect.isclass(each) and issubclass(each, Command)]
    for each in found:
        register(each)

    def remove() -> None:
        for each in found:
            unregister(each)

    return remove


def get_command_class(name: str) -> type[Command] | None:
    """Return the class of a script's own command, None of others."""
    return _classes.get(name.removesuffix(_SUFFIX))


def get_commands_list() -> list[str]:
    """Return the names of all commands, sorted."""
    return sorted({*_functions, *_classes})


def get_commands() -> dict[str, dict[str, Any]]:
    """Return what executes each command, by its name and then by the module that it is of.

    A script's own command is a class; the names of all are there with and without "Command" at their end.
    """
    found = {**_functions, **_classes}
    both = {name: each for short, each in found.items() for name in (short, f"{short.removesuffix(_SUFFIX)}{_SUFFIX}")}
    return {name: {each.__module__: each} for name, each in sorted(both.items())}


def function_of(name: str) -> Callable[..., Any]:
    """Return what executes a command, for a script's own one its class; names may have "Command" at their end.

    Raises:
        Unsupported: there is no such command.
    """
    short = name.removesuffix(_SUFFIX)
    found = _classes.get(short) or _functions.get(name) or _functions.get(short)
    if found is None:
        raise _unknown(name)
    return found


class _BuiltIn(Command):
    """A command of Kit with its arguments."""

    def __init__(self, function: Callable[..., Any], arguments: dict[str, Any]) -> None:
        self._function = function
        self._arguments = arguments

    def do(self) -> Any:
        """Execute it; return its result.

        Raises:
            TypeError: an argument is missing.
        """
        return self._function(**self._arguments)


def create(name: str, **kwargs: Any) -> Command:
    """Return the object of a command, which `do` executes; names may have "Command" at their end.

    Raises:
        Unsupported: there is no such command.
    """
    own = get_command_class(name)
    if own is not None:
        return own(**kwargs)
    function = function_of(name)
    known = inspect.signature(function).parameters
    ignored = sorted(set(kwargs) - set(known) - _IGNORED)
    if ignored:
        warn_once(f"omni.kit.commands {name}: ignored {', '.join(ignored)}; it takes {', '.join(known)}")
    return _BuiltIn(function, {key: value for key, value in kwargs.items() if key in known})


def execute(name: str, **kwargs: Any) -> tuple[bool, Any]:
    """Execute the command of a name, with or without "Command" at its end; return True and its result.

    In Kit an error inside a command is logged and the result is (False, None); here it is raised.

    Raises:
        Unsupported: there is no such command.
        TypeError: an argument is missing.
    """
    return True, create(name, **kwargs).do()


def _unknown(name: str) -> Unsupported:
    for word, module in _OUT_OF_SCOPE.items():
        if word in name.lower() and (subject := foreign_names.out_of_scope(module)):
            return Unsupported(subject.message(f"omni.kit.commands: {name}"))
    near = near_misses(name.removesuffix(_SUFFIX), get_commands_list())
    hint = f"did you mean {' or '.join(near)}?" if near else f"there are {', '.join(get_commands_list())}"
    return Unsupported(f"omni.kit.commands: there is no command {name!r}; {hint}")
