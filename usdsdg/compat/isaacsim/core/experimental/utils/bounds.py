"""`isaacsim.core.experimental.utils.bounds`: bounding boxes in the world [stage units]."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.compat.wrappers import bounds
from usdsdg.compat.wrappers.bounds import corners as get_obb_corners
from usdsdg.compat.wrappers.prim_paths import existing_prim

__all__ = [
    "compute_aabb", "compute_combined_aabb", "compute_obb", "compute_obb_corners", "create_bbox_cache",
    "get_obb_corners",
]  # fmt: skip


def create_bbox_cache(
    time: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
    *,
    use_extents_hint: bool = True,
) -> UsdGeom.BBoxCache:
    """Return a cache of the bounds of what is rendered."""
    return bounds.bbox_cache(time, use_extents_hint)


def compute_aabb(
    prim: str | Usd.Prim, *, bbox_cache: UsdGeom.BBoxCache | None = None, include_children: bool = False
) -> np.ndarray:
    """Return the box along the axes of the world of a prim and all below it: (6,) minimum, then maximum.

    Raises:
        BadPrim: there is no such prim.
    """
    root = existing_prim(prim)
    prims = Usd.PrimRange(root) if include_children else [root]
    return bounds.aligned(bbox_cache or create_bbox_cache(), prims)


def compute_combined_aabb(
    prims: Sequence[str | Usd.Prim], *, bbox_cache: UsdGeom.BBoxCache | None = None
) -> np.ndarray:
    """Return the box along the axes of the world of several prims: (6,) minimum, then maximum.

    Raises:
        BadPrim: there is no such prim.
        ValueError: there are no prims.
    """
    if not prims:
        raise ValueError("compute_combined_aabb: there are no prims")
    return bounds.aligned(bbox_cache or create_bbox_cache(), [existing_prim(prim) for prim in prims])


def compute_obb(
    prim: str | Usd.Prim, *, bbox_cache: UsdGeom.BBoxCache | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return center (3,), axes (3, 3), one per row and with the prim's scale, and half sizes (3,) without it.

    Raises:
        BadPrim: there is no such prim.
    """
    return bounds.oriented(bbox_cache or create_bbox_cache(), existing_prim(prim))


def compute_obb_corners(prim: str | Usd.Prim, *, bbox_cache: UsdGeom.BBoxCache | None = None) -> np.ndarray:
    """Return the corners (8, 3) of the oriented box; x changes slowest and z fastest.

    Raises:
        BadPrim: there is no such prim.
    """
    return get_obb_corners(*compute_obb(prim, bbox_cache=bbox_cache))
