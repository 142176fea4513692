"""What has changed on a stage since a reader last asked."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from functools import cached_property, lru_cache
from typing import Any

from pxr import Sdf

from usdsdg.stage.prims.handles import Handles


class Changes:
    """Edits since a reader last asked: subtrees to read again, and properties that changed on other prims.

    Readers share them: they must not be written into.

    resynced: roots of subtrees whose prims, types, references or applied schemas changed; "/" means
        everything. A path may not exist on the stage any more.
    handles: what a reader knows changed properties by, where it said so to `ChangeTracker.take`, instead of names.
    edited: paths of everything else that changed, in no order: mostly properties, also prims of which metadata changed,
        and what is below properties, such as the targets of relationships. Nothing below `resynced` is listed.
    recomposed: those of `edited` that are properties of which other layers have opinions than before, so that a value
        may come from elsewhere.

    Mostly the same properties change from frame to frame. Readers get the same object then, and derive from it once.
    """

    def __init__(
        self,
        resynced: Iterable[Sdf.Path] = (),
        handles: Sequence[Any] = (),
        edited: Sequence[Sdf.Path] = (),
        *,
        named: Sequence[Sdf.Path] | None = None,
        resynced_edits: Sequence[Sdf.Path] = (),
        recomposed: Collection[Sdf.Path] = (),
    ) -> None:
        """`named` are those of `edited` without a handle; None: all."""
        self.resynced = set(resynced)
        self.handles = handles
        self.edited = edited
        self._named = edited if named is None else named
        self.resynced_edits = resynced_edits
        self.recomposed = recomposed
        self._with_handles: tuple[Handles, int, Changes] | None = None  # for which contents of which handles

    def __bool__(self) -> bool:
        return bool(self.resynced or self.edited)

    def without_resynced(self) -> Changes:
        """The same without the subtrees to read again."""
        return Changes((), self.handles, self.edited, named=self._named, recomposed=self.recomposed)

    def with_handles(self, handles: Handles) -> Changes:
        """The same with properties by their handles, if nothing is `resynced`; those that are `recomposed` by names."""
        if self.resynced or not handles:
            return self
        if self._with_handles is None or self._with_handles[:2] != (handles, handles.version):
            found = list(map(handles.get, self.edited))
            if self.recomposed:
                found = [None if path in self.recomposed else each for path, each in zip(self.edited, found)]
            named = [path for path, handle in zip(self.edited, found) if handle is None] if None in found else ()
            known = [handle for handle in found if handle is not None] if named else found
            changes = Changes((), known, self.edited, named=named, recomposed=self.recomposed)
            self._with_handles = handles, handles.version, changes
        return self._with_handles[2]

    # Most readers know from the paths that nothing concerns them, so what is derived from these waits until asked for.

    @cached_property
    def changed(self) -> dict[Sdf.Path, set[str]]:
        """Prim path -> names of attributes and relationships that were set, added or removed, without a handle.

        An empty set means metadata only, see `metadata`; "/" is the stage's own (metersPerUnit, upAxis).
        """
        return _names_by_prim(self._named)

    @cached_property
    def metadata(self) -> frozenset[Sdf.Path]:
        """Prims of which metadata changed, whether or not properties did, too."""
        if self.properties is self.edited:  # as mostly
            return frozenset()
        return frozenset(path for path in self.edited if path.IsAbsoluteRootOrPrimPath())

    @cached_property
    def changed_below_resynced(self) -> dict[Sdf.Path, set[str]]:
        """The same as `changed` of `resynced_edits`."""
        return _names_by_prim(self.resynced_edits)

    @cached_property
    def properties(self) -> Sequence[Sdf.Path]:
        """Paths of all properties that were set, added or removed, also of those with a handle."""
        if all(map(Sdf.Path.IsPrimPropertyPath, self.edited)):  # as mostly, and told in a fifth of the time
            return self.edited
        return [path for _, path, _ in map(parts_of, self.edited) if path is not None]

    @cached_property
    def handles_by_type(self) -> dict[type, list[Any]]:
        """`handles` by their type."""
        groups: dict[type, list[Any]] = {}
        for handle in self.handles:
            groups.setdefault(type(handle), []).append(handle)
        return groups

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


def _names_by_prim(paths: Iterable[Sdf.Path]) -> dict[Sdf.Path, set[str]]:
    by_prim: dict[Sdf.Path, set[str]] = {}
    for prim, path, name in map(parts_of, paths):
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
def parts_of(path: Sdf.Path) -> tuple[Sdf.Path, Sdf.Path | None, str]:
    """Return the prim, property and name of the property of a path; None and "" for that of a prim.

    Below a property, such as at a relationship's target, it is that property.
    """
    if path.IsAbsoluteRootOrPrimPath():
        return path, None, ""
    while not path.IsPrimPropertyPath() and path.GetParentPath().ContainsPropertyElements():
        path = path.GetParentPath()
    return path.GetPrimPath(), path, path.name
