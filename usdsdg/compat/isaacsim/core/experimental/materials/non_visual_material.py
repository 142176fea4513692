"""`NonVisualMaterial`: what lidar and radar would see; the stage keeps it, no sensor of usdsdg reads it.

A material has a base, a coating and an attribute, as texts; 16 bits encode them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Sdf, Usd

from usdsdg.arguments.registry import near_misses
from usdsdg.compat.isaacsim.core.experimental.materials.material import Material
from usdsdg.compat.wrappers import prim_paths
from usdsdg.compat.wrappers.arrays import as_numpy, as_warp, names

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices

PREFIX = "omni:simready:nonvisual"
NONE = "none"
# By their numbers.
BASES = (
    "none aluminum steel oxidized_steel iron oxidized_iron silver brass bronze oxidized_Bronze_Patina tin plastic "
    "fiberglass carbon_fiber vinyl plexiglass pvc nylon polyester clear_glass frosted_glass one_way_mirror mirror "
    "ceramic_glass asphalt concrete leaf_grass dead_leaf_grass rubber wood bark cardboard paper fabric skin fur_hair "
    "leather marble brick stone gravel dirt mud water salt_water snow ice calibration_lambertion"
)
_NUMBERS: Mapping[str, Mapping[str, int]] = {
    "base": {name: number for number, name in enumerate(BASES.split())},
    "coating": {"none": 0, "paint": 1, "clearcoat": 2, "paint_clearcoat": 3},
    "attributes": {"none": 0, "emissive": 1, "retroreflective": 2, "single_sided": 4, "visually_transparent": 8},
}
# Lowest bit and number of bits of each.
_BITS = {"base": (0, 8), "coating": (8, 3), "attributes": (11, 5)}

Texts = str | Sequence[str]


class NonVisualMaterial(Material):
    """Materials with a base, a coating and an attribute, beside what a visual material says of them."""

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        bases: Texts | None = None,
        coatings: Texts | None = None,
        attributes: Texts | None = None,
    ) -> None:
        """Wrap materials, or define them.

        Raises:
            AssertionError: a prim is no material.
            ValueError: some prims exist and others do not, or a text is not known.
        """
        super().__init__(paths)
        for prim in self.prims:
            for kind in _NUMBERS:
                if not prim.HasAttribute(f"{PREFIX}:{kind}"):
                    prim.CreateAttribute(f"{PREFIX}:{kind}", Sdf.ValueTypeNames.String, custom=True).Set(NONE)
        for kind, values in (("base", bases), ("coating", coatings), ("attributes", attributes)):
            if values is not None:
                self._write(kind, values, None)

    def set_bases(self, bases: Texts, *, indices: Indices = None) -> None:
        """Set what the materials are of; one text serves for all.

        Raises:
            ValueError: it is not known.
        """
        self._write("base", bases, indices)

    def get_bases(self, *, indices: Indices = None) -> list[str]:
        return self._read("base", indices)

    def set_coatings(self, coatings: Texts, *, indices: Indices = None) -> None:
        """Set what the materials are coated with; errors as of `set_bases`."""
        self._write("coating", coatings, indices)

    def get_coatings(self, *, indices: Indices = None) -> list[str]:
        return self._read("coating", indices)

    def set_attributes(self, attributes: Texts, *, indices: Indices = None) -> None:
        """Set a property of the materials; errors as of `set_bases`."""
        self._write("attributes", attributes, indices)

    def get_attributes(self, *, indices: Indices = None) -> list[str]:
        return self._read("attributes", indices)

    @staticmethod
    def encode_material_ids(prims: Any) -> wp.array:
        """Return the numbers (N, 1) of the materials of paths, prims or a wrapper; 0 for what a prim does not say."""
        if isinstance(prims, NonVisualMaterial):
            found = prims.prims
        else:
            found = [prim_paths.prim_of(each) for each in (prims if isinstance(prims, list) else [prims])]
        return as_warp(np.array([[_number(prim)] for prim in found], np.uint16))

    @staticmethod
    def decode_material_ids(ids: Any) -> list[tuple[str, str, str]]:
        """Return base, coating and attribute of each number.

        Raises:
            ValueError: a number does not fit into 16 bits.
        """
        numbers = np.atleast_1d(as_numpy(ids)).ravel()
        if wrong := [int(each) for each in numbers if not 0 <= int(each) <= 0xFFFF]:
            raise ValueError(f"{wrong[0]} is no number of a material; expected 0 to 65535")
        return [(_name("base", each), _name("coating", each), _name("attributes", each)) for each in map(int, numbers)]

    def _write(self, kind: str, values: Texts, indices: Indices) -> None:
        prims = self._chosen(indices)
        texts = names(values, len(prims))
        for text in texts:
            if text not in _NUMBERS[kind]:
                close = near_misses(text, list(_NUMBERS[kind]))
                hint = f"did you mean {close[0]!r}?" if close else f"known: {', '.join(_NUMBERS[kind])}"
                raise ValueError(f"NonVisualMaterial has no {kind} {text!r}; {hint}")
        for prim, text in zip(prims, texts, strict=True):
            prim.GetAttribute(f"{PREFIX}:{kind}").Set(text)

    def _read(self, kind: str, indices: Indices) -> list[str]:
        return [prim.GetAttribute(f"{PREFIX}:{kind}").Get() for prim in self._chosen(indices)]


def _number(prim: Usd.Prim) -> int:
    number = 0
    for kind, (lowest, count) in _BITS.items():
        attribute = prim.GetAttribute(f"{PREFIX}:{kind}")
        value = _NUMBERS[kind].get(attribute.Get() if attribute else NONE, 0)
        number |= (value & ((1 << count) - 1)) << lowest
    return number


def _name(kind: str, number: int) -> str:
    lowest, count = _BITS[kind]
    value = number >> lowest & ((1 << count) - 1)
    return next((name for name, each in _NUMBERS[kind].items() if each == value), NONE)
