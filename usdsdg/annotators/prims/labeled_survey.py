"""All labeled prims of a stage, in view or not: for writers whose files must not depend on what was seen first."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.annotators.ownership import LabeledStage, Labels, Owner, find_owners, parse_filter
from usdsdg.annotators.point_instances import PointFrames, every_point, points_vary
from usdsdg.stage.change_tracker import ChangeTracker
from usdsdg.stage.changes import Changes
from usdsdg.stage.geometry.drawn_box import DRAWN_PURPOSES
from usdsdg.stage.geometry.point_names import Prototypes
from usdsdg.stage.semantics.label_schemas import PREFIXES
from usdsdg.stage.time_code import first_time

_POINTS = {"positions", "protoIndices", "ids", "prototypes", "invisibleIds"}


class SurveyedPrim(NamedTuple):
    """A labeled prim."""

    name: str  # prim path, as annotators report it
    labels: dict[str, str]  # {type: "label[,label]"}, as annotators output them
    local_to_world: np.ndarray  # (4, 4), row vectors


class LabeledSurvey:
    """Reads the labeled prims that own gprims under a label filter, in the order of the stage, in view or not.

    Hidden ones are left out: a pool of things that wait to be shown may have any scale until then.
    """

    def __init__(self, stage: Usd.Stage, predicate: str | None) -> None:
        self.stage = stage
        self._filter = parse_filter(predicate)
        self._changes, self._labels = ChangeTracker(stage), LabeledStage(stage)
        self._owners: list[tuple[Owner, dict[str, str]]] | None = None
        self._found_at: tuple[Usd.TimeCode, Usd.TimeCode] | None = None  # the times of points and of labels
        self._points_vary = False  # whether there may be other points at other times
        self._prototypes: Collection[Sdf.Path] | None = None  # roots of those of point instancers

    def read(self) -> Iterator[SurveyedPrim]:
        """Yield the labeled prims as they are when the stage begins."""
        return self._placed(first_time(self.stage), Usd.TimeCode.Default())

    def read_at(self, time: Usd.TimeCode) -> Iterator[SurveyedPrim]:
        """Yield the labeled prims as they are at a time."""
        return self._placed(time, time)

    def places(self) -> set[Sdf.Path]:
        """Return the labeled prims, hidden or not, and the point instancers that draw some of them."""
        owners = [owner for owner, _ in self._found(first_time(self.stage), Usd.TimeCode.Default())]
        return {owner.path for owner in owners} | {step.instancer for owner in owners for step in owner.steps}

    def _placed(self, time: Usd.TimeCode, shown_at: Usd.TimeCode) -> Iterator[SurveyedPrim]:
        """Yield the prims at a time; shown_at: when their labels count, and whether they are hidden."""
        found = self._found(time, shown_at)
        shown = [(owner, labels) for owner, labels in found if not _is_hidden(self.stage, owner, shown_at)]
        frames = PointFrames(self.stage, UsdGeom.XformCache(time))
        with np.errstate(invalid="ignore"):
            matrices = frames.all_to_world([(owner.path, owner.steps) for owner, _ in shown])
        for (owner, labels), matrix in zip(shown, matrices, strict=True):
            if np.isfinite(matrix).all():  # others are not drawn, and the renderer names them
                yield SurveyedPrim(owner.name, labels, matrix)

    def _found(self, time: Usd.TimeCode, shown_at: Usd.TimeCode) -> list[tuple[Owner, dict[str, str]]]:
        if _matters(self._changes.take()):
            self._labels.invalidate()
            self._owners = self._prototypes = None
        varies = self._labels.set_time(shown_at) or self._points_vary
        if self._owners is None or (varies and self._found_at != (time, shown_at)):
            self._owners, self._found_at = list(self._find(time)), (time, shown_at)
            self._points_vary = points_vary(self.stage)
        return self._owners

    def has_own_labels(self, prim: Usd.Prim) -> bool:
        """Return whether labels of the prim itself pass the filter."""
        return self._passes(self._labels.own_labels(prim.GetPath()))

    def is_drawn_for(self, prim: Usd.Prim) -> bool:
        """Return whether the purpose of a prim is one that is drawn: its own or, up to a prototype, an inherited one.

        What prototypes of point instancers are in has no say in how these draw them.
        """
        if self._prototypes is None:
            self._prototypes = Prototypes(self.stage).users.keys()
        while prim:
            purpose = prim.GetAttribute("purpose")
            if purpose and purpose.HasAuthoredValue():
                return purpose.Get() in DRAWN_PURPOSES
            prim = Usd.Prim() if prim.GetPath() in self._prototypes else prim.GetParent()
        return True

    def owners_of(self, gprims: Sequence[str]) -> list[Sdf.Path | None]:
        """Return the labeled prim to which each gprim belongs, by its path; None where no label passes the filter."""
        chains = [chain for _, chain in self._labels.chains(gprims)]
        return [next((owner.path for owner, own in chain if self._passes(own)), None) for chain in chains]

    def _passes(self, labels: Labels) -> bool:
        return bool(labels if self._filter is None else self._filter.select(labels))

    def _find(self, time: Usd.TimeCode) -> Iterator[tuple[Owner, dict[str, str]]]:
        gprims = every_point(self.stage, self._labels.every_gprim(numbered=False), time)
        chains = [chain for _, chain in self._labels.chains(gprims)]
        for owned in find_owners(self._labels, gprims, chains, self._filter):
            yield owned.owner, owned.output


def _is_hidden(stage: Usd.Stage, owner: Owner, time: Usd.TimeCode) -> bool:
    """Return whether a labeled prim is hidden; that of a point instance by what is in its prototype, and the instancer.

    What prototypes are in may be hidden, so that they are not drawn by themselves.
    """
    if not owner.steps:
        prim = UsdGeom.Imageable(stage.GetPrimAtPath(owner.path))
        return bool(prim) and prim.ComputeVisibility(time) == UsdGeom.Tokens.invisible
    step, *outer = owner.steps
    for path in owner.path.GetPrefixes()[step.prototype.pathElementCount - 1 :]:
        visibility = stage.GetPrimAtPath(path).GetAttribute("visibility")
        if visibility and visibility.Get(time) == UsdGeom.Tokens.invisible:
            return True
    return _is_hidden(stage, Owner(step.instancer, tuple(outer)), time)


def _matters(changes: Changes) -> bool:
    """Return whether other prims may have labels, or others."""
    names = (name for names in changes.by_names for name in names)
    return bool(changes.resynced) or any(
        name in _POINTS or name.startswith((*PREFIXES, "material:binding", "collection:")) for name in names
    )
