"""Transforms and instancers of point-instanced gprims.

The renderer lists a gprim of a point instance by a name of `point_names`.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from usdsdg.errors import warn_once
from usdsdg.stage.geometry.point_ids import point_numbers
from usdsdg.stage.geometry.point_names import Prototypes, PrototypeUse, point_name, split_name
from usdsdg.stage.poses.transforms import as_array

# Attributes of a point instancer that decide which points it draws, and their names.
_POINTS = ("positions", "protoIndices", "ids")


class Step(NamedTuple):
    """One point of one instancer."""

    instancer: Sdf.Path
    prototype: Sdf.Path  # root of the prototype that the point instances
    point: int  # id of the point
    is_shared: bool = False  # whether other instancers draw the prototype, too

    @property
    def name(self) -> str:
        """What follows the path of a prim in the prototype."""
        return point_name(self.instancer, self.point, is_shared=self.is_shared)

    @property
    def lasting_name(self) -> str:
        """As `name`, the same whether or not other instancers draw the prototype, which may come and go."""
        return point_name(self.instancer, self.point, is_shared=True)


# From the innermost instancer to the outermost; empty for gprims that are not point-instanced.
Steps = tuple[Step, ...]


@lru_cache(maxsize=1 << 16)  # USD takes microseconds to parse a path, and frames mostly have the same gprims
def prim_path(gprim: str) -> Sdf.Path:
    """Return the prim path of an entry of the renderer's gprim table."""
    return Sdf.Path(gprim.split("[", 1)[0])


def lasting_name(path: Sdf.Path, steps: Steps) -> str:
    """Return what stands for a prim or point instance in all frames, whatever else is drawn."""
    return str(path) + "".join(step.lasting_name for step in steps)


def find_steps(stage: Usd.Stage, gprims: Sequence[str]) -> list[Steps]:
    """Return the instancers and points of each gprim of the renderer's table."""
    if not any(gprim.endswith("]") for gprim in gprims):
        return [()] * len(gprims)
    prototypes = Prototypes(stage)
    return [_steps(*split_name(gprim), prototypes) for gprim in gprims]


def first_points(stage: Usd.Stage, gprims: Sequence[str], prototypes: Prototypes) -> list[str]:
    """Return the gprims with those in prototypes as instances of point 0, once for each way that they are drawn.

    Prototypes, and instancers in these, that stand in the scene are drawn by themselves, too.
    """
    if not prototypes.of:
        return list(gprims)
    found: dict[str, None] = {}
    for gprim in gprims:
        for way in _ways_to(Sdf.Path(gprim), prototypes, ()):
            points = [_point_name(prototypes, each, 0) for each in way]
            outermost = [Sdf.Path(gprim), *(instancer for instancer, _ in way)]
            for count, path in enumerate(outermost):
                if count == len(way) or _stands_alone(stage, path, prototypes):
                    found.setdefault(gprim + "".join(points[:count]))
    return list(found)


def _stands_alone(stage: Usd.Stage, path: Sdf.Path, prototypes: Prototypes) -> bool:
    """Return whether a prim is drawn where it is, if it is shown: what is below an instancer is not."""
    prim = stage.GetPrimAtPath(path)
    is_below = any(each in prototypes.of for each in path.GetParentPath().GetPrefixes())
    return prim.IsDefined() and not prim.IsAbstract() and not is_below


def undefined_prototypes(stage: Usd.Stage, prototypes: Prototypes | None = None) -> list[Usd.Prim]:
    """Return the roots of prototypes that a traversal of the stage leaves out, since they are classes or overs."""
    roots = list((prototypes or Prototypes(stage)).users)
    prims = [prim for prim in map(stage.GetPrimAtPath, Sdf.Path.RemoveDescendentPaths(roots)) if prim]
    return [prim for prim in prims if prim.IsAbstract() or not prim.IsDefined()]


