"""displayColors that are all that a gprim shows of a material: most edits are of the same ones, over and over."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, Vt

from usdsdg.stage.prims.handles import Handles
from usdsdg.stage.time_code import current_values
from usdsdg_render.materials.display_color import DisplayColor, Shown, within_limits
from usdsdg_render.usd.color_spaces import color_space

if TYPE_CHECKING:
    from usdsdg_render.sync.gprims import Gprim


@dataclass(frozen=True, eq=False)
class PlainColor:
    """A gprim that shows one displayColor of its own all over it; what that attribute is reported as."""

    gprim: Gprim


class PlainColors:
    """Reads plain displayColors again, all at once.

    Args:
        handles: gets the `PlainColor` of attributes that were written, for as long as they are plain.
    """

    def __init__(self, handles: Handles) -> None:
        self._handles = handles
        self._colors: Sequence[PlainColor] = ()  # of the last call
        self._gprims: list[Gprim] = []
        self._attributes: list[Usd.Attribute] = []

    def note(self, gprims: Iterable[Gprim]) -> None:
        """Report the displayColors of gprims, which were edited, by handles where they are plain, else by their names.

        None of the gprims has prims below, which would inherit the color: those are read anew after such an edit.
        """
        for gprim in gprims:
            gprim.is_recolored = False
            path = [gprim.shown[0].GetPath()]
            if not _is_plain(gprim):
                self._handles.drop(path)
                continue
            if gprim.plain_color is None:
                gprim.plain_color = PlainColor(gprim)
            self._handles.note(path, gprim.plain_color)

    def edit(self, colors: Sequence[PlainColor]) -> tuple[list[Gprim], list[Gprim]]:
        """Give gprims the materials of their displayColors now.

        Returns:
            The gprims that have one, and those that are not plain any more.
        """
        if colors is not self._colors:  # as in every frame that writes the same ones
            self._colors, self._gprims = colors, [each.gprim for each in colors]
            self._attributes = [gprim.shown[0] for gprim in self._gprims]
        values, gprims = current_values(self._attributes), self._gprims
        # Asked for each time, since no notice says what of an attribute changed without a call for each.
        has_space = list(map(Usd.Attribute.HasColorSpace, self._attributes))
        are_usual = set(map(type, values)) == {Vt.Vec3fArray} and set(map(len, values)) == {1} and True not in has_space
        others: list[Gprim] = []
        if not are_usual or not all(map(_shows_color_alone, gprims)):
            usual = [
                type(value) is Vt.Vec3fArray and len(value) == 1 and not has and _shows_color_alone(gprim)
                for gprim, value, has in zip(gprims, values, has_space)
            ]
            gprims, others = _parted(gprims, usual)
            values = [value for value, is_usual in zip(values, usual) if is_usual]
        numbers, usable = within_limits(Vt.Vec3fArray([value[0] for value in values]), 3)
        if not usable.all():
            gprims, unusable = _parted(gprims, usable.tolist())
            others, numbers = others + unusable, numbers[usable]
        _give(gprims, numbers)
        return gprims, others


def _parted(gprims: Sequence[Gprim], are_usual: Sequence[bool]) -> tuple[list[Gprim], list[Gprim]]:
    """Return those that are usual, and the others."""
    pairs = list(zip(gprims, are_usual))
    return [gprim for gprim, is_usual in pairs if is_usual], [gprim for gprim, is_usual in pairs if not is_usual]


def _give(gprims: Sequence[Gprim], colors: np.ndarray) -> None:
    """Give gprims the materials of these colors (N, 3) and of the displayOpacities that they had."""
    own = list(map(tuple, colors.tolist()))
    opacities = [material.opacity for gprim in gprims for material in gprim.materials or ()]
    for gprim, color, material in zip(gprims, map(Shown, own), map(DisplayColor, own, opacities)):
        gprim.color, gprim.materials = color, [material]


def _shows_color_alone(gprim: Gprim) -> bool:
    """Whether no material is bound to a gprim, as it was read last, nor made of what it emits."""
    materials = gprim.materials
    return gprim.bound == [None] and materials is not None and type(materials[0]) is DisplayColor


def _is_plain(gprim: Gprim) -> bool:
    """Whether a gprim shows one displayColor of its own, as it is, and nothing else."""
    attribute = gprim.shown[0]
    if not _shows_color_alone(gprim) or gprim.color_varies or gprim.prim.IsInstanceProxy() or not attribute:
        return False
    (value,) = current_values([attribute])
    is_single = type(value) is Vt.Vec3fArray and len(value) == 1
    return is_single and not attribute.HasColorSpace() and color_space(attribute) is None
