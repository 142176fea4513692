"""Materials as rows of `scene.MATERIAL`."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields

import numpy as np

from usdsdg import errors
from usdsdg_render.images.textures import TextureUse
from usdsdg_render.materials.display_color import DisplayColor
from usdsdg_render.materials.shading import MAX_COLOR, MAX_EMISSION, Input, Material
from usdsdg_render.scene.scene import MATERIAL, NO_TEXTURE

_COLUMNS = {name: MATERIAL[name] for name in MATERIAL.names or ()}
# Fields of `Material` that fill columns: beside that of the field's name those of its texture, and of the channel.
# `normal` and `detail` fill that of a texture alone.
_FIELDS = {
    each.name: (f"{each.name}_texture", f"{each.name}_channel")
    for each in fields(Material)
    if {each.name, f"{each.name}_texture"} & _COLUMNS.keys()
}

# Largest constants; those in neither table end at 1.
_HIGHEST = {"base_color": MAX_COLOR, "emission": MAX_EMISSION}
_UNLIMITED = ("ior", "thin", "normal_scale", "detail_scale")
_ROUNDING = 1e-5  # of 32-bit numbers that are products of others


def material_row(material: Material, indices: Mapping[TextureUse, int]) -> tuple:
    """The values of a row of `MATERIAL`: of an `Input` x those of x, x_texture and x_channel, else of the same name."""
    values: dict[str, object] = {}
    for name in _FIELDS:
        values |= field_columns(material, name, indices)
    return tuple(map(values.__getitem__, _COLUMNS))


def field_columns(material: Material, name: str, indices: Mapping[TextureUse, int]) -> dict[str, object]:
    """The columns of `MATERIAL` that one field of a material fills; none for fields that have no column."""
    value = getattr(material, name)
    if isinstance(value, Input):
        texture = NO_TEXTURE if value.texture is None else indices.get(value.texture, NO_TEXTURE)
        constant = _constant(material.name, name, value, textured=texture != NO_TEXTURE)
        texture_column, channel_column = _FIELDS[name]
        columns = {name: constant, texture_column: texture, channel_column: value.channel}
        return {column: each for column, each in columns.items() if column in _COLUMNS}
    if name in _COLUMNS:
        return {name: value if name in _UNLIMITED else _limited(material.name, name, value, 1.0)}
    if name in _FIELDS:
        return {_FIELDS[name][0]: NO_TEXTURE if value is None else indices.get(value, NO_TEXTURE)}
    return {}


def write_field(
    table: np.ndarray, rows: Sequence[int], materials: Sequence[Material], name: str, indices: Mapping[TextureUse, int]
) -> None:
    """Write the columns of one field of materials to their rows; inputs within their limits all at once."""
    values = [getattr(material, name) for material in materials]
    if all(type(value) is Input for value in values):
        textures = [NO_TEXTURE if v.texture is None else indices.get(v.texture, NO_TEXTURE) for v in values]
        constants = np.array([_given(v, textured=t != NO_TEXTURE) for v, t in zip(values, textures)])
        highest = _HIGHEST.get(name, 1.0)
        if constants.max() <= highest and constants.min() >= 0.0:
            numbers = np.clip(constants, 0.0, highest)
            table[name][rows] = numbers if _COLUMNS[name].shape else numbers[:, 0]
            for column, numbers in zip(_FIELDS[name], (textures, [value.channel for value in values])):
                if column in _COLUMNS:
                    table[column][rows] = numbers
            return
    for row, material in zip(rows, materials):
        for column, value in field_columns(material, name, indices).items():
            table[column][row] = value


def _constant(material: str, name: str, value: Input, *, textured: bool) -> float | tuple[float, ...]:
    """The constant of an input within its limits; beside a texture, a scalar may be any factor > 0."""
    constant = _given(value, textured=textured)
    if name in _HIGHEST:
        highest = _HIGHEST[name]
        if max(constant) > highest:
            errors.warn_once(
                f"{material}: a color of {max(constant):g} is more than 32-bit numbers can follow from surface to "
                f"surface; {highest:g} is used. Correct it."
            )
        return tuple(min(_limited(material, name, number, math.inf), highest) for number in constant)
    highest = 1.0 if _COLUMNS[name].shape or not textured else math.inf
    limited = tuple(_limited(material, name, number, highest) for number in constant)
    return limited if _COLUMNS[name].shape else limited[0]


def _given(value: Input, *, textured: bool) -> tuple[float, ...]:
    """The constant of an input, by whether its texture could be read."""
    return value.value if value.texture is None or textured or value.fallback is None else value.fallback


def _limited(material: str, name: str, value: float, highest: float) -> float:
    """Return a number from 0 to `highest`, with a warning if the one that is given is not."""
    limited = min(max(value, 0.0), highest)
    if abs(limited - value) > _ROUNDING:
        within, said = "of 0 or more" if highest == math.inf else f"from 0 to {highest:g}", name.replace("_", " ")
        errors.warn_once(
            f"{material}: its {said} is {value:g}, of which {limited:g} is used. Author one {within}.",
            key=f"{material}: {name} is out of range",  # whatever it is in other frames
        )
    return limited


# What all rows of display colors share, and what rows that no material uses hold.
PLAIN = np.array(material_row(DisplayColor().material, {}), MATERIAL)


def display_color_rows(colors: Sequence[DisplayColor]) -> np.ndarray:
    """Return `material_row` of many display colors, whose colors are within their limits."""
    rows = np.full(len(colors), PLAIN)
    rows["base_color"] = [each.color for each in colors]
    rows["opacity"] = np.clip([each.opacity for each in colors], 0.0, 1.0)
    return rows
