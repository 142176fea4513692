"""What it takes to render a frame again: the stage at some frame, and what has changed since then."""

from __future__ import annotations

import gzip
import os
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from pxr import Sdf, Usd

from usdsdg.annotators.prims.subset_setting import SETTING as SUBSETS
from usdsdg.capture.records.edits_text import Edit, edits_text
from usdsdg.capture.render_settings import glass_labels
from usdsdg.record import STAGES
from usdsdg.session.settings.store import get_settings
from usdsdg.stage import flatten
from usdsdg.stage.assets import anchors
from usdsdg.stage.change_tracker import ChangeTracker
from usdsdg.stage.changes import Changes
from usdsdg.stage.time_code import values_at
from usdsdg.stage.world_values import WorldValues

SETTING = "/usdsdg/labels/recordStage"
# Layers on disk that were edited are copied up to this size; a stage that is larger has no stage record [bytes].
LARGEST = 32 << 20
# Where prims come and go in every frame, the stage is copied at so many of them at first, then at one in so many.
FREELY, EVERY = 8, 50
# Prims that no label depends on.
_IGNORED = tuple(map(Sdf.Path, ("/Render", "/Replicator/SDGPipeline", "/OmniverseKit_Persp")))
_IGNORED_NAMES = ("inputs:", "outputs:", "info:", "primvars:displayColor", "physics:", "drive:", "state:", "ui:")
# Parts of names of inputs on which it depends what rays meet, and the relationships that do so.
_OPACITY = ("opacity", "cutout", "alpha", "transmission")
_BINDINGS = "material:binding"
_NO_FOLDER = Path("/nonexistent")  # from which no relative path leads to an asset, so that all become absolute


@dataclass(frozen=True)
class StageMoment:
    """The stage at one capture."""

    base: str  # path of the file of the stage below the output folder
    content: bytes  # of that file
    edits: tuple[Edit, ...]  # what has changed since
    facts: dict[str, Any]  # time code, and settings on which labels depend

    @cached_property
    def layer(self) -> bytes:
        """The edits as the text of a layer, with portable paths of assets."""
        return anchors.portable(edits_text.of(self.edits)).encode()


class StageRecords:
    """Follows one stage."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._tracker = ChangeTracker(stage)
        self._base: tuple[str, bytes] | None = None
        self._captures = self._copies = 0
        # Since the base: attributes and their types, relationships and None.
        self._changed: dict[Sdf.Path, tuple[Usd.Property, Any]] = {}
        self._in_order: list[tuple[Sdf.Path, Any, Any]] | None = None  # of them; None: not known
        self._noted: dict[Sdf.Path, set[str]] = {}  # names by prim that were looked at since the base
        self._seen: set[Sdf.Path] = set()  # paths that were looked at since the base

    def take(self, time: Usd.TimeCode) -> StageMoment | None:
        """Return the stage as it is now; None where it is not recorded."""
        self.follow()
        if self._base is None:
            return None
        if self._in_order is None:
            # Sorted, since changes come in an order that differs from process to process.
            self._in_order = [(path, kind, each) for path, (each, kind) in sorted(self._changed.items())]
        edits = _values(self._in_order, time)
        facts = {
            "time": None if time.IsDefault() else time.GetValue(),
            "glass": glass_labels(),
            "subsets": get_settings().get_as_bool(SUBSETS),
        }
        return StageMoment(*self._base, edits, facts)

    def follow(self) -> None:
        """Take note of what has changed until this capture."""
        if not get_settings().get_as_bool(SETTING):
            self._base = None
            return
        changes, self._captures = self._tracker.take(), self._captures + 1
        if self._base is None or any(_matters(path) for path in changes.resynced):
            may_copy = self._copies < FREELY + self._captures // EVERY
            self._base = _base(self._stage) if may_copy else None
            self._changed, self._in_order, self._noted, self._seen = {}, None, {}, set()
            self._copies += self._base is not None
        else:
            self._note(changes)

    def follow_unseen(self, values: WorldValues) -> bool:
        """Take note of what the next captures change, which are passed over; return whether later ones may change more.

        values: what they show, after the capture that was looked at last.
        """
        if self._base is None:
            return False
        may_change = False
        for prim, columns in values.values.items():
            for name in filter(_decides_labels, columns if _matters(prim) else ()):
                path, column = prim.AppendProperty(name), columns[name]
                if path not in self._changed and (column[1:] != column[:1]).any():
                    self._add(path)
                may_change |= path not in self._changed
        return may_change

    def pass_over(self) -> None:
        """Count a capture of which `follow_unseen` was told."""
        self._captures += 1

    def _note(self, changes: Changes) -> None:
        # Frame by frame the same properties change.
        if self._seen.issuperset(changes.edited):
            return
        self._seen.update(changes.edited)
        for prim, names in changes.changed.items():
            noted = self._noted.get(prim)
            if noted is not None and names <= noted:
                continue
            # What instances share is edited where it stands. With overs of their prototypes, USD opens no stage.
            if _matters(prim) and not Usd.Prim.IsPathInPrototype(prim):
                for name in sorted(filter(_decides_labels, names)):
                    self._add(prim.AppendProperty(name))
            self._noted[prim] = names if noted is None else noted | names

    def _add(self, path: Sdf.Path) -> None:
        """Let records have a property."""
        if path in self._changed:
            return
        if attribute := self._stage.GetAttributeAtPath(path):
            self._changed[path], self._in_order = (attribute, attribute.GetTypeName()), None
        elif path.name.startswith(_BINDINGS) and (binding := self._stage.GetRelationshipAtPath(path)):
            self._changed[path], self._in_order = (binding, None), None


def _values(
    properties: Sequence[tuple[Sdf.Path, Any, Any]], time: Usd.TimeCode
) -> tuple[tuple[Sdf.Path, Any, Any], ...]:
    """Return the values of attributes, and the targets of relationships, that are there."""
    try:
        values = _read(properties, time)
    except RuntimeError:  # a prim is gone; to ask each first takes a third of the time
        properties = [each for each in properties if each[2]]
        values = _read(properties, time)
    return tuple((path, kind, value) for (path, kind, _), value in zip(properties, values) if value is not None)


def _read(properties: Sequence[tuple[Sdf.Path, Any, Any]], time: Usd.TimeCode) -> list[Any]:
    values = iter(values_at([each for _, kind, each in properties if kind is not None], time))
    return [each.GetTargets() if kind is None else next(values) for _, kind, each in properties]


def _matters(path: Sdf.Path) -> bool:
    return not path.HasPrefix(_IGNORED[0]) and not any(path.HasPrefix(each) for each in _IGNORED[1:])


def _decides_labels(name: str) -> bool:
    """Return whether labels may depend on the property of a name; the empty name is metadata of the prim."""
    is_opacity = name.startswith("inputs:") and any(part in name.lower() for part in _OPACITY)
    return bool(name) and (is_opacity or not name.startswith(_IGNORED_NAMES))


def _base(stage: Usd.Stage) -> tuple[str, bytes] | None:
    """Return the stage's own layers as one: name and content of the file; None where they are large."""
    on_disk = [layer.realPath for layer in stage.GetLayerStack() if layer.realPath]
    if sum(os.path.getsize(path) for path in on_disk if os.path.isfile(path)) > LARGEST:
        return None
    # As text, since the bytes of a .usdc differ from process to process.
    text = anchors.portable(flatten.flattened(stage, _NO_FOLDER).ExportToString())
    content = gzip.compress(text.encode(), 4, mtime=0)
    return f"{STAGES}/{zlib.crc32(content):08x}.usda.gz", content
