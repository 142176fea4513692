"""Prims above rigid bodies that time samples move: bodies do not go along, so their local poses do the opposite."""

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.stage.time_code import current_time, transform_varies
from usdsdg_physics.writeback.pose_matrices import PoseMatrices


class MovedParents:
    """The parents of the bodies of a writer whose matrices vary with time."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._parents: list[tuple[int, Usd.Prim, Usd.Prim | None]] = []  # row, parent, the body above it
        self._varies: dict[Sdf.Path, bool] = {}  # of parents: many bodies have the same
        self._time = current_time()

    def add(self, row: int, prim: Usd.Prim, ancestor: str | None) -> None:
        """Add the body `prim` if what is between it and the body `ancestor`, or the world, varies."""
        above = self._stage.GetPrimAtPath(ancestor) if ancestor is not None else None
        parent = prim.GetParent()
        path = parent.GetPath()
        if path not in self._varies:
            self._varies[path] = _varies_below(parent, above)
        if self._varies[path]:
            self._parents.append((row, parent, above))

    def update(self, matrices: PoseMatrices) -> list[int]:
        """Tell `matrices` where parents are at the time of the context; return the rows of their bodies."""
        if self._time == current_time():
            return []
        self._time = current_time()
        cache = UsdGeom.XformCache(self._time)
        for row, parent, above in self._parents:
            if above is not None:
                matrices.move_in_ancestor(row, np.array(cache.ComputeRelativeTransform(parent, above)[0]))
            else:
                matrices.move_parent(row, np.array(cache.GetLocalToWorldTransform(parent)))
        return [row for row, _, _ in self._parents]


def _varies_below(prim: Usd.Prim, above: Usd.Prim | None) -> bool:
    """Return whether the matrix from a prim to one above it, or to the world, varies."""
    while prim and prim != above:
        if transform_varies(prim):
            return True
        xformable = UsdGeom.Xformable(prim)
        if xformable and xformable.GetResetXformStack():
            return False
        prim = prim.GetParent()
    return False
