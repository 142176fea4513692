"""Expand a UsdGeomPointInstancer to the gprims that it draws, with their matrices."""

from collections.abc import Iterator, Sequence, Set
from typing import Any, NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from usdsdg import errors
from usdsdg.stage.geometry.drawn_box import DRAWN_PURPOSES
from usdsdg.stage.geometry.point_ids import point_numbers
from usdsdg.stage.geometry.point_names import PrototypeUse, names_of_points, prototypes_of
from usdsdg_render.usd import prim_kinds
from usdsdg_render.usd.prim_kinds import is_invisible, is_material_subset, kind_of, purpose_of, warn_unsupported
from usdsdg_render.usd.transforms import local_matrix, matrix_product

# Arrays that have one value for each point, or none.
PER_POINT = ("positions", "scales", "orientations", "orientationsf")
# USD reads arrays of these types only, and takes others for none.
ARRAY_TYPES: dict[str, tuple[type, str]] = {
    "protoIndices": (Vt.IntArray, "int[]"),
    "positions": (Vt.Vec3fArray, "point3f[]"),
    "scales": (Vt.Vec3fArray, "float3[]"),
    "orientations": (Vt.QuathArray, "quath[]"),
    "orientationsf": (Vt.QuatfArray, "quatf[]"),
    "velocities": (Vt.Vec3fArray, "vector3f[]"),
    "accelerations": (Vt.Vec3fArray, "vector3f[]"),
    "angularVelocities": (Vt.Vec3fArray, "vector3f[]"),
    "invisibleIds": (Vt.Int64Array, "int64[]"),
}

# Prims of prototypes may be classes or overs, so that they are drawn through point instancers only.
_ACTIVE = Usd.TraverseInstanceProxies(Usd.PrimIsActive)


class Part(NamedTuple):
    """One gprim that a prototype draws; of an instancer in the prototype, one for each of its points."""

    path: str  # path of the gprim, then the points of inner instancers, see `point_names`
    lasting_path: str  # the same with every instancer named, whether or not others draw its prototypes
    prim: Usd.Prim
    subsets: list[Usd.Prim]
    matrix: np.ndarray  # (4, 4) float64 gprim to the parent of the prototype's root


class PointInstances(NamedTuple):
    """The gprims that a point instancer draws, in the order of its points."""

    parts: list[Part]  # those of all prototypes that have points
    part_of: np.ndarray  # (N,) int64 into `parts`
    paths: list[str]  # path of the part, then the point
    lasting_paths: list[str]
    to_instancer: np.ndarray  # (N, 4, 4) float64 gprim to instancer


def source_path(path: str) -> str:
    """Return the prim path of an entry of `Instances.paths`: a point instance's path without its points."""
    return path.split("[", 1)[0]


