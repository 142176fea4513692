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
from usdsdg.annotators.ownership import (
    Chain,
    LabeledStage,
    Labels,
    Owner,
    find_owners,
    output_labels,
    parse_filter,
    warn_of_empty_selection,
)
from usdsdg.annotators.point_instances import Places, PointFrames, Steps, lasting_name, prim_path
from usdsdg.annotators.prims.keypoint_prims import KeypointPrim, KeypointReader
from usdsdg.annotators.prims.label_tables import FrameClasses, PrimTable
from usdsdg.annotators.prims.possible_labels import possible_outputs
from usdsdg.annotators.prims.prim_bounds import PrimBounds
from usdsdg.annotators.prims.skeleton_prims import SkeletonPrim, SkeletonPrims
from usdsdg.annotators.prims.stage_numbers import StageNumbers, decides_points
from usdsdg.annotators.prims.subset_setting import subsets_are_told_apart
from usdsdg.annotators.selection import Selection
from usdsdg.graph.label_sources import label_sources
from usdsdg.session.session import current
from usdsdg.stage.change_tracker import ChangeTracker
from usdsdg.stage.changes import Changes
from usdsdg.stage.semantics.label_schemas import PREFIXES

# What decides which material a gprim shows: relationships to materials, and collections of prims that bind one.
_BINDINGS = ("material:binding", "collection:")
_PROTOTYPES = "prototypes"  # of a point instancer


# The prims that change are mostly those that changed before.
_is_in_prototype = lru_cache(maxsize=1 << 14)(Usd.Prim.IsPathInPrototype)


