"""The listener to a stage's notices, and the readers of what these say has changed."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain
from typing import ClassVar
from weakref import ReferenceType, WeakKeyDictionary, ref

from pxr import Sdf, Tf, Usd

from usdsdg.stage.changes import Changes, is_below, parts_of
from usdsdg.stage.prims.handles import Handles

# Notices that a reader which does not ask keeps apart, before they become one.
KEPT_APART = 64
# Lists of paths, and changes, that a listener keeps to know them again. Frames need a few of each.
MOST_KNOWN = 64


@dataclass(eq=False)
class _Edits:
    """Raw paths of one notice, or of several; they are sorted out when a reader asks."""

    changed: Iterable[Sdf.Path]  # of one notice the list that others with these paths have
    resynced: Iterable[Sdf.Path]
    reapplied: Iterable[Sdf.Path]  # prims that got or lost schemas within `schemas_only`


_within = threading.local()  # schemas_only: how many of these contexts this thread is in


@contextmanager
def schemas_only() -> Iterator[None]:
    """Say that nothing is edited within the context but which schemas prims have, and properties of these schemas.

    A notice of a prim that gets a schema is the same whether or not values, prims or their order changed with it, at
    the prim or below, as within one `Sdf.ChangeBlock` or where a layer was cleared. So also readers that do not care
    for a schema read again all that is at and below the prim, unless the edit was made here.

    The notice of a block that encloses the context is sent after it, and is none of the context.
    """
    _within.schemas_only = getattr(_within, "schemas_only", 0) + 1
    try:
        yield
    finally:
        _within.schemas_only -= 1


class ChangeTracker:
    """Records the edits of one stage for one reader; each reader has its own tracker, which it can mute."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._edits: list[_Edits] = []
        self._muted = 0
        self._source: _Notices | None = _Notices.of(stage)
        self._source.add(self)

    @property
    def is_empty(self) -> bool:
        """Whether nothing was edited since the last `take`."""
        return not self._edits

    def take(self, *, is_relevant: Callable[[Sdf.Path], bool] | None = None, handles: Handles | None = None) -> Changes:
        """Return the edits since the last call.

        Args:
            is_relevant: whether a prim that got or lost schemas within `schemas_only` is listed in `resynced`; None
                for all.
            handles: what properties are reported as, in `Changes.handles`, and not None; unused if anything is
                `resynced`.
        """
        edits, self._edits = self._edits, []
        if not edits:
            return Changes()
        if self._source is None or (is_relevant is not None and any(each.reapplied for each in edits)):
            changes = _sorted_out(*_united(edits), is_relevant)
        else:
            changes = self._source.sorted_out(edits)
        return changes if handles is None else changes.with_handles(handles)

    @contextmanager
    def muted(self) -> Iterator[None]:
        """Ignore edits within the context, such as the reader's own.

        It must enclose the whole `Sdf.ChangeBlock`, which sends its notices at its end.
        """
        self._muted += 1
        try:
            yield
        finally:
            self._muted -= 1

    def close(self) -> None:
        """Stop listening; what was recorded can still be taken."""
        if self._source is not None:
            self._source.remove(self)
            self._source = None

    @property
    def is_muted(self) -> bool:
        """Whether edits are ignored now."""
        return self._muted > 0

    def record(self, edits: _Edits) -> None:
        """Add the paths of one notice."""
        self._edits.append(edits)
        if len(self._edits) > KEPT_APART:
            self._edits = [_Edits(*_united(self._edits))]


_Paths = tuple[set[Sdf.Path], set[Sdf.Path], set[Sdf.Path]]


def _united(edits: Sequence[_Edits]) -> _Paths:
    """Return the changed, the resynced and the reapplied paths of several notices.

    Sets are those of notices that one reader has united before; they are added to.
    """
    first = edits[0]
    changed, resynced, reapplied = (
        paths if isinstance(paths, set) else set(paths) for paths in (first.changed, first.resynced, first.reapplied)
    )
    for each in edits[1:]:
        changed.update(each.changed)
        resynced.update(each.resynced)
        reapplied.update(each.reapplied)
    return changed, resynced, reapplied


