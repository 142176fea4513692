"""All labeled prims of a stage, in view or not: for writers whose files must not depend on what was seen first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.annotators.ownership import LabeledStage, Labels, Owner, find_owners, parse_filter
from usdsdg.annotators.point_instances import PointFrames, every_point
from usdsdg.stage.change_tracker import ChangeTracker
from usdsdg.stage.changes import Changes
from usdsdg.stage.semantics.label_schemas import PREFIXES
from usdsdg.stage.time_code import first_time

_POINTS = {"positions", "protoIndices", "ids", "prototypes", "invisibleIds"}


class SurveyedPrim(NamedTuple):
    """A labeled prim."""

    name: str  # prim path, as annotators report it
    labels: dict[str, str]  # {type: "label[,label]"}, as annotators output them
    local_to_world: np.ndarray  # (4, 4), row vectors, when the stage begins


class LabeledSurvey:
    """Reads the labeled prims that own gprims under a label filter, in the order of the stage, in view or not.

    Hidden ones are left out: a pool of things that wait to be shown may have any scale until then.
    """

    def __init__(self, stage: Usd.Stage, predicate: str | None) -> None:
        self.stage = stage
        self._filter = parse_filter(predicate)
        self._changes, self._labels = ChangeTracker(stage), LabeledStage(stage)
        self._owners: list[tuple[Owner, dict[str, str]]] | None = None

    def read(self) -> Iterator[SurveyedPrim]:
        """Yield the labeled prims as they are now."""
        if _matters(self._changes.take()):
            self._labels.invalidate()
            self._owners = None
        if self._owners is None:
            self._owners = list(self._find())
        frames = PointFrames(self.stage, UsdGeom.XformCache(first_time(self.stage)))
        for owner, labels in self._owners:
            if _is_hidden(self.stage, owner):
                continue
            yield SurveyedPrim(owner.name, labels, frames.to_world(owner.path, owner.steps))

    def has_own_labels(self, prim: Usd.Prim) -> bool:
        """Return whether labels of the prim itself pass the filter."""
        return self._passes(self._labels.own_labels(prim.GetPath()))

    def owners_of(self, gprims: Sequence[str]) -> list[Sdf.Path | None]:
        """Return the labeled prim to which each gprim belongs, by its path; None where no label passes the filter."""
        chains = [chain for _, chain in self._labels.chains(gprims)]
        return [next((owner.path for owner, own in chain if self._passes(own)), None) for chain in chains]

    def _passes(self, labels: Labels) -> bool:
        return bool(labels if self._filter is None else self._filter.select(labels))

    def _find(self) -> Iterator[tuple[Owner, dict[str, str]]]:
        gprims = every_point(self.stage, self._labels.every_gprim(numbered=False), first_time(self.stage))
        chains = [chain for _, chain in self._labels.chains(gprims)]
        for owned in find_owners(self._labels, gprims, chains, self._filter):
            yield owned.owner, owned.output


def _is_hidden(stage: Usd.Stage, owner: Owner) -> bool:
    """Return whether a labeled prim is hidden; that of a point instance by what is in its prototype, and the instancer.

    What prototypes are in may be hidden, so that they are not drawn by themselves.
    """
    if not owner.steps:
        prim = UsdGeom.Imageable(stage.GetPrimAtPath(owner.path))
        return bool(prim) and prim.ComputeVisibility() == UsdGeom.Tokens.invisible
    step, *outer = owner.steps
    for path in owner.path.GetPrefixes()[step.prototype.pathElementCount - 1 :]:
        visibility = stage.GetPrimAtPath(path).GetAttribute("visibility")
        if visibility and visibility.Get() == UsdGeom.Tokens.invisible:
            return True
    return _is_hidden(stage, Owner(step.instancer, tuple(outer)))


def _matters(changes: Changes) -> bool:
    """Return whether other prims may have labels, or others."""
    names = (name for names in changes.by_names for name in names)
    return bool(changes.resynced) or any(
        name in _POINTS or name.startswith((*PREFIXES, "material:binding", "collection:")) for name in names
    )
