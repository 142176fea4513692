"""UsdGeomPointInstancer: which gprims it draws, and where."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg import errors

from .stage_tree import (
    DRAWN_PURPOSES,
    GPRIMS,
    INSTANCER,
    MESH,
    SKIP,
    SUBSET,
    is_invisible,
    is_material_subset,
    kind_of,
    local_matrix,
    matrix_product,
    purpose_of,
)


class PointInstance(NamedTuple):
    """One gprim of one point instance."""

    path: str  # path of the gprim in the prototype, then [id of the point instance]
    prim: Usd.Prim
    subsets: list[Usd.Prim]
    to_instancer: np.ndarray  # (4, 4) from the gprim to the instancer


def source_path(path: str) -> str:
    """Prim path of an entry of `Instances.paths`: a point instance's path without its [id]."""
    return path.split("[", 1)[0]


def expand(instancer: Usd.Prim, time: Usd.TimeCode) -> list[PointInstance]:
    """All gprims that a point instancer draws, in the order of its points; nested instancers included."""
    schema = UsdGeom.PointInstancer(instancer)
    targets = schema.GetPrototypesRel().GetForwardedTargets()
    roots = [instancer.GetStage().GetPrimAtPath(path) for path in targets]
    indices = schema.GetProtoIndicesAttr().Get(time)
    indices = np.asarray(indices) if indices is not None and len(indices) else np.zeros(0, np.int32)
    matrices, mask = _matrices(instancer, schema, time)
    if len(matrices) != len(indices):
        errors.warn_once(
            f"{instancer.GetPath()}: {len(indices)} protoIndices but {len(matrices)} positions; the point "
            f"instancer is not drawn. Give its per-instance arrays equal lengths."
        )
        return []
    ids = schema.GetIdsAttr().Get(time)
    numbers = list(ids) if ids is not None and len(ids) == len(indices) else range(len(indices))
    parts = [list(_gprims_below(root, time)) if root else [] for root in roots]
    if (bad := (indices < 0) | (indices >= len(parts))).any():
        errors.warn_once(
            f"{instancer.GetPath()}: {int(bad.sum())} protoIndices lie outside its {len(parts)} prototypes; "
            f"those points are not drawn. Correct protoIndices."
        )
    return [
        part._replace(path=f"{part.path}[{number}]", to_instancer=matrix_product(part.to_instancer, matrix))
        for number, prototype, matrix, wrong, shown in zip(numbers, indices, matrices, bad, mask)
        if shown and not wrong
        for part in parts[prototype]
    ]


def _matrices(instancer: Usd.Prim, schema: UsdGeom.PointInstancer, time: Usd.TimeCode) -> tuple[np.ndarray, list[bool]]:
    """(N, 4, 4) point to instancer, without the prototype's own matrix, and which points are shown."""
    matrices = schema.ComputeInstanceTransformsAtTime(
        time, time, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
    )
    matrices = np.array([np.array(matrix) for matrix in matrices]).reshape(-1, 4, 4)
    mask = list(schema.ComputeMaskAtTime(time))
    return matrices, mask or [True] * len(matrices)


def _gprims_below(root: Usd.Prim, time: Usd.TimeCode) -> Iterator[PointInstance]:
    """Drawable gprims of a prototype, with matrices to the frame that its root stands in."""
    cache = UsdGeom.XformCache(time)
    above: list[tuple[int, np.ndarray, str]] = []
    iterator = iter(Usd.PrimRange(root, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)))
    for prim in iterator:
        kind = kind_of(prim)
        if kind in (SKIP, SUBSET) or not prim.IsActive() or is_invisible(prim, time):
            iterator.PruneChildren()
            continue
        depth = prim.GetPath().pathElementCount
        while above and above[-1][0] >= depth:
            above.pop()
        _, parent, purpose = above[-1] if above else (0, np.eye(4), "")
        matrix, resets = local_matrix(cache, prim, False)
        matrix = matrix if resets else matrix_product(matrix, parent)
        purpose = purpose_of(prim, purpose)
        above.append((depth, matrix, purpose))
        if purpose and purpose not in DRAWN_PURPOSES:
            continue
        if kind == INSTANCER:
            iterator.PruneChildren()
            for inner in expand(prim, time):
                yield inner._replace(to_instancer=matrix_product(inner.to_instancer, matrix))
        elif kind in GPRIMS:
            children = prim.GetFilteredChildren(Usd.TraverseInstanceProxies()) if kind == MESH else []
            subsets = [child for child in children if kind_of(child) == SUBSET and is_material_subset(child)]
            yield PointInstance(str(prim.GetPath()), prim, subsets, matrix)
