"""Bounding boxes of prims in the world [stage units], as float64 arrays."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from pxr import Gf, Usd, UsdGeom


def bbox_cache(time: Usd.TimeCode, use_extents_hint: bool) -> UsdGeom.BBoxCache:
    """Return a cache of the bounds of what is rendered."""
    return UsdGeom.BBoxCache(time, [UsdGeom.Tokens.default_], use_extents_hint)


def aligned(cache: UsdGeom.BBoxCache, prims: Iterable[Usd.Prim]) -> np.ndarray:
    """Return the box of all prims along the axes of the world: (6,) minimum x, y, z, then maximum x, y, z."""
    total = Gf.Range3d()
    for prim in prims:
        total.UnionWith(cache.ComputeWorldBound(prim).ComputeAlignedRange())
    return np.array([*total.GetMin(), *total.GetMax()])


def oriented(cache: UsdGeom.BBoxCache, prim: Usd.Prim) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return center (3,), axes (3, 3), one per row and with the prim's scale, and half sizes (3,) without it."""
    bound = cache.ComputeWorldBound(prim)
    axes = np.array(bound.GetMatrix().ExtractRotationMatrix())
    return np.array(bound.ComputeCentroid()), axes, np.array(bound.GetRange().GetSize()) * 0.5


def corners(centroid: np.ndarray, axes: np.ndarray, half_extent: np.ndarray) -> np.ndarray:
    """Return the corners (8, 3) of an oriented box; x changes slowest and z fastest, from minimum to maximum."""
    signs = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    return np.asarray(centroid) + (signs * np.asarray(half_extent)) @ np.asarray(axes)


def write_extents(prim: Usd.Prim, time: Usd.TimeCode) -> bool:
    """Author the extent that follows from a prim's points or sizes; return whether it has one."""
    boundable = UsdGeom.Boundable(prim)
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(boundable, time) if boundable else None
    if extent is None:
        return False
    boundable.CreateExtentAttr().Set(extent)
    return True
