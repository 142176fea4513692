"""Assign rows of the material table to the material slots of gprims."""

from collections.abc import Sequence

import numpy as np
from pxr import Sdf

from usdsdg_render.materials.display_color import DisplayColor
from usdsdg_render.materials.material_table import AnyMaterial, MaterialTable
from usdsdg_render.sync.gprims import Gprim


class MaterialSlots:
    """A contiguous range of slots for each gprim, one slot for each of its materials.

    Ranges keep their position when materials change, and those of hidden gprims stay while they are few, so that
    hiding and showing gprims changes no material table.
    """

    def __init__(self) -> None:
        self._materials: dict[Sdf.Path, tuple[AnyMaterial, ...]] = {}  # of gprims drawn now or before
        self.table = MaterialTable()
        self.first: dict[Sdf.Path, int] = {}  # first slot of each gprim, as last assigned
        self.rows = np.zeros(0, np.int32)  # row of the table, for each slot

    def assign(self, gprims: Sequence[Gprim]) -> None:
        """Assign slots to all drawn gprims."""
        if len(self._materials) > 2 * len(gprims) + 64:
            drawn = {gprim.path for gprim in gprims}
            self._materials = {path: materials for path, materials in self._materials.items() if path in drawn}
        ranges = self._materials
        ranges.update((gprim.path, tuple(gprim.materials or ())) for gprim in gprims)
        ends = np.cumsum([len(materials) for materials in ranges.values()], dtype=np.int64)
        self.first = {path: end - len(materials) for (path, materials), end in zip(ranges.items(), ends.tolist())}
        before = self.rows.tolist()
        if len(self.table) > 4 * (ends[-1] if len(ends) else 0) + 64:
            self.table, before = MaterialTable(), []
        # Rows that are still used must not be given back in between.
        take = self.table.take
        self.rows = np.array([take(material) for materials in ranges.values() for material in materials], np.int32)
        self.table.release(before)

    def recolor(self, gprims: Sequence[Gprim]) -> bool:
        """As `reassign`, of gprims that have one displayColor each: in their rows, where no other gprim has these."""
        paths = [gprim.path for gprim in gprims]
        materials = [tuple(gprim.materials or ()) for gprim in gprims]
        colors = [each for own in materials for each in own if isinstance(each, DisplayColor)]
        slots = [self.first[path] for path in paths if len(self._materials.get(path, ())) == 1]
        if not len(gprims) == len(colors) == len(slots):
            return self.reassign(gprims)
        if not self.table.recolor(self.rows[slots].tolist(), colors):
            return self.reassign(gprims)
        self._materials.update(zip(paths, materials))
        return True

    def reassign(self, gprims: Sequence[Gprim]) -> bool:
        """Give the slots of some gprims their materials of now; False, changing nothing, if that takes other slots."""
        changed = {gprim.path: tuple(gprim.materials or ()) for gprim in gprims}
        if any(len(self._materials.get(path, ())) != len(materials) for path, materials in changed.items()):
            return False
        self._materials.update(changed)
        slots = [self.first[path] + k for path, materials in changed.items() for k in range(len(materials))]
        # First given back, so that materials that differ from frame to frame do so in the same rows.
        self.table.release(self.rows[slots].tolist())
        self.rows = self.rows.copy()
        self.rows[slots] = [self.table.take(each) for materials in changed.values() for each in materials]
        return True