@dataclass(frozen=True)
class LabeledPrims:
    """One row per labeled prim that owns gprims; more rows where a filter gives a prim a larger group of gprims.

    The renderer computes amodal masks of `groups`.
    """

    prim_paths: tuple[str, ...] = ()
    labels: tuple[Labels, ...] = ()  # own and inherited, outermost first; lower case
    groups: tuple[tuple[int, ...], ...] = ()  # indices into gprims
    # (N, 2, 3) min, max in the prim's frame; none where poses are not read
    bounds: np.ndarray = field(default_factory=lambda: np.zeros((0, 2, 3)))
    local_to_world: np.ndarray = field(default_factory=lambda: np.zeros((0, 4, 4)))  # (N, 4, 4), as bounds
    row_of_gprim: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))  # (G,) row, -1 = unlabeled
    selections: Mapping[str | None, Selection] = field(default_factory=dict)
    gprim_numbers: np.ndarray | None = None  # (G,) int64: of each gprim, the same in all frames; None: its index
    read_keypoints: Callable[[], tuple[KeypointPrim, ...]] = tuple  # reads the prims with keypoints from the stage
    find_skeletons: Callable[[], Sequence[SkeletonPrim]] | None = None  # finds those of the stage; None: not known

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
    gprim_numbers: np.ndarray | None


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
        self._begun: set[str | None] = set()  # filters whose class table has what the graph can show
        self._prims: dict[str | None, StageNumbers] = {}  # by filter
        self._gprims = StageNumbers(stage)
        self._gprims_are_surveyed = False  # as the stage is now
        self._subsets_are_told_apart = False
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
        places: Places | None = None,
    ) -> LabeledPrims:
        """Return the labeled prims that own `gprims` (paths as in the renderer's table), at `time` (default: the
        default time).

        filters: label filters that will be selected from the result. Filters given here are exact for nested labeled
            prims: rows are added for the groups of gprims that they make.
        poses: whether to read bounds and transforms, of which there are none else.
        places: gives the transforms of prims at `time` that are known already, as `WarpRenderer.places`.
        """
        time = Usd.TimeCode.Default() if time is None else time
        owned = self._owned(tuple(gprims), filters, time)
        cache = UsdGeom.XformCache(time)
        frames = PointFrames(self._stage, cache, places)
        bounds, local_to_world = np.zeros((0, 2, 3)), np.zeros((0, 4, 4))
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
            owned.gprim_numbers,
            lambda: self._keypoints.read(owned.gprims, owned.steps, frames, time),
            lambda: self._skeletons.find(owned.gprims, owned.steps),
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
        self._follow(filters, time)
        owned = self._ownership
        if owned is None or owned.gprims != gprims or owned.selections.keys() != self._filters.keys():
            owned = self._ownership = self._assign(gprims)
            self._bounds.divide(gprims)
        return owned

    def survey(self, filters: Iterable[str | None], *, time: Usd.TimeCode) -> None:
        """Number what a frame could show that is not rendered here, as `read` does, so that later ones agree.

        filters: label filters that would be selected from the result.
        """
        self._follow(filters, time)

    def numbers_of(self, gprims: Sequence[str], *, time: Usd.TimeCode) -> np.ndarray:
        """Return the number of each gprim as `read` does, int64 (G,); their indices where ids are not stable."""
        numbers = self._owned(tuple(gprims), (), time).gprim_numbers
        return np.arange(len(gprims)) if numbers is None else numbers

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
            rows, members, output, lasting = [], np.full(len(gprims), -1, np.int32), [], []
            for owned in find_owners(self._labels, gprims, [chain for _, chain in found], label_filter):
                key = owned.owner, owned.group
                if key not in row_of:
                    row_of[key] = len(row_of)
                    labels.append(owned.labels)
                members[list(owned.group)] = len(rows)
                rows.append(row_of[key])
                lasting.append(lasting_name(*owned.owner))
                output.append(owned.output)
            classes, prims = self._tables(predicate)
            selections[predicate] = _selection(classes, prims, np.array(rows, np.int64), members, output, lasting)
            if not rows:
                warn_of_empty_selection(predicate, [labels for _, chain in found for _, labels in chain])
        owners, groups = tuple(owner for owner, _ in row_of), tuple(group for _, group in row_of)
        names = tuple(owner.name for owner in owners)
        steps = [steps for steps, _ in found]
        lasting = [lasting_name(prim_path(gprim), way) if way else gprim for gprim, way in zip(gprims, steps)]
        numbers = self._gprims.table.numbers(lasting) if self._has_tables() else None
        return _Ownership(gprims, steps, owners, names, tuple(labels), groups, selections, numbers)

    def _has_tables(self) -> bool:
        """Return whether ids are those of the session's class tables."""
        return self._for_dataset and ids_are_stable()

    def _tables(self, predicate: str | None) -> tuple[ClassTable | FrameClasses, PrimTable]:
        """Return the tables of a filter."""
        if not self._has_tables():
            return FrameClasses(), PrimTable()
        return current().class_tables.of(predicate), self._prims[predicate].table

    # Numbers

    def _follow(self, filters: Iterable[str | None], time: Usd.TimeCode) -> None:
        """Follow what has changed on the stage until a time, and give ids and numbers to all that it has now."""
        self._invalidate(self._changes.take())
        if time != self._time:
            self._bounds.leave_time()
            self._time = time
            if self._labels.set_time(time):
                self._select_again()
            for each in self._all_numbers():
                each.leave_time()
        # Earlier filters are kept, since render products with different filters alternate. Their order decides that of
        # the rows, and is none of which writer was due first in this process.
        self._filters = dict.fromkeys(sorted({*self._filters, *filters}, key=lambda each: each or ""))
        self._follow_tables()
        if self._has_tables():
            self._number(time)

    def _follow_tables(self) -> None:
        """Assign ids again where the user has changed the classes, or whether ids are stable."""
        version = current().class_tables.version if self._has_tables() else 0
        if version != self._tables_version:
            self._tables_version = version
            self._begun.clear()
            self._select_again()
        if self._subsets_are_told_apart != subsets_are_told_apart():
            self._subsets_are_told_apart = not self._subsets_are_told_apart
            self._survey_again()

    def _survey_again(self) -> None:
        self._gprims_are_surveyed = False
        self._select_again()

    def _select_again(self) -> None:
        self._ownership = None
        self._is_surveyed.clear()

    def _number(self, time: Usd.TimeCode) -> None:
        """Give ids and numbers to what the stage has at a time; to classes at first also to what the graph can show.

        What is in view does not decide, so that processes that render different frames have the same tables.
        """
        missing = [each for each in self._filters if each not in self._is_surveyed]
        if missing or not self._gprims_are_surveyed:
            gprims = self._labels.every_gprim()
            found = self._labels.chains(gprims)
            if not self._gprims_are_surveyed:
                self._gprims.survey((str(prim_path(each)), steps) for each, (steps, _) in zip(gprims, found))
                self._gprims_are_surveyed = True
            for predicate in missing:
                self._survey(predicate, gprims, [chain for _, chain in found])
        for each in self._all_numbers():
            each.number_points(time)

    def _all_numbers(self) -> list[StageNumbers]:
        return [self._gprims, *self._prims.values()]

    def _survey(self, predicate: str | None, gprims: Sequence[str], chains: Sequence[Chain]) -> None:
        """Give ids and numbers to the prims that a filter selects of all gprims on the stage."""
        self._is_surveyed.add(predicate)
        label_filter = parse_filter(predicate)
        found = list(find_owners(self._labels, gprims, chains, label_filter))
        outputs = [each.output for each in found]
        if predicate not in self._begun and (sources := label_sources()):
            outputs += possible_outputs(self._labels, sources, label_filter)
        self._begun.add(predicate)
        current().class_tables.of(predicate).add(outputs)
        prims = self._prims.setdefault(predicate, StageNumbers(self._stage))
        prims.survey((str(each.owner.path), each.owner.steps) for each in found)

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
            self._survey_again()
            self._labels.invalidate(changes.resynced)
        for names, paths in changes.by_names.items():
            if any(name.startswith(PREFIXES) for name in names):
                self._select_again()
                self._labels.invalidate(set(paths))
            elif self._labels.has_labeled_materials and any(name.startswith(_BINDINGS) for name in names):
                self._select_again()
                self._labels.forget_chains()
            elif _PROTOTYPES in names:
                self._survey_again()
                self._labels.forget_chains()
            elif decides_points(names):
                for each in self._all_numbers():
                    each.forget_points()
