"""The box of what is drawn of a gprim, whatever `extent` is authored: exporters leave extents that do not fit."""

from collections.abc import Sequence

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.stage.geometry.instancer_box import instancer_box
from usdsdg.stage.geometry.point_names import draws_in_a_circle, lacks_prototypes
from usdsdg.stage.geometry.skinning import Skinning
from usdsdg.stage.poses.transforms import as_array, local_to_world

# Purposes of what is drawn in pictures.
DRAWN_PURPOSES = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


class DrawnBoxes:
    """Boxes of gprims and point instancers at one time, those of instances computed once."""

    def __init__(self, time: Usd.TimeCode, purposes: Sequence[str] = DRAWN_PURPOSES) -> None:
        self._time, self._purposes = time, tuple(purposes)
        self._cache = UsdGeom.BBoxCache(time, list(purposes))
        self._skinning = Skinning()
        self._own: dict[Usd.Prim, np.ndarray | None] = {}

    def own(self, prim: Usd.Prim) -> np.ndarray | None:
        """Return the lowest and highest corner (2, 3) in the prim's own frame; None for none that is finite."""
        skinned = self._skinning.skin(prim, self._time) if prim.IsA(UsdGeom.Mesh) else None
        if skinned is not None:
            box = np.array([skinned.points.min(axis=0), skinned.points.max(axis=0)], np.float64)
            return box if np.isfinite(box).all() else None
        source = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        if source not in self._own:
            self._own[source] = self._computed(source)
        return self._own[source]

    def in_world(self, prim: Usd.Prim) -> np.ndarray | None:
        """Return the lowest and highest corner (2, 3) in the world; None for no geometry."""
        own = self.own(prim)
        if own is None:
            return None
        to_world = as_array(local_to_world(prim, self._time))
        corners = np.array([[own[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
        corners = corners @ to_world[:3, :3] + to_world[3, :3]
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    def _computed(self, prim: Usd.Prim) -> np.ndarray | None:
        if prim.IsA(UsdGeom.Gprim):
            extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), self._time)
            box = np.array(extent, np.float64) if extent is not None and len(extent) == 2 else np.full((2, 3), np.nan)
            if np.isfinite(box).all() and (box[0] <= box[1]).all():
                return box
        elif prim.IsA(UsdGeom.PointInstancer):
            if draws_in_a_circle(prim) or lacks_prototypes(prim):
                return None  # which would not end, or fail
            return instancer_box(prim, self._time, self._purposes, self.own)
        found = self._cache.ComputeUntransformedBound(prim).ComputeAlignedRange()
        box = np.array([found.GetMin(), found.GetMax()])
        return None if found.IsEmpty() or not np.isfinite(box).all() else box
