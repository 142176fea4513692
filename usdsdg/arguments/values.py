"""Conversion of user values to the shape and type that an argument needs, with an ArgumentError for anything else."""

import math
from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np

from usdsdg.errors import ArgumentError
from usdsdg.graph.node import ReplicatorItem

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


def finite_number(name: str, value: Any) -> float:
    """Validate an argument that is one number, and no distribution.

    Raises:
        ArgumentError: `value` is no number, or not finite.
    """
    if not isinstance(value, Real) or isinstance(value, bool) or not math.isfinite(value):
        raise ArgumentError(f"{name} is {shown(value)}; expected one number, which is the same at every execution")
    return float(value)


def up_axis_vector(value: Any) -> Any:
    """Convert "X", "Y" or "Z" to the direction of that axis, also in a list; return other values as they are.

    Raises:
        ArgumentError: it is another text.
    """
    if isinstance(value, list):
        return [up_axis_vector(each) for each in value]
    if not isinstance(value, str):
        return value
    if value.upper() not in ("X", "Y", "Z"):
        raise ArgumentError(f"look_at_up_axis is {value!r}; expected 'X', 'Y', 'Z' or a direction")
    return tuple(float(axis == value.upper()) for axis in "XYZ")


def labels_of(semantics: Any) -> Labels:
    """Convert labels to {type: [labels]}.

    Args:
        semantics: {"class": "cube" or ["cube", ...]}, pairs [("class", "cube")], one pair ("class", "cube"), texts
            ["class:cube", ...], or one text "class:cube;color:red".

    Raises:
        ArgumentError: it is none of these, or a part of it is a distribution.
    """
    refuse_drawn_parts(semantics)
    found: Labels = {}
    for pair in _pairs_of(semantics):
        if not _is_pair(pair):
            raise ArgumentError(
                f"semantics is {shown(semantics)}; expected pairs of a type and a label such as [('class', 'cube')], "
                "{'class': 'cube'}, or 'class:cube'"
            )
        kind, label = pair
        found.setdefault(kind, []).extend([label] if isinstance(label, str) else list(label))
    return found


def refuse_drawn_parts(semantics: Any) -> None:
    """Check that no distribution is a part of labels.

    Raises:
        ArgumentError: (a GraphError) one is.
    """
    parts = semantics.values() if isinstance(semantics, Mapping) else semantics if _is_list(semantics) else ()
    for part in parts:
        if isinstance(part, ReplicatorItem):
            raise ArgumentError(
                "semantics has a distribution in place of a label; draw the pairs as a whole: "
                "rep.distribution.choice([[('class', 'a')], [('class', 'b')]])"
            )
        refuse_drawn_parts(part)


def _pairs_of(semantics: Any) -> list[Any]:
    """Return the pairs that `semantics` consists of; what is no pair stays, for the message."""
    if isinstance(semantics, Mapping):
        return list(semantics.items())
    if isinstance(semantics, str):
        return [_pair_of(each) for each in semantics.split(";")]
    if isinstance(semantics, tuple) and _is_pair(semantics):
        return [semantics]
    return [_pair_of(each) for each in semantics] if _is_list(semantics) else [semantics]


def _pair_of(value: Any) -> Any:
    """Convert the text "class:cube" to a pair."""
    return tuple(value.split(":", 1)) if isinstance(value, str) and ":" in value else value


def labels_per_prim(semantics: Any, count: int) -> list[Labels]:
    """Return the labels of each of `count` prims: the same for all, or from a list with one `labels_of`
    value per prim or one for all.

    Raises:
        ArgumentError: `semantics` is neither.
    """
    is_single = _is_list(semantics) and len(semantics) == 1 and isinstance(semantics[0], (Mapping, list))
    if is_single and not _is_pair(semantics[0]):
        return [labels_of(semantics[0])] * count
    of_one = (_is_pair(each) or isinstance(each, str) for each in semantics) if _is_list(semantics) else [True]
    per_prim = _is_list(semantics) and len(semantics) == count and not any(of_one)
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
