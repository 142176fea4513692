"""The prims of a stage that have keypoints, with their points in the world."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.annotators.ownership import Owner, ancestors
from usdsdg.annotators.point_instances import PointFrames, Steps, prim_path
from usdsdg.stage.keypoints import NAMESPACE, get_keypoints, has_keypoints


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

    def invalidate(self) -> None:
        """Look for prims with keypoints again."""
        self._paths = None

    def affects(self, names: Iterable[str]) -> bool:
        """Return whether a change of properties of these names may have added or removed keypoints."""
        return any(name.startswith(NAMESPACE) for name in names)

    def read(
        self, gprims: Sequence[str], steps: Sequence[Steps], frames: PointFrames, time: Usd.TimeCode
    ) -> tuple[KeypointPrim, ...]:
        """Return the prims with keypoints in stage order, without those that are hidden.

        In the prototype of a point instancer there is one for each instance that is drawn.
        """
        owners = self._owners(gprims, steps)
        found = []
        for owner in owners:
            prim = self._stage.GetPrimAtPath(owner.path)
            points = get_keypoints(prim, time)
            if points:
                matrix = frames.to_world(owner.path, owner.steps)
                positions = np.array(list(points.values())) @ matrix[:3, :3] + matrix[3, :3]
                names = tuple(each.name for each in ancestors(owner.path, owner.steps))
                found.append(KeypointPrim(owner.name, names, tuple(points), positions))
        return tuple(found)

    def _owners(self, gprims: Sequence[str], steps: Sequence[Steps]) -> list[Owner]:
        if self._paths is None:
            everything = Usd.PrimRange.Stage(self._stage, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate))
            self._paths = [prim.GetPath() for prim in everything if has_keypoints(prim)]
        if not self._paths:
            return []
        drawn: dict[Sdf.Path, dict[Owner, None]] = {path: {} for path in self._paths}
        inside: set[Sdf.Path] = set()  # prims in prototypes of point instancers
        for gprim, way in zip(gprims, steps):
            inside.update(step.prototype for step in way)
            for owner in ancestors(prim_path(gprim), way):
                if owner.path in drawn:
                    drawn[owner.path][owner] = None
        for path, owners in drawn.items():
            if not owners and not any(path.HasPrefix(prototype) for prototype in inside) and self._is_shown(path):
                owners[Owner(path)] = None
        return [owner for owners in drawn.values() for owner in owners]

    def _is_shown(self, path: Sdf.Path) -> bool:
        """Return whether a prim without gprims of its own is there: active, defined and not invisible."""
        prim = self._stage.GetPrimAtPath(path)
        if not prim.IsActive() or not prim.IsDefined() or prim.IsAbstract():
            return False
        imageable = UsdGeom.Imageable(prim)
        return not imageable or imageable.ComputeVisibility() != UsdGeom.Tokens.invisible
