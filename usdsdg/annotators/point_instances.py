"""Transforms and instancers of point-instanced gprims.

The renderer lists a gprim of a point instance as `path[id]`, where path is that of the gprim in the prototype; nested
instancers append theirs: `path[inner][outer]`. When several instancers share a prototype, equal entries follow the
order of the instancers on the stage.
"""

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from usdsdg.errors import warn_once
from usdsdg.stage.geometry.point_ids import point_numbers
from usdsdg.stage.poses.transforms import as_array


class Step(NamedTuple):
    """One point of one instancer."""

    instancer: Sdf.Path
    prototype: Sdf.Path  # root of the prototype that the point instances
    point: int  # id of the point


# From the innermost instancer to the outermost; empty for gprims that are not point-instanced.
Steps = tuple[Step, ...]


def prim_path(gprim: str) -> Sdf.Path:
    """Return the prim path of an entry of the renderer's gprim table."""
    return Sdf.Path(gprim.split("[", 1)[0])


def find_steps(stage: Usd.Stage, gprims: Sequence[str]) -> list[Steps]:
    """Return the instancers and points of each gprim of the renderer's table."""
    if not any(gprim.endswith("]") for gprim in gprims):
        return [()] * len(gprims)
    instancers = _instancers(stage)
    seen: Counter[str] = Counter()
    found = []
    for gprim in gprims:
        path, *points = gprim.replace("]", "").split("[")
        found.append(_steps(Sdf.Path(path), [int(point) for point in points], instancers, seen[gprim]))
        seen[gprim] += 1
    return found


def first_points(stage: Usd.Stage, gprims: Sequence[str]) -> list[str]:
    """Return the gprims with those in prototypes as instances of point 0, through nested instancers."""
    instancers = _instancers(stage)
    if not instancers:
        return list(gprims)
    return [gprim + "[0]" * _depth(Sdf.Path(gprim), instancers, set()) for gprim in gprims]


def undefined_prototypes(stage: Usd.Stage) -> list[Usd.Prim]:
    """Return the roots of prototypes that a traversal of the stage leaves out, since they are classes or overs."""
    roots = dict.fromkeys(prototype for _, prototype in _instancers(stage))
    prims = [prim for prim in map(stage.GetPrimAtPath, Sdf.Path.RemoveDescendentPaths(list(roots))) if prim]
    return [prim for prim in prims if prim.IsAbstract() or not prim.IsDefined()]


def every_point(stage: Usd.Stage, gprims: Sequence[str]) -> list[str]:
    """Return the gprims with those in prototypes once for each point that draws them, at the default time.

    Through nested instancers they are instances of the first point of the outer ones.
    """
    instancers = _instancers(stage)
    if not instancers:
        return list(gprims)
    return [
        gprim + "".join(f"[{point}]" for point in points)
        for gprim in gprims
        for points in _points_through(stage, Sdf.Path(gprim), instancers, ())
    ]


def _points_through(
    stage: Usd.Stage, path: Sdf.Path, instancers: list[tuple[Sdf.Path, Sdf.Path]], inner: tuple[Sdf.Path, ...]
) -> Iterator[tuple[int, ...]]:
    """Yield the points that draw a prim, innermost first: all of the innermost instancer, one of each outer one.

    inner: the instancers that were gone through, which draw nothing in turn.
    """
    drawn_by = [(i, p) for i, p in instancers if path.HasPrefix(p) and i not in inner]
    if not drawn_by:
        yield ()
        return
    nearest = max(p.pathElementCount for _, p in drawn_by)
    for instancer, prototype in ((i, p) for i, p in drawn_by if p.pathElementCount == nearest):
        outer = next(_points_through(stage, instancer, instancers, (*inner, instancer)), None)
        if outer is not None:
            yield from ((point, *outer) for point in _points_of(stage, instancer, prototype))


def _points_of(stage: Usd.Stage, path: Sdf.Path, prototype: Sdf.Path) -> list[int]:
    """Return the ids of the points of an instancer that draw a prototype."""
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath(path))
    place = list(instancer.GetPrototypesRel().GetForwardedTargets()).index(prototype)
    drawn = instancer.GetProtoIndicesAttr().Get() or ()
    numbers = point_numbers(instancer, len(drawn), Usd.TimeCode.Default())
    return [point for point, index in zip(numbers, drawn) if index == place]


def _depth(path: Sdf.Path, instancers: list[tuple[Sdf.Path, Sdf.Path]], seen: set[Sdf.Path]) -> int:
    """Return how many instancers a gprim is drawn through; those that draw each other count once."""
    drawn_by = [(i, p) for i, p in instancers if path.HasPrefix(p) and i not in seen]
    if not drawn_by:
        return 0
    instancer, _ = max(drawn_by, key=lambda each: each[1].pathElementCount)
    return 1 + _depth(instancer, instancers, {*seen, instancer})


