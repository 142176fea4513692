"""Conversion of user values to the shape and type that an argument needs, with an ArgumentError for anything else."""

from collections.abc import Mapping, Sequence
from numbers import Integral
from typing import Any

import numpy as np

from usdsdg.errors import ArgumentError

Labels = dict[str, list[str]]

_WORDS = {2: "two", 3: "three", 4: "four"}


def vector(name: str, value: Any, size: int = 3) -> list[float]:
    """Return `size` floats, from as many numbers or from one number for all components.

    Raises:
        ArgumentError: `value` is neither; the message names the argument, the value and what is expected.
    """
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.full((0, 0), np.nan)
    if numbers.shape not in ((), (size,)):
        raise ArgumentError(
            f"{name} is {shown(value)}; expected {_WORDS.get(size, size)} numbers, one number for all of them, or a "
            "list with one such value per prim"
        )
    return np.broadcast_to(numbers, size).tolist()


# Prims of one call. 100,000 take 10 s and 0.8 GB on two cores.
MOST_PRIMS = 1_000_000
TOO_MANY_PRIMS = f"at most {MOST_PRIMS} are made at once, which take some 2 minutes and 8 GB of memory"


def count_of(value: Any) -> int:
    """Validate the number of prims to create.

    Raises:
        ArgumentError: `value` is not an integer, negative, or above MOST_PRIMS.
    """
    number = whole_number("count", value, least=0)
    if number > MOST_PRIMS:
        raise ArgumentError(f"count is {number}; {TOO_MANY_PRIMS}")
    return number


def whole_number(name: str, value: Any, *, least: int | None = None) -> int:
    """Validate an integer argument.

    Raises:
        ArgumentError: `value` is not an integer, or below `least`.
    """
    if not isinstance(value, Integral) or isinstance(value, bool) or (least is not None and value < least):
        raise ArgumentError(
            f"{name} is {shown(value)}; expected a whole number" + ("" if least is None else f", {least} or more")
        )
    return int(value)


def labels_of(semantics: Any) -> Labels:
    """Convert `[("class", "cube")]` or `{"class": "cube" | ["cube", ...]}` to {type: [labels]}.

    Raises:
        ArgumentError: `semantics` is neither.
    """
    pairs = list(semantics.items()) if isinstance(semantics, Mapping) else semantics
    if not _is_list(pairs) or not all(_is_pair(pair) for pair in pairs):
        raise ArgumentError(
            f"semantics is {shown(semantics)}; expected pairs of a type and a label such as [('class', 'cube')], or "
            "{'class': 'cube'}"
        )
    found: Labels = {}
    for kind, label in pairs:
        found.setdefault(kind, []).extend([label] if isinstance(label, str) else list(label))
    return found


def labels_per_prim(semantics: Any, count: int) -> list[Labels]:
    """Return the labels of each of `count` prims: the same for all, or from a list with one `labels_of` value per prim.

    Raises:
        ArgumentError: `semantics` is neither.
    """
    per_prim = _is_list(semantics) and len(semantics) == count and not any(_is_pair(each) for each in semantics)
    return [labels_of(each) for each in semantics] if per_prim else [labels_of(semantics)] * count


def shown(value: Any) -> str:
    """Format `value` for a message: at most 80 characters, arrays as lists."""
    text = repr(value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value)
    return text if len(text) <= 80 else f"{text[:76]} ..."


def _is_list(value: Any) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, (str, bytes))


def _is_pair(value: Any) -> bool:
    if not _is_list(value) or len(value) != 2 or not isinstance(value[0], str):
        return False
    return isinstance(value[1], str) or (_is_list(value[1]) and all(isinstance(label, str) for label in value[1]))