def expand(
    instancer: Usd.Prim,
    time: Usd.TimeCode,
    roots: set[Sdf.Path],
    shared: Set[PrototypeUse],
    outer: tuple[Sdf.Path, ...] = (),
) -> PointInstances:
    """Return all gprims that a point instancer draws, nested instancers included.

    Args:
        roots: receives the paths of the prototype roots, existing or not: the result depends on the prims at and below.
        shared: prototypes that several instancers draw.
        outer: the instancers that have this one among their prototypes.
    """
    schema = UsdGeom.PointInstancer(instancer)
    indices = np.array(_array(instancer, "protoIndices", time) or (), np.int32)
    if not _has_equal_lengths(schema, time, len(indices)):
        return PointInstances([], np.zeros(0, np.int64), [], [], np.zeros((0, 4, 4)))
    _warn_of_point_colors(instancer)
    prototypes = _prototypes(schema, time, roots, shared, (*outer, instancer.GetPath()))
    are_shared = [(instancer.GetPath(), root) in shared for root in prototypes_of(instancer)]
    matrices, mask = _matrices(schema, time)
    numbers = point_numbers(schema, len(indices), time)
    if (bad := (indices < 0) | (indices >= len(prototypes))).any():
        entries = errors.counted(int(bad.sum()), "entry of protoIndices is", "entries of protoIndices are")
        errors.warn_once(
            f"{instancer.GetPath()}: {entries} outside its {errors.counted(len(prototypes), 'prototype')}; nothing is "
            f"drawn there. Correct protoIndices."
        )
    drawn = np.flatnonzero(np.asarray(mask, bool) & ~bad)
    kinds, first = np.unique(indices[drawn], return_index=True)
    kinds = kinds[np.argsort(first)].tolist()  # as they are drawn first
    counts = np.zeros(len(prototypes), np.int64)
    counts[kinds] = [len(prototypes[kind]) for kind in kinds]
    ends = np.cumsum(counts[indices[drawn]])
    begins = ends - counts[indices[drawn]]  # of each point
    total = int(ends[-1]) if len(ends) else 0
    found = PointInstances([], np.zeros(total, np.int64), [""] * total, [""] * total, np.empty((total, 4, 4)))
    for kind in kinds:
        rows = np.flatnonzero(indices[drawn] == kind)
        points = drawn[rows].tolist()
        lasting = names_of_points(instancer.GetPath(), [numbers[point] for point in points], is_shared=True)
        names = names_of_points(instancer.GetPath(), [numbers[point] for point in points], is_shared=False)
        names = lasting if are_shared[kind] else names
        for place, part in enumerate(prototypes[kind]):
            places = begins[rows] + place
            found.part_of[places] = len(found.parts)
            found.parts.append(part)
            found.to_instancer[places] = matrix_product(part.matrix, matrices[points])
            for at, name, lasting_name in zip(places.tolist(), names, lasting):
                found.paths[at], found.lasting_paths[at] = part.path + name, part.lasting_path + lasting_name
    return found


def _has_equal_lengths(schema: UsdGeom.PointInstancer, time: Usd.TimeCode, count: int) -> bool:
    """Whether every array has one value for each point: USD makes up transforms where arrays are too short."""
    arrays = {name: _array(schema.GetPrim(), name, time) for name in ARRAY_TYPES}
    lengths = {name: len(values) for name in PER_POINT if (values := arrays[name]) is not None and len(values)}
    wrong = [f"{name} has {length}" for name, length in lengths.items() if length != count]
    if "positions" not in lengths and count:
        wrong.insert(0, "positions has 0")
    if wrong:
        errors.warn_once(
            f"{schema.GetPath()}: protoIndices has {errors.counted(count, 'entry', 'entries')}, but "
            f"{', '.join(wrong)}; the point instancer is not drawn. Give its per-instance arrays equal lengths."
        )
    return not wrong


def _array(instancer: Usd.Prim, name: str, time: Usd.TimeCode) -> Sequence[Any] | None:
    """Return the value of an array; None where there is none, or (with a warning) one of a type that USD ignores."""
    attribute = instancer.GetAttribute(name)
    value, (kind, declared) = attribute.Get(time) if attribute else None, ARRAY_TYPES[name]
    if value is None or isinstance(value, kind):
        return value
    errors.warn_once(
        f"{instancer.GetPath()}: {name} has values of the type {type(value).__name__}, which USD does not read there, "
        f"so they are ignored. Author them as {declared}."
    )
    return None


def _warn_of_point_colors(instancer: Usd.Prim) -> None:
    for name in ("primvars:displayColor", "primvars:displayOpacity"):
        attribute = instancer.GetAttribute(name)
        if attribute and attribute.GetMetadata("interpolation") in ("vertex", "varying", "uniform"):
            errors.warn_once(
                f"{instancer.GetPath()}: {name} of each point is not supported; points have the colors of "
                f"their prototypes. Give points of another color a prototype of their own."
            )


