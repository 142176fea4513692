"""Which row of the material table each slot of each gprim has."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Sdf

from usdsdg_render.materials.shading import Material
from usdsdg_render.sync.gprims import Gprim


class MaterialSlots:
    """For each gprim a run of slots, one for each of its materials.

    Runs keep their place when materials change, and those of gprims that are hidden stay while they are few, so that
    hiding and showing touches no material.
    """

    def __init__(self) -> None:
        self._runs: dict[Sdf.Path, tuple[Material, ...]] = {}  # of gprims drawn now or lately
        self.begins: dict[Sdf.Path, int] = {}  # of each gprim, as last assigned
        self.rows = np.zeros(0, np.int32)  # of each slot, in what `assign` gave

    def assign(self, gprims: Sequence[Gprim]) -> list[Material]:
        """Note the materials of `gprims`; each different material of all slots once."""
        if len(self._runs) > 2 * len(gprims) + 64:
            drawn = {gprim.path for gprim in gprims}
            self._runs = {path: run for path, run in self._runs.items() if path in drawn}
        runs = self._runs
        runs.update((gprim.path, tuple(gprim.materials or ())) for gprim in gprims)
        ends = np.cumsum([len(run) for run in runs.values()], dtype=np.int64)
        self.begins = {path: end - len(run) for (path, run), end in zip(runs.items(), ends.tolist())}
        # By identity first: comparing whole materials costs more.
        unique = {id(material): material for run in runs.values() for material in run}
        rows: dict[Material, int] = {}
        row_of = {number: rows.setdefault(material, len(rows)) for number, material in unique.items()}
        self.rows = np.array([row_of[id(material)] for run in runs.values() for material in run], np.int32)
        return list(rows)
