"""Tracking of stage edits: what has changed since a reader last asked."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, ClassVar
from weakref import ReferenceType, WeakKeyDictionary, ref

from pxr import Sdf, Tf, Usd

# Notices that a reader which does not ask keeps apart, before they become one.
KEPT_APART = 64


class Changes:
    """Edits since a reader last asked: subtrees to read again, and properties that changed on other prims.

    Readers share them: they must not be written into.

    resynced: roots of subtrees whose prims, types, references or applied schemas changed; "/" means
        everything. A path may not exist on the stage any more.
    handles: what a reader knows changed properties by, where it said so to `ChangeTracker.take`, instead of names.
    edited: paths of everything else that changed, in no order: mostly properties, also prims of which metadata changed,
        and what is below properties, such as the targets of relationships. Nothing below `resynced` is listed.
    """

    def __init__(
        self,
        resynced: Iterable[Sdf.Path] = (),
        handles: Sequence[Any] = (),
        edited: Sequence[Sdf.Path] = (),
        *,
        named: Sequence[Sdf.Path] | None = None,
        resynced_edits: Sequence[Sdf.Path] = (),
    ) -> None:
        """`named` are those of `edited` without a handle; None: all."""
        self.resynced = set(resynced)
        self.handles = handles
        self.edited = edited
        self._named = edited if named is None else named
        self.resynced_edits = resynced_edits

    def __bool__(self) -> bool:
        return bool(self.resynced or self.edited)

    def without_resynced(self) -> Changes:
        """The same without the subtrees to read again."""
        return Changes((), self.handles, self.edited, named=self._named)

    # Most readers know from the paths that nothing concerns them, so what is derived from these waits until asked for.

    @cached_property
    def changed(self) -> dict[Sdf.Path, set[str]]:
        """Prim path -> names of attributes and relationships that were set, added or removed, without a handle.

        An empty set means metadata only; "/" is the stage's own (metersPerUnit, upAxis).
        """
        return _names_by_prim(self._named)

    @cached_property
    def changed_below_resynced(self) -> dict[Sdf.Path, set[str]]:
        """The same as `changed` of `resynced_edits`."""
        return _names_by_prim(self.resynced_edits)

    @cached_property
    def properties(self) -> Sequence[Sdf.Path]:
        """Paths of all properties that were set, added or removed, also of those with a handle."""
        if all(map(Sdf.Path.IsPrimPropertyPath, self.edited)):  # as mostly, and told in a fifth of the time
            return self.edited
        return [path for _, path, _ in map(_parts, self.edited) if path is not None]

    @cached_property
    def by_names(self) -> dict[frozenset[str], list[Sdf.Path]]:
        """The prims of `changed` by the names that changed on them.

        A simulation or a randomizer changes the same few properties of many prims, so that readers need to decide only
        once for each group whether it concerns them.
        """
        groups: dict[frozenset[str], list[Sdf.Path]] = {}
        for path, names in self.changed.items():
            groups.setdefault(frozenset(names), []).append(path)
        return groups


@dataclass(eq=False)
class _Edits:
    """Raw paths of one notice, or of several; they are sorted out when a reader asks."""

    changed: Iterable[Sdf.Path]
    resynced: Iterable[Sdf.Path]
    reapplied: Iterable[Sdf.Path]  # prims of which only the applied schemas changed


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

    def take(
        self, *, is_relevant: Callable[[Sdf.Path], bool] | None = None, handles: Mapping[Sdf.Path, Any] | None = None
    ) -> Changes:
        """Return the edits since the last call.

        Args:
            is_relevant: whether a prim of which only the applied schemas changed is listed in `resynced`; None for all.
            handles: what properties are reported as, in `Changes.handles`, and not None; unused if anything is
                `resynced`.
        """
        edits, self._edits = self._edits, []
        if not edits:
            return Changes()
        if is_relevant is None and not handles and self._source is not None:
            return self._source.sorted_out(edits)
        return _sorted_out(*_united(edits), is_relevant, handles)

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
    handles: Mapping[Sdf.Path, Any] | None = None,
) -> Changes:
    """Return edits as `ChangeTracker.take` does."""
    resynced = resynced | {path for path in reapplied if is_relevant is None or is_relevant(path)}
    prims = {path for path in resynced if path.IsAbsoluteRootOrPrimPath()}
    roots = set(Sdf.Path.RemoveDescendentPaths(sorted(prims))) if prims else set()
    edited = list(changed if resynced <= prims else changed | resynced - prims)
    if roots:
        below = {path for path in edited if is_below(_parts(path)[0], roots)}
        return Changes(roots, (), [path for path in edited if path not in below], resynced_edits=list(below))
    if not handles:
        return Changes((), (), edited)
    found = list(map(handles.get, edited))
    if None not in found:
        return Changes((), found, edited, named=())
    named = [path for path, handle in zip(edited, found) if handle is None]
    return Changes((), [handle for handle in found if handle is not None], edited, named=named)


class _Notices:
    """The listener to one stage, which its trackers share: reading the paths of a notice is most of what it costs."""

    _of_stages: ClassVar[WeakKeyDictionary[Usd.Stage, ReferenceType[_Notices]]] = WeakKeyDictionary()

    def __init__(self, stage: Usd.Stage) -> None:
        self._readers: list[ReferenceType[ChangeTracker]] = []
        # The last ones that a reader asked for: notices, the paths of them, and what these are.
        self._asked: tuple[list[_Edits], _Paths, Changes] = [], (set(), set(), set()), Changes()
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
        """Return edits as changes.

        Readers that ask one after the other mostly have the same ones, and frame by frame the same properties change.
        """
        known, before, changes = self._asked
        if edits != known:
            paths = _united(edits)
            if paths != before:
                changes = _sorted_out(*paths)
            self._asked = edits, paths, changes
        return changes

    def _read(self, notice: Usd.Notice.ObjectsChanged, sender: Usd.Stage) -> None:
        readers = [reader for known in self._readers if (reader := known()) is not None and not reader.is_muted]
        if not readers:
            return  # reading its paths is most of what a notice costs, and a physics step changes a thousand of them
        resynced = list(notice.GetResolvedAssetPathsResyncedPaths())
        reapplied: list[Sdf.Path] = []
        for path in notice.GetResyncedPaths():
            (reapplied if notice.GetChangedFields(path) == ["apiSchemas"] else resynced).append(path)
        edits = _Edits(notice.GetChangedInfoOnlyPaths(), resynced, reapplied)
        for reader in readers:
            reader.record(edits)


def _names_by_prim(paths: Iterable[Sdf.Path]) -> dict[Sdf.Path, set[str]]:
    by_prim: dict[Sdf.Path, set[str]] = {}
    for prim, path, name in map(_parts, paths):
        names = by_prim.setdefault(prim, set())
        if path is not None:
            names.add(name)
    return by_prim


def is_below(path: Sdf.Path, roots: Collection[Sdf.Path]) -> bool:
    """Return whether a prim path is one of `roots` or below one."""
    if len(roots) < 8:
        return any(map(path.HasPrefix, roots))
    return Sdf.Path.absoluteRootPath in roots or any(prefix in roots for prefix in path.GetPrefixes())


# The properties that change are mostly those that changed before; pxr takes microseconds to take a path apart.
@lru_cache(maxsize=1 << 16)
def _parts(path: Sdf.Path) -> tuple[Sdf.Path, Sdf.Path | None, str]:
    """Return the prim, property and name of the property of a path; None and "" for that of a prim.

    Below a property, such as at a relationship's target, it is that property.
    """
    if path.IsAbsoluteRootOrPrimPath():
        return path, None, ""
    while not path.IsPrimPropertyPath() and path.GetParentPath().ContainsPropertyElements():
        path = path.GetParentPath()
    return path.GetPrimPath(), path, path.name