def _sorted_out(
    changed: set[Sdf.Path],
    resynced: set[Sdf.Path],
    reapplied: set[Sdf.Path],
    is_relevant: Callable[[Sdf.Path], bool] | None = None,
) -> Changes:
    """Return edits as `ChangeTracker.take` does."""
    resynced = resynced | {path for path in reapplied if is_relevant is None or is_relevant(path)}
    prims = {path for path in resynced if path.IsAbsoluteRootOrPrimPath()}
    roots = set(Sdf.Path.RemoveDescendentPaths(sorted(prims))) if prims else set()
    recomposed = resynced - prims
    edited = list(changed | recomposed if recomposed else changed)
    if not roots:
        return Changes((), (), edited, recomposed=recomposed)
    below = {path for path in edited if is_below(parts_of(path)[0], roots)}
    kept = [path for path in edited if path not in below]
    return Changes(roots, (), kept, resynced_edits=list(below), recomposed=recomposed - below)


class _Notices:
    """The listener to one stage, which its trackers share: reading the paths of a notice is most of what it costs."""

    _of_stages: ClassVar[WeakKeyDictionary[Usd.Stage, ReferenceType[_Notices]]] = WeakKeyDictionary()

    def __init__(self, stage: Usd.Stage) -> None:
        self._readers: list[ReferenceType[ChangeTracker]] = []
        self._lists: dict[tuple[int, Sdf.Path, Sdf.Path], list[Sdf.Path]] = {}  # by length and ends
        # Changes by the ids of the lists of their notices, which they keep alive.
        self._known: dict[tuple[int, ...], tuple[list[list[Sdf.Path]], Changes]] = {}
        self._asked: tuple[list[_Edits], Changes] = [], Changes()  # the last that were asked for beside those
        # pxr holds the method weakly, so that the listener ends with the last tracker.
        self._listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._read, stage)

    @classmethod
    def of(cls, stage: Usd.Stage) -> _Notices:
        """Return the listener to a stage, a new one if no tracker has it."""
        known = cls._of_stages.get(stage)
        found = None if known is None else known()
        if found is None:
            found = cls(stage)
            cls._of_stages[stage] = ref(found)
        return found

    def add(self, reader: ChangeTracker) -> None:
        self._readers = [ref(reader), *(known for known in self._readers if known() is not None)]

    def remove(self, reader: ChangeTracker) -> None:
        self._readers = [known for known in self._readers if known() is not reader]

    def sorted_out(self, edits: list[_Edits]) -> Changes:
        """Return edits as changes: the same for readers that ask one after the other, and from frame to frame."""
        lists = [each.changed for each in edits if isinstance(each.changed, list)]
        if len(lists) < len(edits) or any(each.resynced or each.reapplied for each in edits):
            if edits != self._asked[0]:
                self._asked = edits, _sorted_out(*_united(edits))
            return self._asked[1]
        key = tuple(map(id, lists))
        if key not in self._known:
            paths = lists[0] if len(lists) == 1 else list(dict.fromkeys(chain.from_iterable(lists)))
            _bound(self._known)
            self._known[key] = lists, Changes((), (), paths)
        return self._known[key][1]

    def _one_list(self, paths: list[Sdf.Path]) -> list[Sdf.Path]:
        """Return the list that an earlier notice had of the same paths in the same order, if there is one."""
        if not paths:
            return paths
        key = len(paths), paths[0], paths[-1]
        known = self._lists.get(key)
        if known is None or known != paths:
            _bound(self._lists)
            known = self._lists[key] = paths
        return known

    def _read(self, notice: Usd.Notice.ObjectsChanged, sender: Usd.Stage) -> None:
        readers = [reader for known in self._readers if (reader := known()) is not None and not reader.is_muted]
        if not readers:
            return  # reading its paths is most of what a notice costs, and a physics step changes a thousand of them
        changed, resynced = notice.GetChangedInfoOnlyPaths(), list(notice.GetResolvedAssetPathsResyncedPaths())
        reapplied: list[Sdf.Path] = []
        if found := notice.GetResyncedPaths():
            are_schemas = getattr(_within, "schemas_only", 0) > 0
            for path in found:
                (reapplied if are_schemas and path.IsPrimPath() else resynced).append(path)
        edits = _Edits(self._one_list(changed), resynced, reapplied)
        for reader in readers:
            reader.record(edits)


def _bound(known: dict) -> None:
    """Empty a dictionary of what is known before it grows without end."""
    if len(known) >= MOST_KNOWN:
        known.clear()
