"""Distributions that randomizers sample, with one independent draw per prim and per component.

Mirrors `rep.distribution`. A distribution is a node that other nodes have as an input; it draws when its consumer runs.
"""

from collections.abc import Callable
from typing import Any

from usdsdg.arguments.parameters import name_parameters
from usdsdg.arguments.registry import register_function
from usdsdg.distribution.base import Distribution, from_inputs
from usdsdg.distribution.combination import Combine, combine
from usdsdg.distribution.draws import (
    consumer_of,
    draw,
    draw_column,
    draw_scalars,
    draw_worlds,
    is_vector,
    named_draws,
    one_of,
    options_of,
)
from usdsdg.distribution.of_lists import Choice, Sequence_, choice, sequence
from usdsdg.distribution.of_numbers import LogUniform, Normal, Uniform, log_uniform, normal, uniform

__all__ = [
    "Choice", "Combine", "Distribution", "LogUniform", "Normal", "Sequence_", "Uniform", "choice", "combine",
    "consumer_of", "draw", "draw_column", "draw_scalars", "draw_worlds", "from_inputs", "is_vector", "log_uniform",
    "named_draws", "normal", "one_of", "options_of", "register", "sequence", "uniform",
]  # fmt: skip


def register(fn: Callable[..., Any], override: bool = True, fn_name: str | None = None) -> None:
    """Make `rep.distribution.<name>` call `fn`.

    Raises:
        ValueError: the name is not an identifier, or is taken and `override` is False.
    """
    register_function(globals(), "distribution", fn, override, fn_name)


name_parameters(globals())
