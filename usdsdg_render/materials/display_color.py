"""Materials from a gprim's displayColor and displayOpacity, where none is bound or the bound one cannot be read."""

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg import errors
from usdsdg_render.materials.shading import MAX_COLOR, Input, Material
from usdsdg_render.usd.authored_values import as_array

# UsdImaging's fallback displayColor.
DEFAULT_COLOR = (0.5, 0.5, 0.5)


def fallback_material(color: tuple[float, ...] | None, opacity: float | None) -> Material:
    """Return the material of a displayColor and displayOpacity: gray and opaque where None."""
    return Material(
        name="displayColor",
        base_color=Input(tuple(color or DEFAULT_COLOR)),
        opacity=Input((1.0 if opacity is None else opacity,)),
    )


def display_color(prim: Usd.Prim, time: Usd.TimeCode) -> tuple[tuple[float, ...] | None, float | None, bool]:
    """Return (mean displayColor, mean displayOpacity, whether one of them varies); None where not authored."""
    values: list[tuple[float, ...] | None] = []
    varies = False
    for name, width in (("displayColor", 3), ("displayOpacity", 1)):
        primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
        value = primvar.Get(time) if primvar else None
        array = as_array(primvar.GetAttr(), value, (3,) if width == 3 else ()) if primvar else None
        if array is None or not len(array):
            values.append(None)
            continue
        array = array.astype(np.float64).reshape(-1, width)
        if not np.isfinite(array).all():
            errors.warn_once(f"{primvar.GetAttr().GetPath()} holds NaN or infinity, so it is ignored. Correct it.")
            values.append(None)
            continue
        if (array > MAX_COLOR).any():
            errors.warn_once(f"{primvar.GetAttr().GetPath()}: more than {MAX_COLOR:g} counts as that. Correct it.")
            array = np.minimum(array, MAX_COLOR)
        varies |= bool((array != array[0]).any())
        values.append(tuple(np.clip(array.mean(axis=0), 0.0, None).tolist()))
    color, opacity = values
    return color, None if opacity is None else opacity[0], varies
