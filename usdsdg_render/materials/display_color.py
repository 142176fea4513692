"""Materials from a gprim's displayColor and displayOpacity, where none is bound or the bound one cannot be read."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pxr import Usd, UsdGeom, Vt

from usdsdg import errors
from usdsdg.stage.time_code import values_at
from usdsdg_render.images.textures import TextureUse
from usdsdg_render.materials.shading import MAX_COLOR, Input, Material
from usdsdg_render.usd.authored_values import as_array, as_floats
from usdsdg_render.usd.color_spaces import color_space, linear_colors

# UsdImaging's fallback displayColor.
DEFAULT_COLOR = (0.5, 0.5, 0.5)
NAME = "displayColor"


class DisplayColor(NamedTuple):
    """The material of a displayColor and displayOpacity; a `Material` of the same content costs ten times as much."""

    color: tuple[float, ...] = DEFAULT_COLOR
    opacity: float = 1.0

    @property
    def name(self) -> str:
        return NAME

    @property
    def textures(self) -> tuple[TextureUse, ...]:
        return ()

    @property
    def uv_primvar(self) -> str:
        return ""

    @property
    def material(self) -> Material:
        return Material(name=NAME, base_color=Input(self.color), opacity=Input((self.opacity,)))


class Shown(NamedTuple):
    """A displayColor or displayOpacity: its mean, None where there is none, and whether it varies over the gprim."""

    value: tuple[float, ...] | None
    varies: bool = False


def fallback_material(color: Shown, opacity: Shown) -> DisplayColor:
    """Return the material of a displayColor and displayOpacity: gray and opaque where there is none."""
    return DisplayColor(color.value or DEFAULT_COLOR, 1.0 if opacity.value is None else opacity.value[0])


def display_colors(attributes: Sequence[Usd.Attribute], time: Usd.TimeCode) -> list[Shown]:
    """Return the displayColor of prims, by their own attributes of it, or inherited."""
    return _read(attributes, "displayColor", time, Vt.Vec3fArray, 3)


def display_opacities(attributes: Sequence[Usd.Attribute], time: Usd.TimeCode) -> list[Shown]:
    """Return the displayOpacity of prims, by their own attributes of it, or inherited."""
    return _read(attributes, "displayOpacity", time, Vt.FloatArray, 1)


def _read(attributes: Sequence[Usd.Attribute], name: str, time: Usd.TimeCode, array: type, width: int) -> list[Shown]:
    """Read a primvar of many prims; most have one value, and these are checked together."""
    found: list[Shown | None] = [None] * len(attributes)
    rows, values = [], []
    for row, (attribute, value) in enumerate(zip(attributes, values_at(attributes, time))):
        if type(value) is array and len(value) == 1 and (width == 1 or color_space(attribute) is None):
            rows.append(row)
            values.append(value[0])
    numbers, usable = within_limits(array(values), width)
    for row, number, is_usable in zip(rows, numbers.tolist(), usable.tolist()):
        if is_usable:
            found[row] = Shown(tuple(number))
    own = zip(attributes, found)
    return [_read_one(each.GetPrim(), name, time, width) if shown is None else shown for each, shown in own]


def within_limits(values: Vt.Vec3fArray | Vt.FloatArray, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Return values as (N, `width`) float64 without negative numbers, and whether each can be used as it is, (N,)."""
    numbers = np.array(values, np.float64).reshape(-1, width)
    usable = np.isfinite(numbers) & (numbers <= MAX_COLOR)
    return np.clip(numbers, 0.0, None), np.all(usable, axis=1)


def _read_one(prim: Usd.Prim, name: str, time: Usd.TimeCode, width: int) -> Shown:
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
    value = primvar.Get(time) if primvar else None
    if value is not None and not primvar.GetTypeName().isArray:
        # Hydra takes one color of an Xform above for all below it; on gprims the schema asks for arrays.
        value = np.array([value], np.float64) if as_floats(value, width) else value
    array = as_array(primvar.GetAttr(), value, (3,) if width == 3 else ()) if primvar else None
    if array is None or not len(array):
        return Shown(None)
    array = _of_elements(primvar, array.astype(np.float64).reshape(-1, width), time)
    if width == 3:
        array = linear_colors(primvar.GetAttr(), array)
    if not np.isfinite(array).all():
        errors.warn_once(f"{primvar.GetAttr().GetPath()} holds NaN or infinity, so it is ignored. Correct it.")
        return Shown(None)
    if (array > MAX_COLOR).any():
        errors.warn_once(f"{primvar.GetAttr().GetPath()}: more than {MAX_COLOR:g} counts as that. Correct it.")
        array = np.minimum(array, MAX_COLOR)
    varies = bool((array != array[0]).any())
    return Shown(tuple(np.clip(array.mean(axis=0), 0.0, None).tolist()), varies)


def _of_elements(primvar: UsdGeom.Primvar, values: np.ndarray, time: Usd.TimeCode) -> np.ndarray:
    """Values by the indices that a primvar has, where all are in range; of a constant one the first."""
    indices = np.asarray(primvar.GetIndices(time) or (), np.int64)
    if len(indices) and indices.min() >= 0 and indices.max() < len(values):
        values = values[indices]
    if len(values) > 1 and primvar.GetInterpolation() == UsdGeom.Tokens.constant:
        errors.warn_once(
            f"{primvar.GetAttr().GetPath()}: its interpolation constant takes one value, so the first of {len(values)} "
            f"is used. Author the interpolation that has so many elements."
        )
        return values[:1]
    return values
