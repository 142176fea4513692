"""`isaacsim.core.experimental.utils.foundation`: the types of USD attributes by their names."""

from __future__ import annotations

from typing import Any

from pxr import Sdf

from usdsdg.arguments.registry import near_misses

_TYPES = {
    str(getattr(Sdf.ValueTypeNames, name)): getattr(Sdf.ValueTypeNames, name)
    for name in sorted(dir(Sdf.ValueTypeNames))
    if isinstance(getattr(Sdf.ValueTypeNames, name), Sdf.ValueTypeName)
}


def get_value_type_names(*, format: Any = str) -> list[Any]:
    """Return the names of all types (`format=str`), or the types (`Sdf.ValueTypeNames` of pxr or usdrt).

    Raises:
        ValueError: another format.
    """
    if format is str:
        return list(_TYPES)
    if format is Sdf.ValueTypeNames:
        return list(_TYPES.values())
    raise ValueError(f"format is {format!r}; it may be str or Sdf.ValueTypeNames")


def resolve_value_type_name(type_name: str | Sdf.ValueTypeName, *, backend: str | None = None) -> Sdf.ValueTypeName:
    """Return the type with a name such as "color3f" or "float[]"; types as they are, in each backend.

    Raises:
        ValueError: there is no such type, or the backend has no types.
    """
    if backend not in (None, "usd", "usdrt", "fabric"):
        raise ValueError(f"backend is {backend!r}; types are those of usd, usdrt and fabric")
    found = _TYPES.get(str(type_name))
    if found is None:
        near = near_misses(str(type_name), list(_TYPES))
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        raise ValueError(f"{type_name!r} is no type of USD{hint}")
    return found


def value_type_name_to_str(type_name: str | Sdf.ValueTypeName) -> str:
    """Return the name of a type, such as "color3f".

    Raises:
        ValueError: there is no such type.
    """
    return str(resolve_value_type_name(type_name))