def every_point(stage: Usd.Stage, gprims: Sequence[str], time: Usd.TimeCode) -> list[str]:
    """Return the gprims with those in prototypes once for each point that draws them.

    Through nested instancers they are instances of the first point of the outer ones.
    """
    prototypes = Prototypes(stage)
    if not prototypes.of:
        return list(gprims)
    found = []
    for gprim in gprims:
        seen: set[PrototypeUse] = set()  # innermost prototypes
        for way in _ways_to(Sdf.Path(gprim), prototypes, ()):
            points = [_points_of(stage, *each, time) for each in way]
            if not all(points) or not seen.isdisjoint(way[:1]):
                continue
            seen.update(way[:1])
            outer = "".join(_point_name(prototypes, each, own[0]) for each, own in zip(way[1:], points[1:]))
            inner = [_point_name(prototypes, way[0], point) for point in points[0]] if way else [""]
            found += [gprim + each + outer for each in inner]
    return found


def points_vary(stage: Usd.Stage) -> bool:
    """Return whether point instancers may draw other points at other times, or under other names."""
    attributes = (stage.GetPrimAtPath(path).GetAttribute(name) for path in Prototypes(stage).of for name in _POINTS)
    return any(each.GetNumTimeSamples() for each in attributes)


def _ways_to(path: Sdf.Path, prototypes: Prototypes, inner: tuple[Sdf.Path, ...]) -> Iterator[tuple[PrototypeUse, ...]]:
    """Yield the prototypes through which a prim is drawn, innermost first.

    inner: the instancers that were gone through, which draw nothing in turn.
    """
    drawing = [pair for pair in prototypes.drawing(path) if pair[0] not in inner]
    if not drawing:
        yield ()
    for pair in drawing:
        instancer, _ = pair
        yield from ((pair, *outer) for outer in _ways_to(instancer, prototypes, (*inner, instancer)))


def _point_name(prototypes: Prototypes, prototype: PrototypeUse, point: int) -> str:
    return point_name(prototype[0], point, is_shared=prototype in prototypes.shared)


def _points_of(stage: Usd.Stage, path: Sdf.Path, prototype: Sdf.Path, time: Usd.TimeCode) -> list[int]:
    """Return the ids of the points of an instancer that draw a prototype; none where points lack positions."""
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath(path))
    place = list(instancer.GetPrototypesRel().GetForwardedTargets()).index(prototype)
    drawn = instancer.GetProtoIndicesAttr().Get(time) or ()
    if len(instancer.GetPositionsAttr().Get(time) or ()) != len(drawn):
        return []  # it is not drawn
    numbers = point_numbers(instancer, len(drawn), time)
    return [point for point, index in zip(numbers, drawn) if index == place]


def _steps(path: Sdf.Path, points: Sequence[tuple[Sdf.Path | None, int]], prototypes: Prototypes) -> Steps:
    steps: list[Step] = []
    for named, point in points:
        drawing = [pair for pair in prototypes.drawing(path) if named in (None, pair[0])]
        if not drawing:
            warn_once(f"{path}: no point instancer draws it, so its point instances have no label.")
            return ()
        path, prototype = drawing[0]
        steps.append(Step(path, prototype, point, named is not None))
    return tuple(steps)


# Gives the rows of some prims whose matrices (N, 4, 4) to the world it knows, and these.
Places = Callable[[Sequence[Sdf.Path]], tuple[np.ndarray, np.ndarray]]


class PointFrames:
    """World transforms of point instances, and of other prims, at one time.

    places: knows the matrices of prims at that time without asking USD.
    """

    def __init__(self, stage: Usd.Stage, cache: UsdGeom.XformCache, places: Places | None = None) -> None:
        self._stage, self._cache, self._places = stage, cache, places
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
        matrices[alone] = self._of_prims([places[row][0] for row in alone])
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

    def _of_prims(self, paths: Sequence[Sdf.Path]) -> np.ndarray:
        """Return the matrices (N, 4, 4) from prims to the world."""
        matrices, missing = np.empty((len(paths), 4, 4)), np.ones(len(paths), bool)
        if self._places is not None:
            rows, known = self._places(paths)
            matrices[rows], missing[rows] = known, False
        rest = np.flatnonzero(missing).tolist()
        prims = [self._stage.GetPrimAtPath(paths[row]) for row in rest]
        # One array of USD's for all: NumPy takes matrices one by one slowly.
        matrices[rest] = np.array(Vt.Matrix4dArray(list(map(self._cache.GetLocalToWorldTransform, prims))))
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
