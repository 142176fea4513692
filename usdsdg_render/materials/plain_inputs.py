"""Inputs that make one field of one material, alone: most edits are of the same ones, over and over."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from pxr import Sdf, Usd

from usdsdg.stage.prims.handles import Handles
from usdsdg.stage.time_code import current_values
from usdsdg_render.materials.network import MakeFields, Reading
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


class PlainInputs:
    """Sets the fields that plain inputs make, in the materials that are there.

    No other entry has such a material: an input is plain only after an edit, which made the material of its own.

    Args:
        handles: where the inputs come from. While it stays as it is, so does what was found out about them.
    """

    def __init__(self, handles: Handles) -> None:
        self._handles = handles
        self._version = -1
        self._inputs: Sequence[PlainInput] = ()  # of the last call
        self._groups: list[_Group] = []
        self._others: list[PlainInput] = []

    def edit_materials(self, inputs: Sequence[PlainInput]) -> tuple[list[FieldEdits], list[PlainInput]]:
        """Set the fields that inputs make now.

        Returns:
            What was set, and the inputs that are not plain any more.
        """
        if inputs is not self._inputs or self._version != self._handles.version:
            self._inputs, self._version = inputs, self._handles.version
            self._groups, self._others = _grouped(inputs)
        others = list(self._others)
        found = [group.edit_materials(others) for group in self._groups]
        return [edits for edits in found if edits.paths], others


def _grouped(inputs: Sequence[PlainInput]) -> tuple[list[_Group], list[PlainInput]]:
    """Return the inputs by what they make, and those that are not plain any more."""
    plain: dict[tuple[MakeFields, str], list[PlainInput]] = {}
    others: list[PlainInput] = []
    for each in inputs:
        entry, reading = each.entry, each.reading
        if reading.alone is None or len(reading.fields) != 1 or entry.users != 1 or entry.material is None:
            others.append(each)
        else:
            (name,) = reading.fields
            plain.setdefault((reading.alone, name), []).append(each)
    return [_Group(name, make, some) for (make, name), some in plain.items()], others


class _Group:
    """Inputs that make the same field in the same way, each of one material."""

    def __init__(self, name: str, make: MakeFields, inputs: Sequence[PlainInput]) -> None:
        self._make, self._inputs = make, inputs
        self._readings = [each.reading for each in inputs]
        self._attributes = [each.reading.attribute for each in inputs]
        self._given = [each.reading.given for each in inputs]
        self._are_colors = any(each.GetRoleName() == "Color" for each in self._attributes)
        materials = [material for each in inputs if (material := each.entry.material) is not None]
        self._edits = FieldEdits(name, [each.material for each in inputs], materials)

    def edit_materials(self, others: list[PlainInput]) -> FieldEdits:
        """Set the field; add the inputs to `others` that do not make it."""
        values = current_values(self._attributes)
        made = self._make(values, self._given)
        # Asked for each time, since no notice says what of an attribute changed without a call for each.
        unusual = [list(map(Usd.Attribute.HasAuthoredConnections, self._attributes))]
        if self._are_colors:
            unusual.append(list(map(Usd.Attribute.HasColorSpace, self._attributes)))
        edits = self._edits
        if None in made or any(True in found for found in unusual):
            are_other = [field is None or any(has) for field, has in zip(made, zip(*unusual))]
            others += [each for each, is_other in zip(self._inputs, are_other) if is_other]
            usual = [k for k, is_other in enumerate(are_other) if not is_other]
            edits = FieldEdits(edits.name, [edits.paths[k] for k in usual], [edits.materials[k] for k in usual])
            made, values = [made[k] for k in usual], [values[k] for k in usual]
            _note(values, [self._readings[k] for k in usual])
        else:
            _note(values, self._readings)
        Material.set_fields(edits.materials, edits.name, made)
        return edits


def _note(values: Sequence[Any], readings: Sequence[Reading]) -> None:
    for value, reading in zip(values, readings):
        reading.value = value
