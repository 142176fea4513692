"""Balls whose hull holds points and curves: as wide as these are drawn."""

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.annotators.bounds.curves import along_curves
from usdsdg.stage.geometry.point_velocities import moved_points
from usdsdg.stage.geometry.skinning import Skinning

_DEFAULT_WIDTH = 1.0  # of prims without widths [stage units], as they are drawn


def read_balls(prim: Usd.Prim, time: Usd.TimeCode, skinning: Skinning) -> tuple[np.ndarray, np.ndarray]:
    """Return the centers (N, 3) and radii (N,) of balls around what Points or curves show [units of the prim].

    Curves whose widths are not one for each vertex have the largest one everywhere.
    """
    skinned = skinning.skin(prim, time)
    points = skinned.points if skinned is not None else moved_points(prim, time)
    points = UsdGeom.PointBased(prim).GetPointsAttr().Get(time) if points is None else points
    centers = np.asarray(() if points is None else points, np.float64).reshape(-1, 3)
    balls = np.column_stack([centers, _widths(prim, time, len(centers)) / 2])
    if prim.IsA(UsdGeom.Curves):
        balls = along_curves(prim, time, balls)
    drawn = balls[np.isfinite(balls).all(axis=1) & (balls[:, 3] > 0.0)]
    return drawn[:, :3], drawn[:, 3]


def _widths(prim: Usd.Prim, time: Usd.TimeCode, count: int) -> np.ndarray:
    """Return the diameters (count,); `primvars:widths` wins over `widths`. Indices out of range take the first one."""
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("widths")
    values = primvar.Get(time) if primvar and primvar.HasAuthoredValue() else None
    attribute = prim.GetAttribute("widths") if not values else primvar.GetAttr()
    indices = np.asarray(primvar.GetIndices(time) or () if values else (), np.int64)
    values = np.asarray(values or attribute.Get(time) or [_DEFAULT_WIDTH], np.float64)
    if len(indices):
        values = values[np.where((indices < 0) | (indices >= len(values)), 0, indices)]
    is_points = prim.IsA(UsdGeom.Points)
    if len(values) >= count and (is_points or attribute.GetMetadata("interpolation") in (None, "vertex")):
        return values[:count]
    return np.full(count, values[0] if is_points else values[np.isfinite(values)].max(initial=0.0))
