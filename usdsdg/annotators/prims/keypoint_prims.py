"""The prims of a stage that have keypoints, with their points in the world."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.annotators.ownership import Owner, ancestors
from usdsdg.annotators.point_instances import PointFrames, Steps, prim_path
from usdsdg.stage.keypoints import NAMESPACE, get_keypoints, has_keypoints, keypoints_vary


class KeypointPrim(NamedTuple):
    """One prim, or point instance, with its keypoints."""

    name: str  # prim path as annotators report it
    ancestors: tuple[str, ...]  # names of the prim and its ancestors, nearest first
    keypoints: tuple[str, ...]
    positions: np.ndarray  # (K, 3) float64 in the world


class KeypointReader:
    """Finds the prims with keypoints once, and again where the stage has changed."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._paths: list[Sdf.Path] | None = None  # None: not known
        # Gprims and their instances, with what follows from them alone: owners by path, and prims in prototypes.
        self._drawn: tuple[Any, Any, dict[Sdf.Path, tuple[Owner, ...]], set[Sdf.Path]] | None = None
        self._constant: dict[Sdf.Path, dict[str, tuple[float, float, float]]] = {}

    def invalidate(self) -> None:
        """Look for prims with keypoints again."""
        self._paths = self._drawn = None
        self._constant.clear()

    def affects(self, names: Iterable[str]) -> bool:
        """Return whether a change of properties of these names may have changed keypoints."""
        return any(name.startswith(NAMESPACE) for name in names)

    def read(
        self, gprims: Sequence[str], steps: Sequence[Steps], frames: PointFrames, time: Usd.TimeCode
    ) -> tuple[KeypointPrim, ...]:
        """Return the prims with keypoints in stage order, without those that are hidden.

        In the prototype of a point instancer there is one for each instance that is drawn.
        """
        owners = self._owners(gprims, steps, time)
        found = []
        for owner in owners:
            if points := self._points_of(owner.path, time):
                matrix = frames.to_world(owner.path, owner.steps)
                positions = np.array(list(points.values())) @ matrix[:3, :3] + matrix[3, :3]
                names = tuple(each.name for each in ancestors(owner.path, owner.steps))
                found.append(KeypointPrim(owner.name, names, tuple(points), positions))
        return tuple(found)

    def _points_of(self, path: Sdf.Path, time: Usd.TimeCode) -> dict[str, tuple[float, float, float]]:
        """Return the keypoints of a prim by name; those that no time changes are read once."""
        if path in self._constant:
            return self._constant[path]
        prim = self._stage.GetPrimAtPath(path)
        points = get_keypoints(prim, time)
        if not keypoints_vary(prim):
            self._constant[path] = points
        return points

    def _owners(self, gprims: Sequence[str], steps: Sequence[Steps], time: Usd.TimeCode) -> list[Owner]:
        if self._paths is None:
            everything = Usd.PrimRange.Stage(self._stage, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate))
            self._paths = [prim.GetPath() for prim in everything if has_keypoints(prim)]
        if not self._paths:
            return []
        if self._drawn is None or self._drawn[0] is not gprims or self._drawn[1] is not steps:
            self._drawn = (gprims, steps, *self._find_drawn(self._paths, gprims, steps))
        _, _, drawn, inside = self._drawn
        found = []
        for path, owners in drawn.items():
            found += owners
            if not owners and not any(path.HasPrefix(prototype) for prototype in inside) and self._is_shown(path, time):
                found.append(Owner(path))
        return found

    def _find_drawn(
        self, paths: Iterable[Sdf.Path], gprims: Sequence[str], steps: Sequence[Steps]
    ) -> tuple[dict[Sdf.Path, tuple[Owner, ...]], set[Sdf.Path]]:
        """Return who owns gprims at or below each path, and which prims are in prototypes of point instancers."""
        drawn: dict[Sdf.Path, dict[Owner, None]] = {path: {} for path in paths}
        inside: set[Sdf.Path] = set()
        for gprim, way in zip(gprims, steps):
            inside.update(step.prototype for step in way)
            for owner in ancestors(prim_path(gprim), way):
                if owner.path in drawn:
                    drawn[owner.path][owner] = None
        return {path: tuple(owners) for path, owners in drawn.items()}, inside

    def _is_shown(self, path: Sdf.Path, time: Usd.TimeCode) -> bool:
        """Return whether a prim without gprims of its own is there: active, defined and not invisible.

        What is below a point instancer is there where points draw it only.
        """
        prims = list(map(self._stage.GetPrimAtPath, path.GetPrefixes()))
        # Of what is in a class, instance proxies do not say so.
        if any(not each.IsActive() or not each.IsDefined() or each.IsAbstract() for each in prims):
            return False
        if any(above.IsA(UsdGeom.PointInstancer) for above in prims[:-1]):
            return False
        imageable = UsdGeom.Imageable(prims[-1])
        return not imageable or imageable.ComputeVisibility(time) != UsdGeom.Tokens.invisible