def _instancers(stage: Usd.Stage) -> list[tuple[Sdf.Path, Sdf.Path]]:
    """Return (instancer, prototype root) of all point instancers, in stage order."""
    everything = Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate))
    return [
        (prim.GetPath(), prototype)
        for prim in everything
        if prim.IsA(UsdGeom.PointInstancer)
        for prototype in UsdGeom.PointInstancer(prim).GetPrototypesRel().GetForwardedTargets()
    ]


def _steps(path: Sdf.Path, points: list[int], instancers: list[tuple[Sdf.Path, Sdf.Path]], turn: int) -> Steps:
    steps: list[Step] = []
    for point in points:
        drawn_by = [(i, p) for i, p in instancers if path.HasPrefix(p)]
        if not drawn_by:
            warn_once(f"{path}: no point instancer draws it, so its point instances have no label.")
            return ()
        # The nearest prototype root; instancers that share it are assigned in turn.
        nearest = max(p.pathElementCount for _, p in drawn_by)
        sharing = [(i, p) for i, p in drawn_by if p.pathElementCount == nearest]
        instancer, prototype = sharing[turn % len(sharing)]
        steps.append(Step(instancer, prototype, point))
        path = instancer
    return tuple(steps)


class PointFrames:
    """World transforms of point instances at one time."""

    def __init__(self, stage: Usd.Stage, cache: UsdGeom.XformCache) -> None:
        self._stage, self._cache = stage, cache
        self._points: dict[Sdf.Path, dict[int, np.ndarray]] = {}

    def to_world(self, path: Sdf.Path, steps: Steps) -> np.ndarray:
        """Return the (4, 4) local-to-world matrix of the prim at `path`, instanced through `steps`."""
        if not steps:
            return as_array(self._cache.GetLocalToWorldTransform(self._stage.GetPrimAtPath(path)))
        step = steps[0]
        point = self._points_of(step.instancer)[step.point]
        return self._to_parent(path, step.prototype) @ point @ self.to_world(step.instancer, steps[1:])

    def all_to_world(self, places: Sequence[tuple[Sdf.Path, Steps]]) -> np.ndarray:
        """Return `to_world` of many prims, (N, 4, 4)."""
        matrices = np.empty((len(places), 4, 4))
        alone = [row for row, (_, steps) in enumerate(places) if not steps]
        prims = [self._stage.GetPrimAtPath(places[row][0]) for row in alone]
        # One array of USD's for all: NumPy takes matrices one by one slowly.
        matrices[alone] = np.array(Vt.Matrix4dArray(list(map(self._cache.GetLocalToWorldTransform, prims))))
        # Points of one instancer that draw one prim differ in their own matrices alone.
        rows: defaultdict[tuple[Sdf.Path, Sdf.Path, Sdf.Path, Steps], list[int]] = defaultdict(list)
        for row, (path, steps) in enumerate(places):
            if steps:
                rows[path, steps[0].prototype, steps[0].instancer, steps[1:]].append(row)
        for (path, prototype, instancer, outer), some in rows.items():
            known = self._points_of(instancer)
            points = np.array([known[places[row][1][0].point] for row in some])
            matrices[some] = self._to_parent(path, prototype) @ points @ self.to_world(instancer, outer)
        return matrices

    def _to_parent(self, path: Sdf.Path, prototype: Sdf.Path) -> np.ndarray:
        """Return the matrix (4, 4) from a prim to the frame above a prototype's root, which points move."""
        above = self._stage.GetPrimAtPath(prototype.GetParentPath())
        return as_array(self._cache.ComputeRelativeTransform(self._stage.GetPrimAtPath(path), above)[0])

    def _points_of(self, instancer: Sdf.Path) -> dict[int, np.ndarray]:
        if instancer not in self._points:
            self._points[instancer] = self._read(instancer)
        return self._points[instancer]

    def _read(self, path: Sdf.Path) -> dict[int, np.ndarray]:
        """Return point id → (4, 4) matrix to the instancer's frame."""
        instancer, time = UsdGeom.PointInstancer(self._stage.GetPrimAtPath(path)), self._cache.GetTime()
        matrices = instancer.ComputeInstanceTransformsAtTime(
            time, time, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
        )
        numbers = point_numbers(instancer, len(matrices), time)
        return dict(zip(numbers, np.array(matrices, np.float64).reshape(-1, 4, 4)))
