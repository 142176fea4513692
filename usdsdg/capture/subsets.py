"""GeomSubsets as gprims of their own: with `/syntheticdata/sensors/perSubsetSegmentation`, masks tell them apart."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.annotators.point_instances import prim_path
from usdsdg.session.settings_store import get_settings
from usdsdg.session.stage_context import current_stage

SETTING = "/syntheticdata/sensors/perSubsetSegmentation"


@dataclass(frozen=True)
class GprimTable:
    """The gprims of the renderer, followed by the subsets that are told apart."""

    gprims: tuple[str, ...]
    # Of each gprim with subsets: the entry of each of its faces, (F,).
    parts: Mapping[int, np.ndarray] = field(default_factory=dict)

    @property
    def meshes(self) -> np.ndarray:
        """The gprim of each entry, (E,) int64: that of a subset is its mesh."""
        found = np.arange(len(self.gprims))
        for gprim, of_face in self.parts.items():
            found[of_face] = gprim
        return found

    def instances(self, entries: np.ndarray) -> np.ndarray:
        """Return the gprim of each pixel, -1 for no hit, from its entry."""
        return np.append(self.meshes, -1)[entries].astype(np.int32) if self.parts else entries

    def entries(self, instance: np.ndarray, face: np.ndarray) -> np.ndarray:
        """Return the entry of each pixel, -1 for no hit, from its gprim and the face of its source mesh."""
        entries = instance.copy()
        for gprim, of_face in self.parts.items():
            inside = instance == gprim
            # A face is out of range only where the mesh itself is broken.
            entries[inside] = of_face[np.minimum(face[inside], len(of_face) - 1)]
        return entries


def gprim_table(gprims: Sequence[str], time: Usd.TimeCode) -> GprimTable:
    """Return the table of the renderer's gprims, with their subsets of faces if the setting is on.

    A face of several subsets belongs to the last of them.
    """
    if not get_settings().get_as_bool(SETTING):
        return GprimTable(tuple(gprims))
    stage, entries, parts = current_stage(), list(gprims), {}
    for index, gprim in enumerate(gprims):
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath(prim_path(gprim)))
        subsets = UsdGeom.Subset.GetAllGeomSubsets(mesh) if mesh else []
        faces = len(mesh.GetFaceVertexCountsAttr().Get(time) or ()) if subsets else 0
        if not faces:
            continue
        points = gprim[len(str(mesh.GetPath())) :]  # of point instancers
        of_face = np.full(faces, index, np.int32)
        for subset in subsets:
            if subset.GetElementTypeAttr().Get(time) == UsdGeom.Tokens.face:
                chosen = np.asarray(subset.GetIndicesAttr().Get(time) or (), np.int64)
                of_face[chosen[(chosen >= 0) & (chosen < faces)]] = len(entries)
                entries.append(f"{subset.GetPath()}{points}")
        parts[index] = of_face
    return GprimTable(tuple(entries), parts)
