"""Values of UsdLux attributes, and the color that a light emits."""

import math
from collections.abc import Mapping

import numpy as np
from pxr import Gf, Usd, UsdLux

from usdsdg import errors
from usdsdg_render.usd.authored_values import as_floats
from usdsdg_render.usd.color_spaces import current_color

# Larger values overflow float32 in later computations.
BRIGHTEST = 1e20

# A color that is brighter is one in levels of 0 to 255: scripts that mean to exaggerate stay below.
BRIGHTEST_COLOR = 16.0

# The schema's fallbacks of `inputs:intensity` that are not 1.
FIRST_INTENSITIES = {"DistantLight": 50000.0}
# Inputs of UsdLuxShapingAPI, and those of UsdLuxShadowAPI beside its switch, with values that change nothing.
SHAPING = {"shaping:cone:angle": 180.0, "shaping:focus": 0.0, "shaping:ies:file": ""}
SHADOW = {"shadow:color": Gf.Vec3f(0.0), "shadow:distance": -1.0, "shadow:falloff": -1.0}

_WHITE = np.array(UsdLux.BlackbodyTemperatureAsRgb(6500.0))


def light_value(prim: Usd.Prim, name: str, default):
    """Return the value of `inputs:<name>`, or of `<name>` as files before USD 21.02 wrote it."""
    attribute = prim.GetAttribute(f"inputs:{name}")
    if not (attribute and attribute.HasAuthoredValue()):
        old = prim.GetAttribute(name)
        if old and old.HasAuthoredValue():
            attribute = old
    value = current_color(attribute) if attribute else None
    return default if value is None else _typed(prim, name, value, default)


def _typed(prim: Usd.Prim, name: str, value, default):
    """Convert a value to the type of the default (numbers to floats); if impossible warn and return the default."""
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


def changed_inputs(prim: Usd.Prim, neutral: Mapping[str, object]) -> list[str]:
    """Return the inputs of a light, of those given with values that change nothing, that have another one."""
    attributes = {name: prim.GetAttribute(f"inputs:{name}") for name in neutral}
    values = {name: each.Get() for name, each in attributes.items() if each and each.HasAuthoredValue()}
    return [f"inputs:{name}" for name, value in values.items() if getattr(value, "path", value) != neutral[name]]


def light_number(prim: Usd.Prim, name: str, default: float) -> float:
    """Return a finite number; `default` (with a warning) for NaN and infinity."""
    value = float(light_value(prim, name, default))
    if math.isfinite(value):
        return value
    errors.warn_once(f"{prim.GetPath()}: inputs:{name} = {value} is not usable; {default} is used. Correct it.")
    return default


def emitted_color(prim: Usd.Prim) -> np.ndarray | None:
    """Return (3,) intensity * 2^exposure * color * temperature; None (with a warning) if that is out of range."""
    color = [float(channel) for channel in light_value(prim, "color", (1.0, 1.0, 1.0))]
    intensity = float(light_value(prim, "intensity", FIRST_INTENSITIES.get(str(prim.GetTypeName()), 1.0)))
    exposure = float(light_value(prim, "exposure", 0.0))
    # Channel by channel, since NumPy takes longer for so few. 2.0**exposure would raise where this is infinite.
    with np.errstate(over="ignore", invalid="ignore"):
        gain = float(np.exp2(exposure)) if exposure else 1.0
    if max(color) > BRIGHTEST_COLOR:
        errors.warn_once(
            f"{prim.GetPath()}: inputs:color is {max(color):g}, which multiplies the intensity. Colors are 0 to 1: "
            "divide levels of 0 to 255 by 255, and make lights brighter by their intensity.",
            key="colors of lights in levels of 0 to 255",  # one for a thousand lights of a randomizer
        )
    color = [channel * intensity * gain for channel in color]
    if light_value(prim, "enableColorTemperature", False):
        tint = temperature_color(light_number(prim, "colorTemperature", 6500.0)).tolist()
        color = [channel * factor for channel, factor in zip(color, tint, strict=True)]
    if not all(0.0 <= channel <= BRIGHTEST for channel in color):
        errors.warn_once(
            f"{prim.GetPath()}: intensity, exposure and color give {color}, which is no light; it is off. "
            f"Author values from 0 to {BRIGHTEST:g}."
        )
        return None
    return np.array(color)


def temperature_color(kelvin: float) -> np.ndarray:
    """Return the (3,) linear Rec.709 color of a black body, white at 6500 K as the schema asks."""
    return np.array(UsdLux.BlackbodyTemperatureAsRgb(kelvin)) / _WHITE
