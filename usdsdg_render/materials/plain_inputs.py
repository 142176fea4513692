"""Inputs that make one field of one material, alone: most edits are of the same ones, over and over."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from pxr import Sdf, Usd

from usdsdg.stage.time_code import current_values
from usdsdg_render.materials.network import Reading
from usdsdg_render.materials.shading import Material

if TYPE_CHECKING:
    from usdsdg_render.materials.materials import MaterialEntry


class PlainInput(NamedTuple):
    """An input of a shading prim that makes one field of one material."""

    prim: Sdf.Path
    name: str
    material: Sdf.Path  # that reads it
    entry: MaterialEntry
    reading: Reading


class FieldEdits(NamedTuple):
    """A field that was set in place in several materials, by their paths."""

    name: str
    paths: Sequence[Sdf.Path]
    materials: Sequence[Material]


def edit_materials(inputs: Sequence[PlainInput]) -> tuple[list[FieldEdits], list[PlainInput]]:
    """Set the fields that inputs make now, in the materials that are there.

    No other entry has such a material: an input is plain only after an edit, which made the material of its own.

    Returns:
        What was set, and the inputs that are not plain any more.
    """
    plain: dict[tuple[Any, str], list[PlainInput]] = {}
    others: list[PlainInput] = []
    for each in inputs:
        entry, reading = each.entry, each.reading
        if reading.alone is None or len(reading.fields) != 1 or entry.users != 1:
            others.append(each)
        else:
            (name,) = reading.fields
            plain.setdefault((reading.alone, name), []).append(each)
    found = [_set(name, make, some, others) for (make, name), some in plain.items()]
    return [edits for edits in found if edits.paths], others


def _set(name: str, make: Any, inputs: Sequence[PlainInput], others: list[PlainInput]) -> FieldEdits:
    """Set a field; add the inputs to `others` that do not make it."""
    attributes = [each.reading.attribute for each in inputs]
    values = current_values(attributes)
    made = make(values, [each.reading.given for each in inputs])
    connected = map(Usd.Attribute.HasAuthoredConnections, attributes)
    paths: list[Sdf.Path] = []
    materials: list[Material] = []
    for each, value, field, is_connected in zip(inputs, values, made, connected):
        material = each.entry.material
        if field is None or is_connected or material is None:
            others.append(each)
            continue
        each.reading.value = value
        material.set_field(name, field)
        paths.append(each.material)
        materials.append(material)
    return FieldEdits(name, paths, materials)
