"""GeomSubsets as gprims of their own: with `/syntheticdata/sensors/perSubsetSegmentation`, labels tell them apart."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from pxr import Usd

from usdsdg.annotators.point_instances import prim_path
from usdsdg.annotators.prims.subset_setting import subsets_are_told_apart
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.geometry.face_parts import read_face_parts


@dataclass(frozen=True)
class GprimTable:
    """The gprims of the renderer, followed by the GeomSubsets that have labels of their own."""

    gprims: tuple[str, ...]
    # Of each gprim with subsets: the entry of each of its faces, (F,).
    faces: Mapping[int, np.ndarray] = field(default_factory=dict)

    @property
    def meshes(self) -> np.ndarray:
        """The gprim of each entry, (E,) int64: that of a subset is its mesh."""
        found = np.arange(len(self.gprims))
        for gprim, of_face in self.faces.items():
            found[of_face] = gprim
        return found

    def instances(self, entries: np.ndarray) -> np.ndarray:
        """Return the gprim of each pixel, -1 for no hit, from its entry."""
        return np.append(self.meshes, -1)[entries].astype(np.int32) if self.faces else entries


def gprim_table(gprims: Sequence[str], time: Usd.TimeCode) -> GprimTable:
    """Return the table of the renderer's gprims, with their subsets of faces if the setting is on."""
    if not subsets_are_told_apart():
        return GprimTable(tuple(gprims))
    stage, entries, faces = current_stage(), list(gprims), {}
    for index, gprim in enumerate(gprims):
        path = prim_path(gprim)
        subsets, of_face = read_face_parts(stage.GetPrimAtPath(path), time)
        if subsets:
            points = gprim[len(str(path)) :]  # of point instancers
            faces[index] = np.where(of_face < 0, index, of_face + len(entries)).astype(np.int32)
            entries += [f"{subset}{points}" for subset in subsets]
    return GprimTable(tuple(entries), faces)