def _prototypes(
    schema: UsdGeom.PointInstancer,
    time: Usd.TimeCode,
    roots: set[Sdf.Path],
    shared: Set[PrototypeUse],
    outer: tuple[Sdf.Path, ...],
) -> list[list[Part]]:
    """The gprims of each target of `prototypes`, with matrices to the parent of the target."""
    gprims = []
    for path in prototypes_of(schema.GetPrim()):
        roots.add(path)
        root = schema.GetPrim().GetStage().GetPrimAtPath(path)
        if not root:
            errors.warn_once(
                f"{schema.GetPath()}: its prototype {path} does not exist, so nothing is drawn for it. Correct "
                f"prototypes."
            )
        gprims.append(list(_gprims_below(root, time, roots, shared, outer)) if root else [])
    return gprims


def _matrices(schema: UsdGeom.PointInstancer, time: Usd.TimeCode) -> tuple[np.ndarray, list[bool]]:
    """(N, 4, 4) float64 point to instancer, without the prototype's own matrix, and which points are visible."""
    matrices = schema.ComputeInstanceTransformsAtTime(
        time, time, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
    )
    matrices = np.array(matrices, np.float64).reshape(-1, 4, 4)
    mask = list(schema.ComputeMaskAtTime(time))
    return matrices, mask or [True] * len(matrices)


def _gprims_below(
    root: Usd.Prim,
    time: Usd.TimeCode,
    roots: set[Sdf.Path],
    shared: Set[PrototypeUse],
    instancers: tuple[Sdf.Path, ...],
) -> Iterator[Part]:
    """The drawn gprims of a prototype, with matrices to the parent of its root."""
    cache = UsdGeom.XformCache(time)
    ancestors: list[tuple[int, np.ndarray, str]] = []  # (depth, matrix, purpose)
    iterator = iter(Usd.PrimRange(root, _ACTIVE))
    for prim in iterator:
        kind = kind_of(prim)
        if kind in (prim_kinds.SHADING, prim_kinds.SUBSET) or is_invisible(prim, time):
            iterator.PruneChildren()
            continue
        depth = prim.GetPath().pathElementCount
        while ancestors and ancestors[-1][0] >= depth:
            ancestors.pop()
        _, parent, purpose = ancestors[-1] if ancestors else (0, np.eye(4), "")
        local, resets = local_matrix(cache, prim, False)
        matrix = np.array(local) if resets else matrix_product(np.array(local), parent)
        purpose = purpose_of(prim, purpose)
        ancestors.append((depth, matrix, purpose))
        if kind == prim_kinds.INSTANCER:  # its prototypes are drawn through it only, whatever their purpose
            iterator.PruneChildren()
        if purpose and purpose not in DRAWN_PURPOSES:
            continue
        if kind == prim_kinds.INSTANCER:
            if prim.GetPath() in instancers:
                errors.warn_once(
                    f"{instancers[-1]}: {prim.GetPath()} is among its prototypes and draws it in turn, so it is not "
                    f"drawn there. Take it out of prototypes."
                )
                continue
            inner = expand(prim, time, roots, shared, instancers)
            matrices = matrix_product(inner.to_instancer, matrix)
            for place, path, lasting, to_parent in zip(
                inner.part_of.tolist(), inner.paths, inner.lasting_paths, matrices
            ):
                part = inner.parts[place]
                yield Part(path, lasting, part.prim, part.subsets, to_parent)
        elif kind in prim_kinds.GPRIMS:
            children = prim.GetFilteredChildren(_ACTIVE) if kind == prim_kinds.MESH else []
            subsets = [child for child in children if kind_of(child) == prim_kinds.SUBSET and is_material_subset(child)]
            path = str(prim.GetPath())
            yield Part(path, path, prim, subsets, matrix)
        elif kind in (prim_kinds.LIGHT, prim_kinds.DOME):
            errors.warn_once(
                f"{prim.GetPath()}: lights in the prototypes of a point instancer are not supported; it shines no "
                f"light. Place lights without an instancer."
            )
        elif kind in (prim_kinds.UNSUPPORTED_GPRIM, prim_kinds.UNSUPPORTED_LIGHT):
            warn_unsupported(prim)
