"""Which gprims belong together under which label: the labelled prims of a stage, read for one frame.

An entity is a labelled prim with the gprims whose nearest labelled ancestor (or self) it is. A label filter
changes who is the nearest: with "class:*", the gprims of a wheel labelled only {part: wheel} belong to the car
{class: car} above it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.annotators.bounds import Hull, read_hull
from usdsdg.errors import warn_once
from usdsdg.stage.changes import Changes, ChangeTracker
from usdsdg.stage.semantics import LabelFilter, get_labels, inherited_labels
from usdsdg.stage.transforms import as_array

Labels = Mapping[str, Sequence[str]]

# Attributes that shape a gprim.
_GEOMETRY = {"points", "faceVertexIndices", "extent", "radius", "height", "axis", "size", "width", "length"}
_GEOMETRY |= {"widths", "radiusTop", "radiusBottom", "curveVertexCounts"}


@dataclass(frozen=True)
class Selection:
    """The entities that pass a label filter, in stage order."""

    rows: np.ndarray  # (K,) int64: rows of the `Entities`
    member_of_gprim: np.ndarray  # (G,) int32: index into rows, -1 for gprims of no selected entity
    labels: tuple[dict[str, str], ...]  # K times {type: "label[,label]"}, as annotators print them

    def __len__(self) -> int:
        return len(self.rows)


@dataclass(frozen=True)
class Entities:
    """One row per labelled prim that owns gprims; more rows where a filter gives a prim a larger group of gprims.

    `groups` is what a renderer's coverage pass takes.
    """

    prim_paths: tuple[str, ...] = ()
    labels: tuple[Labels, ...] = ()  # own and inherited, outermost first; lower case
    groups: tuple[tuple[int, ...], ...] = ()  # indices into gprims
    bounds: np.ndarray = field(default_factory=lambda: np.zeros((0, 2, 3)))  # (N, 2, 3) min, max; prim's own frame
    local_to_world: np.ndarray = field(default_factory=lambda: np.zeros((0, 4, 4)))  # (N, 4, 4) float64
    entity_of_gprim: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))  # (G,) row, -1 = unlabelled
    selections: Mapping[str | None, Selection] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.prim_paths)

    def select(self, predicate: str | None) -> Selection:
        """The entities under the filter `predicate` (None: every label passes)."""
        known = self.selections.get(predicate)
        return known if known is not None else self._reduce(predicate)

    def _reduce(self, predicate: str | None) -> Selection:
        """A filter that was not announced to the reader: keep or drop whole rows of the unfiltered entities."""
        base = np.unique(self.entity_of_gprim[self.entity_of_gprim >= 0])
        label_filter = _filter(predicate)
        kept = [row for row in base if label_filter is None or label_filter.select(self.labels[row])]
        member_of_row = np.full(len(self) + 1, -1, np.int32)
        member_of_row[kept] = np.arange(len(kept))
        printed = tuple(print_labels(_passed(self.labels[row], label_filter)) for row in kept)
        return Selection(np.array(kept, np.int64), member_of_row[self.entity_of_gprim], printed)


def print_labels(labels: Labels) -> dict[str, str]:
    """{type: "label[,label]"}."""
    return {kind: ",".join(values) for kind, values in labels.items()}


def _filter(predicate: str | None) -> LabelFilter | None:
    """The filter; labels in it are compared in lower case, as labels are read."""
    return LabelFilter(re.sub(r":[^,;]*", lambda labels: labels[0].lower(), predicate)) if predicate else None


def _passed(labels: Labels, label_filter: LabelFilter | None) -> Labels:
    return labels if label_filter is None else label_filter.select(labels)


@dataclass(frozen=True)
class _Ownership:
    """The part of `Entities` that changes only with labels and gprims, not with poses."""

    gprims: tuple[str, ...]
    prim_paths: tuple[str, ...]
    labels: tuple[Labels, ...]
    groups: tuple[tuple[int, ...], ...]
    entity_of_gprim: np.ndarray
    selections: Mapping[str | None, Selection]


class EntityReader:
    """Reads the entities of a stage again and again, touching only what changed since."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._changes = ChangeTracker(stage)
        self._own_labels: dict[Sdf.Path, Labels] = {}
        self._hulls: dict[str, Hull | None] = {}
        self._bounds: dict[str, dict[tuple[int, ...], np.ndarray]] = {}
        self._ownership: _Ownership | None = None
        self._time: Usd.TimeCode | None = None

    def read(
        self,
        gprims: Sequence[str],
        filters: Iterable[str | None] = (),
        *,
        time: Usd.TimeCode | None = None,
    ) -> Entities:
        """The entities that own `gprims` (paths as in the renderer's table), at `time` (default: the default time).

        filters: label filters that will be selected from the result; announced here, they are exact where labelled
            prims nest, and rows for their groups are added.
        """
        self._forget_changed(self._changes.take())
        time = Usd.TimeCode.Default() if time is None else time
        if time != self._time:
            self._hulls.clear()
            self._bounds.clear()
            self._time = time
        gprims, wanted = tuple(gprims), [None, *dict.fromkeys(f for f in filters if f)]
        owned = self._ownership
        if owned is None or owned.gprims != gprims or list(owned.selections) != wanted:
            owned = self._ownership = self._assign(gprims, wanted)
            self._bounds.clear()
        cache = UsdGeom.XformCache(time)
        bounds = [self._bound(path, group, cache) for path, group in zip(owned.prim_paths, owned.groups)]
        poses = [as_array(cache.GetLocalToWorldTransform(self._prim(path))) for path in owned.prim_paths]
        return Entities(
            owned.prim_paths,
            owned.labels,
            owned.groups,
            np.array(bounds, np.float64).reshape(-1, 2, 3),
            np.array(poses, np.float64).reshape(-1, 4, 4),
            owned.entity_of_gprim,
            owned.selections,
        )

    def close(self) -> None:
        """Stop listening to the stage."""
        self._changes.close()

    # Ownership: gprim → nearest labelled ancestor, per filter.

    def _assign(self, gprims: tuple[str, ...], wanted: list[str | None]) -> _Ownership:
        chains = [self._labelled_chain(path) for path in gprims]
        row_of: dict[tuple[str, tuple[int, ...]], int] = {}
        labels: list[Labels] = []
        selections: dict[str | None, Selection] = {}
        for predicate in wanted:
            label_filter = _filter(predicate)
            rows, members, printed = [], np.full(len(gprims), -1, np.int32), []
            for path, group in _group(chains, label_filter).items():
                key = (str(path), group)
                if key not in row_of:
                    row_of[key] = len(row_of)
                    labels.append(_lower(inherited_labels(self._stage.GetPrimAtPath(path))))
                members[list(group)] = len(rows)
                rows.append(row_of[key])
                printed.append(print_labels(_passed(labels[row_of[key]], label_filter)))
            selections[predicate] = Selection(np.array(rows, np.int64), members, tuple(printed))
        return _Ownership(
            gprims,
            tuple(path for path, _ in row_of),
            tuple(labels),
            tuple(group for _, group in row_of),
            # The unfiltered selection came first, so its members are the rows.
            selections[None].member_of_gprim,
            selections,
        )

    def _labelled_chain(self, gprim: str) -> list[tuple[Sdf.Path, Labels]]:
        """The labelled prims from `gprim` up to the root, nearest first."""
        chain, path = [], Sdf.Path(_prim_part(gprim))
        while not path.IsAbsoluteRootPath():
            own = self._labels_of(path)
            if own:
                chain.append((path, own))
            path = path.GetParentPath()
        return chain

    def _labels_of(self, path: Sdf.Path) -> Labels:
        if path not in self._own_labels:
            prim = self._stage.GetPrimAtPath(path)
            self._own_labels[path] = _lower(get_labels(prim)) if prim else {}
        return self._own_labels[path]

    # Geometry

    def _bound(self, path: str, group: tuple[int, ...], cache: UsdGeom.XformCache) -> np.ndarray:
        """(2, 3) bounds of the group in the frame of `path`; a point at the origin when nothing has an extent."""
        known = self._bounds.setdefault(path, {})
        if group not in known:
            assert self._ownership is not None
            parts = [self._gprim_bound(self._ownership.gprims[g], path, cache) for g in group]
            parts = [part for part in parts if part is not None]
            if not parts:
                warn_once(
                    f"{path}: none of its gprims has finite bounds, so its 3D box is empty.", key=f"bounds {path}"
                )
                return np.zeros((2, 3))
            known[group] = np.stack([np.min(parts, axis=0)[0], np.max(parts, axis=0)[1]])
        return known[group]

    def _gprim_bound(self, gprim: str, ancestor: str, cache: UsdGeom.XformCache) -> np.ndarray | None:
        prim = self._prim(gprim)
        if gprim not in self._hulls:
            self._hulls[gprim] = read_hull(prim, cache.GetTime())
        hull = self._hulls[gprim]
        return None if hull is None else hull(_relative_transform(prim, self._prim(ancestor), cache))

    def _prim(self, path: str) -> Usd.Prim:
        return self._stage.GetPrimAtPath(_prim_part(path))

    # Changes

    def _forget_changed(self, changes: Changes) -> None:
        for root in changes.resynced:
            self._ownership = None
            self._own_labels = {p: own for p, own in self._own_labels.items() if not p.HasPrefix(root)}
            self._hulls = {p: hull for p, hull in self._hulls.items() if not _is_under(p, root)}
            self._bounds = {p: known for p, known in self._bounds.items() if not _is_under(p, root)}
            self._forget_bounds(root)
        for path, names in changes.changed.items():
            if any(name.startswith(("semantics:", "semantic:")) for name in names):
                self._ownership = None
                self._own_labels.clear()
            if not _GEOMETRY.isdisjoint(names):
                self._hulls.pop(str(path), None)
                self._forget_bounds(path)
            elif any(name.startswith("xformOp") for name in names):
                # The bounds of the entities above change; the prim's own frame moves along.
                self._forget_bounds(path.GetParentPath())

    def _forget_bounds(self, path: Sdf.Path) -> None:
        for prefix in path.GetPrefixes():
            self._bounds.pop(str(prefix), None)


