"""Values of UsdLux attributes, and the light that they add up to."""

from __future__ import annotations

import math

import numpy as np
from pxr import Usd, UsdLux

from usdsdg import errors
from usdsdg_render.usd.authored_values import as_floats
from usdsdg_render.usd.time_code import value_now

# More leaves 32-bit numbers somewhere on its way.
BRIGHTEST = 1e20

_WHITE = np.array(UsdLux.BlackbodyTemperatureAsRgb(6500.0))


def light_value(prim: Usd.Prim, name: str, default):
    """Value of `inputs:<name>`, or of `<name>` as files before USD 21.02 wrote it."""
    attribute = prim.GetAttribute(f"inputs:{name}")
    if not (attribute and attribute.HasAuthoredValue()):
        old = prim.GetAttribute(name)
        if old and old.HasAuthoredValue():
            attribute = old
    value = value_now(attribute) if attribute else None
    return default if value is None else _typed(prim, name, value, default)


def _typed(prim: Usd.Prim, name: str, value, default):
    """The value as the default's type, in floats unless that is a flag or a word; else (with a warning) the default."""
    if isinstance(default, (bool, str)):
        usable = value if isinstance(value, str) == isinstance(default, str) else None
    else:
        usable = as_floats(value, len(default) if isinstance(default, tuple) else 1)
        if usable is not None and not isinstance(default, tuple):
            usable = usable[0]
    if usable is not None:
        return usable
    errors.warn_once(
        f"{prim.GetPath()}: inputs:{name} = {value} is not of the schema's type; {default} is used. Correct it."
    )
    return default


def light_number(prim: Usd.Prim, name: str, default: float) -> float:
    """A finite number; `default` (with a warning) for NaN and infinity."""
    value = float(light_value(prim, name, default))
    if math.isfinite(value):
        return value
    errors.warn_once(f"{prim.GetPath()}: inputs:{name} = {value} is not usable; {default} is used. Correct it.")
    return default


def emitted_colour(prim: Usd.Prim, fallback_intensity: float = 1.0) -> np.ndarray | None:
    """(3,) intensity * 2^exposure * color * temperature; None (with a warning) if it is no light."""
    colour = np.array(light_value(prim, "color", (1.0, 1.0, 1.0)), np.float64)
    colour = colour * float(light_value(prim, "intensity", fallback_intensity))
    with np.errstate(over="ignore", invalid="ignore"):
        colour = colour * np.exp2(float(light_value(prim, "exposure", 0.0)))
    if light_value(prim, "enableColorTemperature", False):
        colour = colour * temperature_colour(light_number(prim, "colorTemperature", 6500.0))
    if not np.isfinite(colour).all() or (colour < 0.0).any() or (colour > BRIGHTEST).any():
        errors.warn_once(
            f"{prim.GetPath()}: intensity, exposure and color give {colour.tolist()}, which is no light; it is off. "
            f"Author values from 0 to {BRIGHTEST:g}."
        )
        return None
    return colour


def temperature_colour(kelvin: float) -> np.ndarray:
    """(3,) linear Rec.709 of a black body, white at 6500 K as the schema asks."""
    return np.array(UsdLux.BlackbodyTemperatureAsRgb(kelvin)) / _WHITE
