"""Bounds of labeled prims in their own frames, kept from frame to frame and read again where the stage has changed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.annotators.bounds.hulls import MESH_ATTRIBUTES, Hull, read_hull
from usdsdg.annotators.ownership import Owner
from usdsdg.annotators.point_instances import PointFrames, Steps, prim_path
from usdsdg.errors import warn_once
from usdsdg.stage.changes import Changes, is_below
from usdsdg.stage.geometry.point_velocities import VELOCITIES, have_velocities
from usdsdg.stage.geometry.skinning import Skinning
from usdsdg.stage.poses.transforms import as_array
from usdsdg.stage.time_code import attributes_with_values

# Attributes that determine the geometry of a gprim, or the transforms of point instances.
_GEOMETRY = {*MESH_ATTRIBUTES, *VELOCITIES, "extent", "radius", "height", "axis", "size", "width", "length"}
_GEOMETRY |= {"radiusTop", "radiusBottom"}
_GEOMETRY |= {"curveVertexCounts", "basis", "wrap", "type", "tangents"}
_GEOMETRY |= {"widths", "primvars:widths", "primvars:widths:indices"}
_GEOMETRY |= {"tetVertexIndices", "indices", "positions", "orientations", "orientationsf", "scales", "ids"}

_Group = tuple[int, ...]  # indices into the gprims that are drawn
_Known = dict[tuple[Owner, tuple[str, ...]], np.ndarray]  # bounds of the gprims that an owner has


class PrimBounds:
    """The bounds of the groups of gprims that labeled prims own, at one time of a stage."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._hulls: dict[Sdf.Path, Hull | None] = {}
        self._static: set[Sdf.Path] = set()  # gprims whose hull does not vary over time
        self._of_sources: dict[tuple[Any, ...], Hull | None] = {}  # hulls of meshes, by where their points are authored
        self._divided: set[Sdf.Path] = set()  # meshes whose GeomSubsets are gprims of their own
        self._skinning = Skinning()
        self._bounds: dict[Sdf.Path, _Known] = {}  # by path of the owner
        # By path of an owner that does not carry all its gprims along: the prims that place them or it.
        self._placed_by: dict[Sdf.Path, set[Sdf.Path]] = {}
        self._all: np.ndarray | None = None  # those of the last call of `read`, if they still hold

    def read(
        self,
        owners: Sequence[Owner],
        groups: Sequence[_Group],
        gprims: Sequence[str],
        steps: Sequence[Steps],
        cache: UsdGeom.XformCache,
        frames: PointFrames,
    ) -> np.ndarray:
        """Return (N, 2, 3) float64 minima and maxima of the groups of owners, in the owners' frames.

        gprims, steps: those that are drawn, since the last call of `divide`. cache, frames: at the time of the frame.
        """
        if self._all is None:
            before, self._bounds = self._bounds, {}
            bounds = [
                self._of_group(owner, group, gprims, steps, cache, frames, before.get(owner.path, {}))
                for owner, group in zip(owners, groups)
            ]
            self._all = np.array(bounds, np.float64).reshape(-1, 2, 3)
            self._placed_by = {path: places for path, places in self._placed_by.items() if path in self._bounds}
        return self._all.copy()

    def leave_time(self) -> None:
        """Forget what holds only for the time of the last frame."""
        self._hulls = {path: hull for path, hull in self._hulls.items() if path in self._static}
        self._of_sources.clear()
        self._forget()

    def divide(self, gprims: Iterable[str]) -> None:
        """Note other gprims, and which meshes are divided: hulls of those that were not, or are no more, are others."""
        self._all = None
        prims = map(self._stage.GetPrimAtPath, map(prim_path, gprims))
        meshes = {prim.GetPath().GetParentPath() for prim in prims if prim.IsA(UsdGeom.Subset)}
        others = meshes ^ self._divided
        for path in others:
            self._hulls.pop(path, None)
        self._forget_above(others)
        self._divided = meshes

    def follow(self, changes: Changes) -> None:
        """Forget what changes of the stage concern."""
        if changes.resynced or any(not _GEOMETRY.isdisjoint(names) for names in changes.by_names):
            self._of_sources.clear()
        if self._skinning.is_affected_by(self._stage, changes):
            self._skinning.invalidate()
            self._hulls.clear()
            self._forget()
        if roots := changes.resynced:
            changed = {root.GetParentPath() if root.GetParentPath() in self._divided else root for root in roots}
            self._hulls = {path: hull for path, hull in self._hulls.items() if not is_below(path, changed)}
            self._keep(lambda path: not is_below(path, changed))
            self._forget_above(roots)
            self._forget_placed_by(roots)
        for names, paths in changes.by_names.items():
            if not _GEOMETRY.isdisjoint(names):
                self._forget_geometry(paths)
                self._forget_placed_by(paths)
            elif any(name.startswith("xformOp") for name in names):
                # The bounds of labeled ancestors change; those in the prim's own frame do not.
                self._forget_above({path.GetParentPath() for path in paths})
                self._forget_placed_by(paths)

    def _of_group(
        self,
        owner: Owner,
        group: _Group,
        gprims: Sequence[str],
        steps: Sequence[Steps],
        cache: UsdGeom.XformCache,
        frames: PointFrames,
        before: _Known,
    ) -> np.ndarray:
        """Return (2, 3) bounds of the group in the owner's frame; both zero when nothing has an extent."""
        key = owner, tuple(gprims[each] for each in group)
        known = before.get(key)
        if known is None:
            bounds = [self._of_gprim(prim_path(gprims[each]), steps[each], owner, cache, frames) for each in group]
            parts = [part for part in bounds if part is not None]
            if not parts:
                # Of a divided mesh all faces may be in subsets with labels of their own.
                if not all(prim_path(gprims[each]) in self._divided for each in group):
                    warn_once(f"{owner.name}: none of its gprims has finite bounds, so its 3D box is empty.")
                return np.zeros((2, 3))
            known = np.stack([np.min(parts, axis=0)[0], np.max(parts, axis=0)[1]])
        self._bounds.setdefault(owner.path, {})[key] = known
        return known

    def _of_gprim(
        self, path: Sdf.Path, steps: Steps, owner: Owner, cache: UsdGeom.XformCache, frames: PointFrames
    ) -> np.ndarray | None:
        prim = self._stage.GetPrimAtPath(path)
        if path not in self._hulls:
            self._hulls[path] = self._read_hull(prim, cache.GetTime())
        hull = self._hulls[path]
        if hull is None:
            return None
        if steps == owner.steps:
            relative, resets = cache.ComputeRelativeTransform(prim, self._stage.GetPrimAtPath(owner.path))
            if not resets:
                return hull(as_array(relative))
        # With an instancer or `resetXformStack` between the two, only their world transforms are comparable.
        places = [path, owner.path, *(step.instancer for step in (*steps, *owner.steps))]
        places_above = {above for place in places for above in place.GetPrefixes()}
        self._placed_by.setdefault(owner.path, set()).update(places_above)
        return hull(frames.to_world(path, steps) @ np.linalg.inv(frames.to_world(owner.path, owner.steps)))

    def _read_hull(self, prim: Usd.Prim, time: Usd.TimeCode) -> Hull | None:
        """Read the hull of a gprim; that of a mesh once for all prims that get its points from one place."""
        divided = prim.GetPath() in self._divided
        is_static = self._note_whether_static(prim)
        source = _source(prim) if is_static and not divided else None
        if source is None:
            return read_hull(prim, time, self._skinning, divided=divided)
        if source not in self._of_sources:
            self._of_sources[source] = read_hull(prim, time, self._skinning)
        return self._of_sources[source]

    def _note_whether_static(self, prim: Usd.Prim) -> bool:
        gprim = prim.GetParent() if prim.IsA(UsdGeom.Subset) else prim
        varies = any(
            attribute.GetName() in _GEOMETRY and attribute.ValueMightBeTimeVarying()
            for each in (gprim, *self._subsets_of(gprim))
            for attribute in attributes_with_values(each)
        )
        is_static = not (varies or have_velocities(gprim) or self._skinning.is_skinned(gprim))
        (self._static.add if is_static else self._static.discard)(prim.GetPath())
        return is_static

    def _subsets_of(self, gprim: Usd.Prim) -> list[Usd.Prim]:
        """Return the GeomSubsets of a mesh that is divided, which decide together whose its faces are."""
        if gprim.GetPath() not in self._divided:
            return []
        below = gprim.GetFilteredChildren(Usd.TraverseInstanceProxies(Usd.PrimIsActive))
        return [each for each in below if each.IsA(UsdGeom.Subset)]

    def _forget_geometry(self, paths: Iterable[Sdf.Path]) -> None:
        """Forget gprims, also the subsets of a mesh, and of a subset the mesh and the other ones."""
        edited = {path.GetParentPath() if path.GetParentPath() in self._divided else path for path in paths}
        self._hulls = {
            path: hull
            for path, hull in self._hulls.items()
            if path not in edited and path.GetParentPath() not in edited
        }
        self._keep(lambda path: path.GetParentPath() not in edited)
        self._forget_above(edited)

    def _forget_above(self, paths: Iterable[Sdf.Path]) -> None:
        """Forget the bounds of owners at and above some prims."""
        for path in paths:
            for prefix in path.GetPrefixes():
                if self._bounds.pop(prefix, None) is not None:
                    self._all = None

    def _forget_placed_by(self, paths: Iterable[Sdf.Path]) -> None:
        """Forget the bounds of owners whose gprims some prims place otherwise than by carrying both along."""
        for owner, places in self._placed_by.items():
            if not places.isdisjoint(paths):
                self._forget_above({owner})

    def _keep(self, is_kept: Callable[[Sdf.Path], bool]) -> None:
        self._bounds = {path: known for path, known in self._bounds.items() if is_kept(path)}
        self._all = None

    def _forget(self) -> None:
        self._bounds.clear()
        self._placed_by.clear()
        self._all = None


def _source(prim: Usd.Prim) -> tuple[Any, ...] | None:
    """Return all layers and paths that decide the hull of a static mesh, None for other gprims."""
    if prim.GetTypeName() != "Mesh":
        return None
    attributes = filter(None, map(prim.GetAttribute, MESH_ATTRIBUTES))
    return tuple((spec.layer, spec.path) for attribute in attributes for spec in attribute.GetPropertyStack())
