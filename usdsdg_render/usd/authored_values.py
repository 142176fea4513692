"""Authored values as numbers, checked: a layer may hold a value of any type for any attribute."""

from typing import Any

import numpy as np
from pxr import Gf, Usd

from usdsdg import errors


def as_floats(value: Any, count: int) -> tuple[float, ...] | None:
    """Return `count` floats: a number repeated, or the first components of a vector; None for anything else."""
    if isinstance(value, (int, float)):
        return (float(value),) * count
    if type(value) is Gf.Vec3f:  # most inputs are numbers or colors; pxr is slow at iterating
        return (value[0], value[1], value[2])[:count] if count <= 3 else None
    if isinstance(value, str):
        return None
    try:
        numbers = tuple(map(float, value))
    except (TypeError, ValueError):
        return None
    return numbers[:count] if len(numbers) >= count else None


def as_array(attribute: Usd.Attribute, value: object, tail: tuple[int, ...]) -> np.ndarray | None:
    """Return a value of the attribute as an array of rows of shape `tail`.

    None where there is no value, or (with a warning) one of another shape or type.
    """
    if value is None:
        return None
    array = np.asarray(value)
    kinds = "iu" if str(attribute.GetTypeName()).startswith("int") else "fiu"
    if array.ndim == 1 + len(tail) and array.shape[1:] == tail and array.dtype.kind in kinds:
        return array
    expected = f"rows of {tail[0]} numbers" if tail else "numbers"
    errors.warn_once(
        f"{attribute.GetPath()}: the value is a {type(value).__name__}, declared as {attribute.GetTypeName()}; an "
        f"array of {expected} is read here, so it is ignored. Correct its type."
    )
    return None
