"""The box of what a point instancer draws, whatever extents are authored on it and in its prototypes."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.stage.geometry.point_names import prototypes_of
from usdsdg.stage.poses.transforms import as_array

# Prims of prototypes may be classes or overs, so that they are drawn through point instancers only.
_ACTIVE = Usd.TraverseInstanceProxies(Usd.PrimIsActive)

OwnBox = Callable[[Usd.Prim], np.ndarray | None]  # lowest and highest corner (2, 3) in a prim's own frame


def instancer_box(instancer: Usd.Prim, time: Usd.TimeCode, purposes: Sequence[str], own: OwnBox) -> np.ndarray | None:
    """Return the lowest and highest corner (2, 3) in the frame of a point instancer; None where it draws nothing.

    It has all its prototypes, and none of them draws it in turn. own: gives the boxes of what is in the prototypes.
    """
    schema, stage = UsdGeom.PointInstancer(instancer), instancer.GetStage()
    kinds = np.array(schema.GetProtoIndicesAttr().Get(time) or (), np.int64)
    if len(schema.GetPositionsAttr().Get(time) or ()) != len(kinds):
        return None
    to_instancer = schema.ComputeInstanceTransformsAtTime(
        time, time, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
    )
    to_instancer = np.array(to_instancer, np.float64).reshape(-1, 4, 4)
    if len(to_instancer) != len(kinds):
        return None
    mask = np.array(list(schema.ComputeMaskAtTime(time)) or [True] * len(kinds), bool)
    mask &= np.isfinite(to_instancer).all(axis=(1, 2))  # others are not drawn
    boxes = []
    for kind, path in enumerate(prototypes_of(instancer)):
        places = to_instancer[mask & (kinds == kind)]
        if len(places):
            for box, to_points in _boxes_below(stage.GetPrimAtPath(path), time, purposes, own):
                boxes.append(_box_of_all(box, to_points @ places))
    if not boxes:
        return None
    box = np.stack([np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]])
    return box if np.isfinite(box).all() else None


def _boxes_below(
    root: Usd.Prim, time: Usd.TimeCode, purposes: Sequence[str], own: OwnBox
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield the boxes of what a prototype draws, with their matrices (4, 4) to the points."""
    cache = UsdGeom.XformCache(time)
    above: list[tuple[int, np.ndarray, str]] = []  # depth, matrix and purpose
    prims = iter(Usd.PrimRange(root, _ACTIVE))
    for prim in prims:
        imageable = UsdGeom.Imageable(prim)
        if not imageable and prim.GetTypeName():  # as materials, which have nothing drawn below them
            prims.PruneChildren()
            continue
        if imageable and imageable.GetVisibilityAttr().Get(time) == UsdGeom.Tokens.invisible:
            prims.PruneChildren()
            continue
        depth = prim.GetPath().pathElementCount
        while above and above[-1][0] >= depth:
            above.pop()
        _, matrix, purpose = above[-1] if above else (0, np.eye(4), "")
        local, resets = cache.GetLocalTransformation(prim)
        matrix = as_array(local) if resets else as_array(local) @ matrix
        authored = prim.GetAttribute("purpose")
        purpose = str(authored.Get()) if authored and authored.HasAuthoredValue() else purpose
        above.append((depth, matrix, purpose))
        is_instancer = prim.IsA(UsdGeom.PointInstancer)
        if is_instancer:
            prims.PruneChildren()
        if (is_instancer or prim.IsA(UsdGeom.Gprim)) and (purpose or UsdGeom.Tokens.default_) in purposes:
            box = own(prim)
            if box is not None:
                yield box, matrix


def _box_of_all(box: np.ndarray, matrices: np.ndarray) -> np.ndarray:
    """Return the box (2, 3) of boxes that are one of (2, 3), moved by matrices (N, 4, 4)."""
    center, half = (box[0] + box[1]) / 2, (box[1] - box[0]) / 2
    centers = center @ matrices[:, :3, :3] + matrices[:, 3, :3]
    halves = half @ np.abs(matrices[:, :3, :3])
    return np.stack([(centers - halves).min(axis=0), (centers + halves).max(axis=0)])
