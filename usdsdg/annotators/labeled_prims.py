"""The labeled prims of a stage, read for one frame: which gprims each owns, its bounds and its pose.

A labeled prim owns the gprims whose nearest labeled ancestor (or self) it is. A label filter changes which ancestor is
the nearest: with "class:*", the gprims of a wheel labeled only {part: wheel} belong to the car {class: car} above it.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.annotators.class_table import ClassTable, ids_are_stable
from usdsdg.annotators.colors import FIRST_LABELED
from usdsdg.annotators.ownership import (
    LabeledStage,
    Labels,
    Owner,
    find_owners,
    output_labels,
    parse_filter,
    warn_of_empty_selection,
)
from usdsdg.annotators.point_instances import PointFrames, Steps
from usdsdg.annotators.prims.keypoint_prims import KeypointPrim, KeypointReader
from usdsdg.annotators.prims.label_tables import FrameClasses, PrimTable
from usdsdg.annotators.prims.possible_labels import possible_outputs
from usdsdg.annotators.prims.prim_bounds import PrimBounds
from usdsdg.annotators.prims.skeleton_prims import SkeletonPrims
from usdsdg.graph.label_sources import label_sources
from usdsdg.session.session import current
from usdsdg.stage.change_tracker import ChangeTracker
from usdsdg.stage.changes import Changes

# What decides which material a gprim shows: relationships to materials, and collections of prims that bind one.
_BINDINGS = ("material:binding", "collection:")


# The prims that change are mostly those that changed before.
_is_in_prototype = lru_cache(maxsize=1 << 14)(Usd.Prim.IsPathInPrototype)


@dataclass(frozen=True)
class Selection:
    """The labeled prims that pass a label filter, in stage order."""

    rows: np.ndarray  # (K,) int64: rows of the `LabeledPrims`
    member_of_gprim: np.ndarray  # (G,) int32: index into rows, -1 for gprims of no selected prim
    labels: tuple[dict[str, str], ...]  # K times {type: "label[,label]"}, as annotators output them
    class_ids: np.ndarray  # (K,) int64: id of the labels in semantic_segmentation, the same in all frames
    class_labels: Mapping[int, dict[str, str]]  # of each class by id, also of those that no prim has now
    class_colors: Mapping[int, tuple[int, int, int, int]]  # RGBA by id, where the user has given them
    numbers: np.ndarray  # (K,) int64: number of the prim among all labeled prims, the same in all frames
    prim_count: int  # numbers are below this

    @property
    def ids(self) -> np.ndarray:
        """The ids (K,) of the prims in instance_segmentation."""
        return self.numbers + FIRST_LABELED

    def __len__(self) -> int:
        return len(self.rows)


@dataclass(frozen=True)
class LabeledPrims:
    """One row per labeled prim that owns gprims; more rows where a filter gives a prim a larger group of gprims.

    The renderer computes amodal masks of `groups`.
    """

    prim_paths: tuple[str, ...] = ()
    labels: tuple[Labels, ...] = ()  # own and inherited, outermost first; lower case
    groups: tuple[tuple[int, ...], ...] = ()  # indices into gprims
    bounds: np.ndarray = field(default_factory=lambda: np.zeros((0, 2, 3)))  # (N, 2, 3) min, max in the prim's frame
    local_to_world: np.ndarray = field(default_factory=lambda: np.zeros((0, 4, 4)))  # (N, 4, 4) float64
    row_of_gprim: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))  # (G,) row, -1 = unlabeled
    selections: Mapping[str | None, Selection] = field(default_factory=dict)
    read_keypoints: Callable[[], tuple[KeypointPrim, ...]] = tuple  # reads the prims with keypoints from the stage
    find_skeletons: Callable[[], Sequence[Sdf.Path]] | None = None  # finds all skeletons of the stage; None: not known

    def __len__(self) -> int:
        return len(self.prim_paths)

    def select(self, predicate: str | None) -> Selection:
        """Return the labeled prims under the filter `predicate` (None: every label passes)."""
        known = self.selections.get(predicate)
        return known if known is not None else self._filtered(predicate)

    def _filtered(self, predicate: str | None) -> Selection:
        """Apply a filter that the reader was not given: keep or drop whole rows of the unfiltered prims."""
        base = np.unique(self.row_of_gprim[self.row_of_gprim >= 0])
        label_filter = parse_filter(predicate)
        kept = [row for row in base if label_filter is None or label_filter.select(self.labels[row])]
        member_of_row = np.full(len(self) + 1, -1, np.int32)
        member_of_row[kept] = np.arange(len(kept))
        output = tuple(output_labels(self.labels[row], label_filter) for row in kept)
        classes = current().class_tables.of(predicate) if ids_are_stable() else FrameClasses()
        names, members = [self.prim_paths[row] for row in kept], member_of_row[self.row_of_gprim]
        return _selection(classes, PrimTable(), np.array(kept, np.int64), members, output, names)


def _selection(
    classes: ClassTable | FrameClasses, prims: PrimTable,
    rows: np.ndarray, members: np.ndarray, output: Sequence[dict[str, str]], names: Sequence[str],
) -> Selection:  # fmt: skip
    """Return the selection of prims with these output labels and names, with their ids and numbers in tables."""
    ids, numbers = classes.ids(output), prims.numbers(names)
    return Selection(rows, members, tuple(output), ids, classes.labels(), classes.colors(), numbers, len(prims))


@dataclass(frozen=True)
class _Ownership:
    """The part of `LabeledPrims` that depends on labels and gprims, not on poses."""

    gprims: tuple[str, ...]
    steps: list[Steps]  # of each gprim
    owners: tuple[Owner, ...]
    names: tuple[str, ...]  # of the owners
    labels: tuple[Labels, ...]
    groups: tuple[tuple[int, ...], ...]
    selections: Mapping[str | None, Selection]


class LabeledPrimReader:
    """Reads the labeled prims of a stage for every frame, incrementally from stage changes.

    for_dataset: False gives ids that count what one frame shows, and leaves the class tables of the session alone.
    """

    def __init__(self, stage: Usd.Stage, *, for_dataset: bool = True) -> None:
        self._stage = stage
        self._for_dataset = for_dataset
        self._changes = ChangeTracker(stage)
        self._labels = LabeledStage(stage)
        self._bounds = PrimBounds(stage)
        self._ownership: _Ownership | None = None
        self._filters: dict[str | None, None] = {None: None}  # all requested so far; the unfiltered one is first
        self._is_surveyed: set[str | None] = set()  # filters whose prims have numbers as the stage is now
        self._prims: dict[str | None, PrimTable] = {}  # by filter
        self._tables_version = -1  # of the class tables that the ownership has ids of; 0 where ids are not stable
        self._keypoints, self._skeletons = KeypointReader(stage), SkeletonPrims(stage)
        self._time: Usd.TimeCode | None = None

    def read(
        self,
        gprims: Sequence[str],
        filters: Iterable[str | None] = (),
        *,
        time: Usd.TimeCode | None = None,
        poses: bool = True,
    ) -> LabeledPrims:
        """Return the labeled prims that own `gprims` (paths as in the renderer's table), at `time` (default: the
        default time).

        filters: label filters that will be selected from the result. Filters given here are exact for nested labeled
            prims: rows are added for the groups of gprims that they make.
        poses: whether to read bounds and transforms, which are zero else.
        """
        time = Usd.TimeCode.Default() if time is None else time
        owned = self._owned(tuple(gprims), filters, time)
        cache = UsdGeom.XformCache(time)
        frames = PointFrames(self._stage, cache)
        count = len(owned.owners)
        bounds, local_to_world = np.zeros((count, 2, 3)), np.zeros((count, 4, 4))
        if poses:
            bounds = self._bounds.read(owned.owners, owned.groups, owned.gprims, owned.steps, cache, frames)
            local_to_world = frames.all_to_world([(owner.path, owner.steps) for owner in owned.owners])
        return LabeledPrims(
            owned.names,
            owned.labels,
            owned.groups,
            bounds,
            local_to_world,
            # The unfiltered selection is the first, so its members are the rows.
            owned.selections[None].member_of_gprim,
            owned.selections,
            lambda: self._keypoints.read(owned.gprims, owned.steps, frames, time),
            self._skeletons.find,
        )

    def names_and_selection(
        self, gprims: Sequence[str], predicate: str | None, *, time: Usd.TimeCode
    ) -> tuple[tuple[str, ...], Selection]:
        """Return the labeled prims under a filter, and their paths, as `read` does, without bounds and poses."""
        owned = self._owned(tuple(gprims), [predicate], time)
        selection = owned.selections[predicate]
        return tuple(owned.names[row] for row in selection.rows), selection

    def _owned(self, gprims: tuple[str, ...], filters: Iterable[str | None], time: Usd.TimeCode) -> _Ownership:
        """Return which prims own gprims now, after what has changed on the stage."""
        self._invalidate(self._changes.take())
        if time != self._time:
            self._bounds.leave_time()
            self._time = time
            if self._labels.set_time(time):
                self._ownership = None
        # Earlier filters are kept, since render products with different filters alternate.
        self._filters |= dict.fromkeys(filters)
        self._follow_tables()
        owned = self._ownership
        if owned is None or owned.gprims != gprims or owned.selections.keys() != self._filters.keys():
            owned = self._ownership = self._assign(gprims)
            self._bounds.divide(gprims)
        return owned

    def survey(self, filters: Iterable[str | None]) -> None:
        """Number what a frame could show that is not rendered here, as `read` does, so that later ones agree.

        filters: label filters that would be selected from the result.
        """
        self._invalidate(self._changes.take())
        self._filters |= dict.fromkeys(filters)
        self._follow_tables()
        for predicate in self._filters:
            self._tables(predicate)

    def close(self) -> None:
        """Stop listening to the stage."""
        self._changes.close()

    def _assign(self, gprims: tuple[str, ...]) -> _Ownership:
        found = self._labels.chains(gprims)
        row_of: dict[tuple[Owner, tuple[int, ...]], int] = {}
        labels: list[Labels] = []
        selections: dict[str | None, Selection] = {}
        for predicate in self._filters:
            label_filter = parse_filter(predicate)
            rows, members, output, names = [], np.full(len(gprims), -1, np.int32), [], []
            for owned in find_owners(self._labels, gprims, [chain for _, chain in found], label_filter):
                key = owned.owner, owned.group
                if key not in row_of:
                    row_of[key] = len(row_of)
                    labels.append(owned.labels)
                members[list(owned.group)] = len(rows)
                rows.append(row_of[key])
                names.append(owned.owner.name)
                output.append(owned.output)
            classes, prims = self._tables(predicate)
            selections[predicate] = _selection(classes, prims, np.array(rows, np.int64), members, output, names)
            if not rows:
                warn_of_empty_selection(predicate, [labels for _, chain in found for _, labels in chain])
        owners, groups = tuple(owner for owner, _ in row_of), tuple(group for _, group in row_of)
        names = tuple(owner.name for owner in owners)
        return _Ownership(gprims, [steps for steps, _ in found], owners, names, tuple(labels), groups, selections)

    def _has_tables(self) -> bool:
        """Return whether ids are those of the session's class tables."""
        return self._for_dataset and ids_are_stable()

    def _follow_tables(self) -> None:
        """Assign ids again where the user has changed the classes, or whether ids are stable."""
        version = current().class_tables.version if self._has_tables() else 0
        if version != self._tables_version:
            self._tables_version, self._ownership = version, None
            self._prims.clear()
            self._is_surveyed.clear()

    def _tables(self, predicate: str | None) -> tuple[ClassTable | FrameClasses, PrimTable]:
        """Return the tables of a filter, with all that the stage has now; at first also with what the graph can show.

        What is in view does not decide, so that processes that render different frames have the same tables.
        """
        if not self._has_tables():
            return FrameClasses(), PrimTable()
        classes = current().class_tables.of(predicate)
        if predicate not in self._is_surveyed:
            self._is_surveyed.add(predicate)
            is_new = predicate not in self._prims
            prims = self._prims.setdefault(predicate, PrimTable())
            label_filter, gprims = parse_filter(predicate), self._labels.every_gprim()
            chains, outputs = [chain for _, chain in self._labels.chains(gprims)], []
            for owned in find_owners(self._labels, gprims, chains, label_filter):
                outputs.append(owned.output)
                if not owned.owner.steps:  # point instances are numbered when they are drawn
                    prims.numbers([owned.owner.name])
            if is_new and (sources := label_sources()):
                outputs += possible_outputs(self._labels, sources, label_filter)
            classes.add(outputs)
        return classes, self._prims[predicate]

    # Changes

    def _invalidate(self, changes: Changes) -> None:
        # A change in a prototype applies to all its instances, whose paths are not reported.
        if any(map(_is_in_prototype, changes.resynced)) or any(map(_is_in_prototype, changes.changed)):
            changes = Changes({Sdf.Path.absoluteRootPath})
        self._bounds.follow(changes)
        if changes.resynced:
            self._skeletons.invalidate()
        if changes.resynced or any(map(self._keypoints.affects, changes.by_names)):
            self._keypoints.invalidate()
        if changes.resynced:
            self._ownership = None
            self._is_surveyed.clear()
            self._labels.invalidate(changes.resynced)
        for names in changes.by_names:
            if any(name.startswith(("semantics:", "semantic:")) for name in names):
                self._ownership = None
                self._is_surveyed.clear()
                self._labels.invalidate()
            elif self._labels.has_labeled_materials and any(name.startswith(_BINDINGS) for name in names):
                self._ownership = None
                self._is_surveyed.clear()
