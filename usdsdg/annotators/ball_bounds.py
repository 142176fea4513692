"""Balls whose hull holds points and curves: one around each point, as wide as it is drawn."""

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.stage.geometry.point_velocities import moved_points
from usdsdg.stage.geometry.skinning import Skinning

_DEFAULT_WIDTH = 1.0  # of prims without widths [stage units], as they are drawn


def read_balls(prim: Usd.Prim, time: Usd.TimeCode, skinning: Skinning) -> tuple[np.ndarray, np.ndarray]:
    """Return the centers (N, 3) and radii (N,) of balls around what Points or curves show [units of the prim].

    Curves have the radius of their largest width everywhere, as in UsdGeomCurves' extent.
    """
    skinned = skinning.skin(prim, time)
    points = skinned.points if skinned is not None else moved_points(prim, time)
    points = UsdGeom.PointBased(prim).GetPointsAttr().Get(time) if points is None else points
    centers = np.asarray(() if points is None else points, np.float64).reshape(-1, 3)
    widths = _widths(prim, time)
    one_each = prim.IsA(UsdGeom.Points) and len(widths) >= len(centers)
    radii = (widths[: len(centers)] if one_each else np.full(len(centers), _width_of_all(prim, widths))) / 2
    drawn = np.isfinite(centers).all(axis=1) & np.isfinite(radii) & (radii > 0.0)
    return centers[drawn], radii[drawn]


def _width_of_all(prim: Usd.Prim, widths: np.ndarray) -> float:
    """Return the largest width of curves; that of points which have one width, or too few."""
    finite = widths[np.isfinite(widths)]
    return float(widths[0] if prim.IsA(UsdGeom.Points) else finite.max(initial=0.0))


def _widths(prim: Usd.Prim, time: Usd.TimeCode) -> np.ndarray:
    """Return the diameters, at least one; `primvars:widths` wins over `widths`."""
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("widths")
    values = primvar.ComputeFlattened(time) if primvar and primvar.HasAuthoredValue() else None
    if not values:
        values = prim.GetAttribute("widths").Get(time)
    return np.asarray(values, np.float64) if values else np.full(1, _DEFAULT_WIDTH)
