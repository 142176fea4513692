"""Assign rows of the material table to the material slots of gprims."""

from collections.abc import Sequence

import numpy as np
from pxr import Sdf

from usdsdg_render.materials.shading import Material
from usdsdg_render.sync.gprims import Gprim


class MaterialSlots:
    """A contiguous range of slots for each gprim, one slot for each of its materials.

    Ranges keep their position when materials change, and those of hidden gprims stay while they are few, so that
    hiding and showing gprims changes no material table.
    """

    def __init__(self) -> None:
        self._materials: dict[Sdf.Path, tuple[Material, ...]] = {}  # of gprims drawn now or before
        self.first: dict[Sdf.Path, int] = {}  # first slot of each gprim, as last assigned
        self.rows = np.zeros(0, np.int32)  # row of each slot, in the list that `assign` returned

    def assign(self, gprims: Sequence[Gprim]) -> list[Material]:
        """Assign slots to `gprims`; return the materials of all slots, each different one once."""
        if len(self._materials) > 2 * len(gprims) + 64:
            drawn = {gprim.path for gprim in gprims}
            self._materials = {path: materials for path, materials in self._materials.items() if path in drawn}
        ranges = self._materials
        ranges.update((gprim.path, tuple(gprim.materials or ())) for gprim in gprims)
        ends = np.cumsum([len(materials) for materials in ranges.values()], dtype=np.int64)
        self.first = {path: end - len(materials) for (path, materials), end in zip(ranges.items(), ends.tolist())}
        # By identity first: comparing whole materials costs more.
        unique = {id(material): material for materials in ranges.values() for material in materials}
        rows: dict[Material, int] = {}
        row_of = {identity: rows.setdefault(material, len(rows)) for identity, material in unique.items()}
        self.rows = np.array(
            [row_of[id(material)] for materials in ranges.values() for material in materials], np.int32
        )
        return list(rows)
