"""The arguments of the functions and Warp kernels that augmentations call."""

import inspect
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from usdsdg.arguments.registry import near_misses


def is_kernel(function: Any) -> bool:
    """Return whether `function` is a Warp kernel, without importing Warp."""
    return type(function).__module__.partition(".")[0] == "warp" and hasattr(function, "adj")


FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])


def kernel_in_replicator(function: FunctionT) -> FunctionT:
    """Mark a function that is a Warp kernel in Replicator, so that annotators deliver its result as a Warp array."""
    function.is_kernel_in_replicator = True  # type: ignore[attr-defined]
    return function


def gives_warp_array(function: Any) -> bool:
    """Return whether `function` is a Warp kernel, here or in Replicator."""
    return is_kernel(function) or getattr(function, "is_kernel_in_replicator", False)


def arguments_of(function: Any) -> Mapping[str, bool] | None:
    """Return the argument names and whether each is required; None for **kwargs or an unknown signature."""
    if is_kernel(function):
        given = defaults_of_kernel(function)
        return {argument.label: argument.label not in given for argument in function.adj.args}
    try:
        parameters = inspect.signature(function).parameters
    except (TypeError, ValueError):  # some built-ins have no signature
        return None
    kinds = {parameter.kind for parameter in parameters.values()}
    if inspect.Parameter.VAR_KEYWORD in kinds:
        return None
    others = [name for name in parameters if name != "data_in"]
    if "data_in" not in parameters:
        others = others[1:]  # the first parameter receives the array, whatever its name
    optional = inspect.Parameter.VAR_POSITIONAL
    needed = {n: parameters[n].default is inspect.Parameter.empty and parameters[n].kind != optional for n in others}
    return {"data_in": False, **needed}


def defaults_of_kernel(kernel: Any) -> dict[str, Any]:
    """Return the default values of a Warp kernel's arguments, which Warp itself ignores."""
    parameters = inspect.signature(kernel.func).parameters.values()
    return {each.name: each.default for each in parameters if each.default is not each.empty}


def has_data_in(function: Any) -> bool:
    """Return whether the array is passed by name, as `data_in`."""
    try:
        return "data_in" in inspect.signature(function).parameters
    except (TypeError, ValueError):
        return False


def unknown_argument(label: str, name: str, known: Mapping[str, bool]) -> str:
    """Return the warning about an unknown argument, with near misses or all names."""
    names = [each for each in known if each not in ("data_in", "data_out")]
    close = near_misses(name, names)
    hint = f"Did you mean {close[0]!r}?" if close else f"It has: {', '.join(names) or 'none'}."
    return f"Augmentation {label} has no argument {name!r}, which is ignored. {hint}"
