"""Set attributes of physics schemas by their names with or without the schema's prefix."""

from typing import Any

from pxr import Usd

from usdsdg.errors import BadPrim
from usdsdg.stage.attributes import missing_attribute, set_value


def set_attributes(prim: Usd.Prim, attributes: dict[str, Any], prefixes: tuple[str, ...]) -> None:
    """Set attributes that the prim's schemas have; a `name` without a prefix is tried with each prefix, in order.

    None leaves an attribute as it is. Case does not matter where no name matches exactly.

    Raises:
        BadPrim: there is no such attribute; names near misses.
        BadValue: an attribute does not take its value.
    """
    known = [name for name in prim.GetPropertyNames() if name.startswith(tuple(f"{each}:" for each in prefixes))]
    for name, value in attributes.items():
        if value is not None:
            set_value(prim.GetAttribute(_full_name(prim, name, prefixes, known)), value)


def _full_name(prim: Usd.Prim, name: str, prefixes: tuple[str, ...], known: list[str]) -> str:
    candidates = [name] if ":" in name else [f"{prefix}:{name}" for prefix in prefixes]
    folded = {each.casefold(): each for each in known}
    for candidate in candidates:
        if candidate in known:
            return candidate
    for candidate in candidates:
        if candidate.casefold() in folded:
            return folded[candidate.casefold()]
    short = known if ":" in name else [each.partition(":")[2] for each in known]
    raise BadPrim(missing_attribute(prim, name, short))
