"""Bounds of prims, read from the stage for `redraw`, by ways of their own."""

from __future__ import annotations

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel

from usdsdg.stage.geometry.face_parts import read_face_parts
from usdsdg.stage.geometry.point_velocities import moved_points
from usdsdg.stage.semantics.labels import is_labeled


def bounds_below(root: Usd.Prim, time: Usd.TimeCode, cache: UsdGeom.XformCache) -> np.ndarray | None:
    """Return bounds (2, 3) around the boxes of all gprims at and below a prim, in its frame: no box of it is larger.

    None where the bounds of one are not known.
    """
    corners = []
    for prim in Usd.PrimRange(root, Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdGeom.PointInstancer):
            return None
        if prim.IsA(UsdGeom.Gprim):
            own = bounds_of(prim, time)
            if own is None:
                return None
            relative, resets = cache.ComputeRelativeTransform(prim, root)
            if resets:
                return None
            matrix = np.array(relative, np.float64).reshape(4, 4)
            points = np.array([[own[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
            corners.append(points @ matrix[:3, :3] + matrix[3, :3])
    return np.stack([np.min(corners, axis=(0, 1)), np.max(corners, axis=(0, 1))]) if corners else None


def bounds_of(prim: Usd.Prim, time: Usd.TimeCode) -> np.ndarray | None:
    """Return the bounds (2, 3) of a gprim in its own frame; None for others, and for what a skeleton may deform."""
    if prim.IsA(UsdGeom.Mesh):
        return _bounds_of_faces(UsdGeom.Mesh(prim), time)
    if not prim.IsA(UsdGeom.Gprim) or prim.IsA(UsdGeom.PointBased):
        return None
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), time)
    return np.array(extent, np.float64) if extent is not None and len(extent) == 2 else None


def bounds_of_part(prim: Usd.Prim, time: Usd.TimeCode) -> np.ndarray | None:
    """Return `bounds_of` of a subset of faces, or of a gprim without those of its subsets that have labels."""
    is_subset = prim.IsA(UsdGeom.Subset)
    mesh = prim.GetParent() if is_subset else prim
    subsets, of_face = read_face_parts(mesh, time)
    if not subsets:
        return bounds_of(prim, time)
    is_part = [
        (path == prim.GetPath()) if is_subset else not is_labeled(prim.GetStage().GetPrimAtPath(path))
        for path in subsets
    ]
    return _bounds_of_faces(UsdGeom.Mesh(mesh), time, np.array([*is_part, not is_subset])[of_face])


def _bounds_of_faces(mesh: UsdGeom.Mesh, time: Usd.TimeCode, faces: np.ndarray | None = None) -> np.ndarray | None:
    """Return the bounds (2, 3) of faces, (F,) bool or all, without holes; None for no faces, or what deforms them."""
    if UsdSkel.BindingAPI(mesh).GetInheritedSkeleton() or mesh.GetSubdivisionSchemeAttr().Get() != "none":
        return None
    points = moved_points(mesh.GetPrim(), time) or mesh.GetPointsAttr().Get(time)
    points = np.array(points or (), np.float64).reshape(-1, 3)
    used = np.array(mesh.GetFaceVertexIndicesAttr().Get(time) or (), np.int64)
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get(time) or (), np.int64)
    drawn = ~np.isin(np.arange(len(counts)), mesh.GetHoleIndicesAttr().Get(time) or ())
    drawn = drawn if faces is None else drawn & faces
    if not drawn.all():
        used = used[np.repeat(drawn, counts)[: len(used)]]
    used = points[used[(used >= 0) & (used < len(points))]]
    return np.stack([used.min(axis=0), used.max(axis=0)]) if len(used) else None
