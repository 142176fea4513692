"""Authoring of attributes, with conversion of values to the attribute's type."""

import difflib
import math
from typing import Any

import numpy as np
from pxr import Sdf, Tf, Usd

from usdsdg.errors import BadPrim, BadValue
from usdsdg.stage import assets


def attribute_of(prim: Usd.Prim, name: str) -> Usd.Attribute:
    """Return the attribute `name`, or `inputs:<name>`.

    Raises:
        BadPrim: the prim has neither; names near misses.
    """
    for candidate in (name, f"inputs:{name}"):
        if prim.HasAttribute(candidate):
            return prim.GetAttribute(candidate)
    raise BadPrim(missing_attribute(prim, name, [attribute.GetName() for attribute in prim.GetAttributes()]))


def missing_attribute(prim: Usd.Prim, name: str, known: list[str]) -> str:
    """Return the error message for a missing attribute."""
    near = difflib.get_close_matches(name, known, 4, 0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else f"it has {', '.join(sorted(known)[:8]) or 'none'}."
    return f"{prim.GetPath()} ({prim.GetTypeName() or 'no type'}) has no attribute {name!r}; {hint}"


def set_value(attribute: Usd.Attribute, value: Any) -> None:
    """Author `value` as the attribute's default.

    Numbers are converted to the attribute's type (for int attributes: rounded down), sequences to vectors, quaternions
    (real part first), matrices (by rows) or arrays; one number fills a vector. Strings for asset attributes are files
    or URLs below the assets root.

    Raises:
        AssetNotFound: there is no such file.
        BadValue: the attribute cannot hold the value.
    """
    try:
        accepted = attribute.Set(_converted(attribute, value))
    except (Tf.ErrorException, TypeError, ValueError) as failure:
        raise _bad_value(attribute, value) from failure
    if not accepted:
        raise _bad_value(attribute, value)


def remove_value(prim: Usd.Prim, name: str) -> None:
    """Remove an attribute's opinion in the edit target, and block one that a reference brings."""
    prim.RemoveProperty(name)
    attribute = prim.GetAttribute(name)
    if attribute and attribute.HasAuthoredValue():
        attribute.Block()


def asset_path(value: Any) -> Sdf.AssetPath:
    """Return the asset path of an existing file; "" and names with <UDIM> stay as they are.

    Raises:
        AssetNotFound: there is no such file.
    """
    text = value.path if isinstance(value, Sdf.AssetPath) else str(value)
    return Sdf.AssetPath(text if not text or "<UDIM>" in text else assets.resolve(text))


def _converted(attribute: Usd.Attribute, value: Any) -> Any:
    type_name = attribute.GetTypeName()
    if type_name.isArray:
        return _array(type_name.scalarType, value)
    return _scalar(type_name.defaultValue, value)


def _scalar(default: Any, value: Any) -> Any:
    """Convert a value to the type of `default`."""
    kind = type(default)
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(default, Sdf.AssetPath):
        return asset_path(value)
    if type(value) is kind:
        return value
    size = getattr(kind, "dimension", None)
    if size is not None:
        numbers = np.asarray(value, np.float64)
        if isinstance(size, tuple):
            # The rows of a matrix, or its numbers one after the other.
            return kind(*numbers.reshape(size).ravel().tolist())
        if numbers.shape not in ((), (size,)):
            raise ValueError("wrong size")
        return kind(*_rounded(np.broadcast_to(numbers, size), default[0]))
    if hasattr(default, "GetImaginary") and isinstance(value, (list, tuple, np.ndarray)):
        return kind(*(float(number) for number in value))
    if isinstance(default, bool):
        return bool(value)
    if isinstance(default, int):
        return math.floor(value)
    return float(value) if isinstance(default, float) and not isinstance(value, str) else value


def _array(scalar: Sdf.ValueTypeName, value: Any) -> Any:
    """Convert the elements of a sequence to a type; return anything else as it is."""
    default = scalar.defaultValue
    if default.__class__ in (str, Sdf.AssetPath):
        return [asset_path(each) for each in value] if scalar == Sdf.ValueTypeNames.Asset else list(value)
    if not isinstance(value, (list, tuple, np.ndarray)):
        return value
    size = getattr(type(default), "dimension", None)
    if hasattr(default, "GetImaginary") or isinstance(size, tuple):
        return [_scalar(default, each) for each in value]
    numbers = np.asarray(value, np.float64)
    if isinstance(size, int):
        if numbers.shape == (size,):
            numbers = numbers[None]
        return [type(default)(*row) for row in _rounded(numbers, default[0])]
    return _rounded(numbers, default)


def _rounded(numbers: np.ndarray, like: Any) -> list[Any]:
    """Return numbers as lists, rounded down where `like` is an integer."""
    return np.floor(numbers).astype(np.int64).tolist() if isinstance(like, int) else numbers.tolist()


def _bad_value(attribute: Usd.Attribute, value: Any) -> BadValue:
    text = repr(value.tolist() if isinstance(value, np.ndarray) else value)
    shown = text if len(text) <= 80 else f"{text[:76]} ..."
    return BadValue(f"{attribute.GetPath()} is a {attribute.GetTypeName()}; it does not take {shown}")
