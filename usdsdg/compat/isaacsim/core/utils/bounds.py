"""`isaacsim.core.utils.bounds`: bounding boxes in the world [stage units]."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.compat.wrappers import bounds
from usdsdg.compat.wrappers.bounds import corners as get_obb_corners
from usdsdg.compat.wrappers.prim_paths import existing_prim
from usdsdg.errors import BadPrim

__all__ = [
    "compute_aabb", "compute_combined_aabb", "compute_obb", "compute_obb_corners", "create_bbox_cache",
    "get_obb_corners", "recompute_extents",
]  # fmt: skip


def create_bbox_cache(
    time: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
    use_extents_hint: bool = True,
) -> UsdGeom.BBoxCache:
    """Return a cache of the bounds of what is rendered."""
    return bounds.bbox_cache(time, use_extents_hint)


def recompute_extents(
    prim: Usd.Prim | UsdGeom.Boundable,
    time: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
    include_children: bool = False,
) -> None:
    """Author the extents that follow from points and sizes; prims below without bounds are passed over.

    Raises:
        BadPrim: the prim itself has no bounds.
    """
    root = existing_prim(prim)
    if include_children:
        for each in Usd.PrimRange(root):
            bounds.write_extents(each, time)
    elif not bounds.write_extents(root, time):
        raise BadPrim(f"{root.GetPath()} has no extent: it is a {root.GetTypeName() or 'prim without a type'}")


def compute_aabb(bbox_cache: UsdGeom.BBoxCache, prim_path: str, include_children: bool = False) -> np.ndarray:
    """Return the box along the axes of the world of a prim and all below it: (6,) minimum, then maximum.

    Raises:
        BadPrim: there is no such prim.
    """
    root = existing_prim(prim_path)
    return bounds.aligned(bbox_cache, Usd.PrimRange(root) if include_children else [root])


def compute_combined_aabb(bbox_cache: UsdGeom.BBoxCache, prim_paths: Sequence[str]) -> np.ndarray:
    """Return the box along the axes of the world of several prims: (6,) minimum, then maximum.

    Raises:
        BadPrim: there is no such prim.
        ValueError: there are no prims.
    """
    if not prim_paths:
        raise ValueError("compute_combined_aabb: there are no prims")
    return bounds.aligned(bbox_cache, [existing_prim(path) for path in prim_paths])


def compute_obb(bbox_cache: UsdGeom.BBoxCache, prim_path: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return center (3,), axes (3, 3), one per row and with the prim's scale, and half sizes (3,) without it.

    Raises:
        BadPrim: there is no such prim.
    """
    return bounds.oriented(bbox_cache, existing_prim(prim_path))


def compute_obb_corners(bbox_cache: UsdGeom.BBoxCache, prim_path: str) -> np.ndarray:
    """Return the corners (8, 3) of the oriented box; x changes slowest and z fastest.

    Raises:
        BadPrim: there is no such prim.
    """
    return get_obb_corners(*compute_obb(bbox_cache, prim_path))
