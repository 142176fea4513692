"""Numbers of all prims of one kind that a stage has, drawn or not; those in prototypes count once for each point."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.annotators.point_instances import Steps
from usdsdg.annotators.prims.label_tables import PrimTable
from usdsdg.stage.geometry.point_ids import point_numbers
from usdsdg.stage.geometry.point_names import point_name, prototypes_of

# Attributes of a point instancer that decide which points it has, and of which prototype.
POINT_ATTRIBUTES = frozenset({"protoIndices", "ids"})


@dataclass
class _Prototype:
    """What is counted in a prototype of a point instancer, and the instancers in it."""

    paths: list[str] = field(default_factory=list)
    instancers: _Instancers = field(default_factory=dict)


_Instancers = dict[Sdf.Path, dict[Sdf.Path, _Prototype]]  # prototypes by their roots, by instancer


class StageNumbers:
    """The numbers of prims, which do not depend on what is drawn, so that processes of other frames have the same."""

    def __init__(self, stage: Usd.Stage) -> None:
        self.table = PrimTable()
        self._stage = stage
        self._instancers: _Instancers = {}
        self._points: dict[Sdf.Path, tuple[Sequence[int], Sequence[int]]] | None = None  # numbered; None: not yet
        self._may_vary = False  # whether there may be others at another time

    def survey(self, prims: Iterable[tuple[str, Steps]]) -> None:
        """Number the prims at these paths, and keep those that are in prototypes, each with the instancers around it.

        Their points are numbered by `number_points`.
        """
        prims = list(prims)
        self.table.numbers(path for path, steps in prims if not steps)
        self._instancers, self._points = {}, None
        for path, steps in prims:
            if steps:
                self._add(path, steps)

    def number_points(self, time: Usd.TimeCode) -> None:
        """Number the points that there are at a time, unless this was done and nothing has changed since."""
        if self._points is None:
            self._points, self._may_vary = {}, False
            self.table.numbers(self._names(self._instancers, "", time))

    def forget_points(self) -> None:
        """Look at the points again when they are next numbered."""
        self._points = None

    def leave_time(self) -> None:
        """Look at the points again where there may be others at another time."""
        if self._may_vary:
            self._points = None

    def _add(self, path: str, steps: Steps) -> None:
        below = self._instancers
        prototype = None
        for step in reversed(steps):
            roots = below.setdefault(step.instancer, {})
            prototype = roots.setdefault(step.prototype, _Prototype())
            below = prototype.instancers
        assert prototype is not None
        prototype.paths.append(path)

    def _names(self, instancers: _Instancers, outer: str, time: Usd.TimeCode) -> Iterator[str]:
        for path, roots in instancers.items():
            targets = [roots.get(root) for root in prototypes_of(self._stage.GetPrimAtPath(path))]
            for point, index in zip(*self._points_of(path, time), strict=True):
                prototype = targets[index] if 0 <= index < len(targets) else None
                if prototype is not None:
                    name = f"{point_name(path, point, is_shared=True)}{outer}"  # as `lasting_name`
                    yield from (f"{each}{name}" for each in prototype.paths)
                    yield from self._names(prototype.instancers, name, time)

    def _points_of(self, path: Sdf.Path, time: Usd.TimeCode) -> tuple[Sequence[int], Sequence[int]]:
        """Return the number of each point of an instancer, drawn or not, and the place of its prototype."""
        assert self._points is not None
        if path not in self._points:
            instancer = UsdGeom.PointInstancer(self._stage.GetPrimAtPath(path))
            authored = np.asarray(instancer.GetProtoIndicesAttr().Get(time) or np.zeros(0, np.int32))
            indices = authored.tolist() if authored.dtype.kind in "iu" else []  # files may declare another type
            attributes = map(instancer.GetPrim().GetAttribute, POINT_ATTRIBUTES)
            self._may_vary |= any(each.GetNumTimeSamples() for each in attributes)
            self._points[path] = point_numbers(instancer, len(indices), time), indices
        return self._points[path]


def decides_points(names: Collection[str]) -> bool:
    """Return whether some of the properties that have changed on a prim decide which points an instancer has."""
    return not POINT_ATTRIBUTES.isdisjoint(names)
