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
    (real part first) or arrays; one number fills a vector. Strings for asset attributes are files or URLs below the
    assets root.

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
    if isinstance(value, np.generic):
        value = value.item()
    type_name = attribute.GetTypeName()
    default = type_name.defaultValue
    if type_name.isArray:
        return _array(type_name, value)
    if isinstance(default, Sdf.AssetPath):
        return asset_path(value)
    size = getattr(type(default), "dimension", None)
    if isinstance(size, int):
        numbers = np.asarray(value, np.float64)
        if numbers.shape not in ((), (size,)):
            raise ValueError("wrong size")
        return type(default)(*np.broadcast_to(numbers, size).tolist())
    if hasattr(default, "GetImaginary") and isinstance(value, (list, tuple, np.ndarray)):
        return type(default)(*(float(number) for number in value))
    if isinstance(default, bool):
        return bool(value)
    if isinstance(default, int):
        return math.floor(value)
    return float(value) if isinstance(default, float) and not isinstance(value, str) else value


def _array(type_name: Sdf.ValueTypeName, value: Any) -> Any:
    """Convert the elements of a sequence to those of an array type; return anything else as it is."""
    scalar = type_name.scalarType
    if scalar.defaultValue.__class__ in (str, Sdf.AssetPath):
        return [asset_path(each) for each in value] if scalar == Sdf.ValueTypeNames.Asset else list(value)
    if not isinstance(value, (list, tuple, np.ndarray)):
        return value
    size = getattr(type(scalar.defaultValue), "dimension", None)
    numbers = np.asarray(value, np.float64)
    if isinstance(size, int):
        if numbers.shape == (size,):
            numbers = numbers[None]
        return [type(scalar.defaultValue)(*row) for row in numbers.tolist()]
    return numbers.astype(np.int64).tolist() if isinstance(scalar.defaultValue, int) else numbers.tolist()


def _bad_value(attribute: Usd.Attribute, value: Any) -> BadValue:
    text = repr(value.tolist() if isinstance(value, np.ndarray) else value)
    shown = text if len(text) <= 80 else f"{text[:76]} ..."
    return BadValue(f"{attribute.GetPath()} is a {attribute.GetTypeName()}; it does not take {shown}")
