"""UsdGeomPointInstancer: which gprims it draws, and where."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg import errors
from usdsdg_render.usd.authored_values import as_array
from usdsdg_render.usd.prim_kinds import (
    DOME,
    DRAWN_PURPOSES,
    GPRIMS,
    INSTANCER,
    LIGHT,
    MESH,
    NO_LIGHT,
    SKIP,
    SUBSET,
    UNDRAWN,
    is_invisible,
    is_material_subset,
    kind_of,
    local_matrix,
    matrix_product,
    purpose_of,
    warn_unsupported,
)

# Arrays with one value for each point, where they have any.
PER_POINT = ("positions", "scales", "orientations", "orientationsf")
ROWS = {"protoIndices": (), "ids": (), "positions": (3,), "scales": (3,), "orientations": (4,), "orientationsf": (4,)}


class PointInstance(NamedTuple):
    """One gprim of one point instance."""

    path: str  # path of the gprim in the prototype, then [id of the point instance]
    prim: Usd.Prim
    subsets: list[Usd.Prim]
    to_instancer: np.ndarray  # (4, 4) from the gprim to the instancer


def source_path(path: str) -> str:
    """Prim path of an entry of `Instances.paths`: a point instance's path without its [id]."""
    return path.split("[", 1)[0]


def expand(
    instancer: Usd.Prim, time: Usd.TimeCode, sources: set[Sdf.Path], above: tuple[Sdf.Path, ...] = ()
) -> list[PointInstance]:
    """All gprims that a point instancer draws, in the order of its points; nested instancers included.

    sources: gets the paths of the prototypes, there or not: what is at and below them decides the result too.
    above: the instancers that it is a prototype of.
    """
    schema = UsdGeom.PointInstancer(instancer)
    indices = _per_point(instancer, "protoIndices", time)
    indices = np.zeros(0, np.int32) if indices is None else indices
    if not _fits(schema, time, len(indices)):
        return []
    _warn_of_colors(instancer)
    parts = _prototypes(schema, time, sources, (*above, instancer.GetPath()))
    matrices, mask = _matrices(schema, time)
    ids = _per_point(instancer, "ids", time)
    numbers = ids.tolist() if ids is not None and len(ids) == len(indices) else range(len(indices))
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


def _fits(schema: UsdGeom.PointInstancer, time: Usd.TimeCode, count: int) -> bool:
    """Whether there is one of everything for each point: USD makes up transforms where arrays are too short."""
    arrays = {name: _per_point(schema.GetPrim(), name, time) for name in PER_POINT}
    lengths = {name: len(values) for name, values in arrays.items() if values is not None and len(values)}
    wrong = [f"{length} {name}" for name, length in lengths.items() if length != count]
    if "positions" not in lengths and count:
        wrong.insert(0, "0 positions")
    if wrong:
        errors.warn_once(
            f"{schema.GetPath()}: {count} protoIndices but {', '.join(wrong)}; the point instancer is not drawn. Give "
            f"its per-instance arrays equal lengths."
        )
    return not wrong


def _per_point(instancer: Usd.Prim, name: str, time: Usd.TimeCode) -> np.ndarray | None:
    attribute = instancer.GetAttribute(name)
    return as_array(attribute, attribute.Get(time), ROWS[name])


def _warn_of_colors(instancer: Usd.Prim) -> None:
    for name in ("primvars:displayColor", "primvars:displayOpacity"):
        attribute = instancer.GetAttribute(name)
        if attribute and attribute.GetMetadata("interpolation") in ("vertex", "varying", "uniform"):
            errors.warn_once(
                f"{instancer.GetPath()}: {name} of each point is not supported; points look like their prototypes. "
                f"Give points of another color a prototype of their own."
            )


def _prototypes(
    schema: UsdGeom.PointInstancer, time: Usd.TimeCode, sources: set[Sdf.Path], above: tuple[Sdf.Path, ...]
) -> list[list[PointInstance]]:
    """What each target of `prototypes` draws, in the frame that it stands in."""
    parts = []
    for path in schema.GetPrototypesRel().GetForwardedTargets():
        sources.add(path)
        root = schema.GetPrim().GetStage().GetPrimAtPath(path)
        if not root:
            errors.warn_once(
                f"{schema.GetPath()}: its prototype {path} does not exist, so nothing is drawn for it. Correct "
                f"prototypes."
            )
        parts.append(list(_gprims_below(root, time, sources, above)) if root else [])
    return parts


def _matrices(schema: UsdGeom.PointInstancer, time: Usd.TimeCode) -> tuple[np.ndarray, list[bool]]:
    """(N, 4, 4) point to instancer, without the prototype's own matrix, and which points are shown."""
    matrices = schema.ComputeInstanceTransformsAtTime(
        time, time, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
    )
    matrices = np.array([np.array(matrix) for matrix in matrices]).reshape(-1, 4, 4)
    mask = list(schema.ComputeMaskAtTime(time))
    return matrices, mask or [True] * len(matrices)


def _gprims_below(
    root: Usd.Prim, time: Usd.TimeCode, sources: set[Sdf.Path], instancers: tuple[Sdf.Path, ...]
) -> Iterator[PointInstance]:
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
        local, resets = local_matrix(cache, prim, False)
        matrix = np.array(local) if resets else matrix_product(np.array(local), parent)
        purpose = purpose_of(prim, purpose)
        above.append((depth, matrix, purpose))
        if purpose and purpose not in DRAWN_PURPOSES:
            continue
        if kind == INSTANCER:
            iterator.PruneChildren()
            if prim.GetPath() in instancers:
                errors.warn_once(
                    f"{instancers[-1]}: {prim.GetPath()} is among its prototypes and draws it in turn, so it is not "
                    f"drawn there. Take it out of prototypes."
                )
                continue
            for inner in expand(prim, time, sources, instancers):
                yield inner._replace(to_instancer=matrix_product(inner.to_instancer, matrix))
        elif kind in GPRIMS:
            children = prim.GetFilteredChildren(Usd.TraverseInstanceProxies()) if kind == MESH else []
            subsets = [child for child in children if kind_of(child) == SUBSET and is_material_subset(child)]
            yield PointInstance(str(prim.GetPath()), prim, subsets, matrix)
        elif kind in (LIGHT, DOME):
            errors.warn_once(
                f"{prim.GetPath()}: lights in the prototypes of a point instancer are not supported; it shines no "
                f"light. Place lights without an instancer."
            )
        elif kind in (UNDRAWN, NO_LIGHT):
            warn_unsupported(prim)