def _group(
    chains: list[list[tuple[Sdf.Path, Labels]]], label_filter: LabelFilter | None
) -> dict[Sdf.Path, tuple[int, ...]]:
    """Owner → its gprims, in the order in which the owners are first met."""
    groups: dict[Sdf.Path, list[int]] = {}
    for index, chain in enumerate(chains):
        owner = next((path for path, own in chain if label_filter is None or label_filter.select(own)), None)
        if owner is not None:
            groups.setdefault(owner, []).append(index)
    return {path: tuple(group) for path, group in groups.items()}


def _relative_transform(prim: Usd.Prim, ancestor: Usd.Prim, cache: UsdGeom.XformCache) -> np.ndarray:
    if prim == ancestor:
        return np.eye(4)
    relative, resets = cache.ComputeRelativeTransform(prim, ancestor)
    if not resets:
        return as_array(relative)
    # `resetXformStack` between the two: only the world knows how they stand to each other.
    world = as_array(cache.GetLocalToWorldTransform(prim))
    return world @ np.linalg.inv(as_array(cache.GetLocalToWorldTransform(ancestor)))


def _lower(labels: Labels) -> Labels:
    """Labels as annotators print them; types keep their case."""
    return {kind: tuple(dict.fromkeys(value.lower() for value in values)) for kind, values in labels.items()}


def _is_under(path: str, root: Sdf.Path) -> bool:
    return Sdf.Path(_prim_part(path)).HasPrefix(root)


def _prim_part(gprim: str) -> str:
    """The prim path of a gprim entry; point instances are written as `path[index]`."""
    return gprim.split("[", 1)[0]
