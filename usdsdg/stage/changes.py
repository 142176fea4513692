"""What changed on a stage since a reader last asked."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from pxr import Sdf, Tf, Usd


@dataclass(frozen=True)
class Changes:
    """Paths as a reader needs them: read `resynced` subtrees anew, and of the rest only the named properties.

    resynced: roots of subtrees whose prims, types, references or applied schemas changed; "/" means
        everything. A path may be gone from the stage by now.
    changed: prim path -> names of attributes and relationships that were set, added or removed. An empty set
        means metadata only; "/" stands for the stage's own (metersPerUnit, upAxis). Nothing below `resynced`
        is listed.
    known: instead of names, the reader's own numbers of properties that it knows, see `ChangeTracker.take`.
    properties: paths of all properties that were set, added or removed.
    """

    resynced: set[Sdf.Path] = field(default_factory=set)
    changed: dict[Sdf.Path, set[str]] = field(default_factory=dict)
    known: list[int] = field(default_factory=list)
    properties: list[Sdf.Path] = field(default_factory=list, compare=False)

    def __bool__(self) -> bool:
        return bool(self.resynced or self.changed or self.known)


class ChangeTracker:
    """Listens to one stage for one reader. Each reader has its own, and muting it leaves the others alone."""

    def __init__(self, stage: Usd.Stage) -> None:
        # Sets of raw paths: a notice costs one union here, and paths are sorted out only when somebody asks.
        self._resynced: set[Sdf.Path] = set()
        self._changed: set[Sdf.Path] = set()
        self._reapplied: set[Sdf.Path] = set()  # prims of which the applied schemas alone changed
        self._muted = 0
        # pxr holds the method weakly, so that a forgotten tracker dies and its listener with it.
        self._listener: Tf.Notice.Listener | None = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._hear, stage)

    def take(
        self, *, matters: Callable[[Sdf.Path], bool] | None = None, known: Mapping[Sdf.Path, int] | None = None
    ) -> Changes:
        """Everything since the last call; the next call starts from here.

        Args:
            matters: asked of prims that got or lost applied schemas and nothing else; those of which it says no are
                left out. None: all are `resynced`.
            known: numbers of properties of which it is enough to hear that they changed. It is not asked where
                anything is `resynced`.
        """
        resynced, changed, reapplied = self._resynced, self._changed, self._reapplied
        self._resynced, self._changed, self._reapplied = set(), set(), set()
        resynced |= {path for path in reapplied if matters is None or matters(path)}
        prims = {path for path in resynced if path.IsAbsoluteRootOrPrimPath()}
        roots = set(Sdf.Path.RemoveDescendentPaths(sorted(prims)))
        told = list(changed | (resynced - prims))
        numbers = list(map(known.get, told)) if known and not roots else [None] * len(told)
        by_prim: dict[Sdf.Path, set[str]] = {}
        properties = []
        for path, number in zip(told, numbers):
            if number is None:
                prim = path if path.IsAbsoluteRootOrPrimPath() else path.GetPrimPath()
                if roots and _has_prefix(prim, roots):
                    continue
                names = by_prim.setdefault(prim, set())
                if prim is path:
                    continue
                path = path if path.IsPrimPropertyPath() else _property_of(path)
                names.add(path.name)
            properties.append(path)
        return Changes(roots, by_prim, [number for number in numbers if number is not None], properties)

    @contextmanager
    def muted(self) -> Iterator[None]:
        """Do not record what happens inside: a reader's own writes are no news to it.

        Wrap the whole `Sdf.ChangeBlock`, because its notices are sent when it ends.
        """
        self._muted += 1
        try:
            yield
        finally:
            self._muted -= 1

    def close(self) -> None:
        """Stop listening; what was recorded can still be taken."""
        if self._listener is not None:
            self._listener.Revoke()
            self._listener = None

    def _hear(self, notice: Usd.Notice.ObjectsChanged, sender: Usd.Stage) -> None:
        if self._muted:
            return
        self._changed.update(notice.GetChangedInfoOnlyPaths())
        for path in notice.GetResyncedPaths():
            (self._reapplied if notice.GetChangedFields(path) == ["apiSchemas"] else self._resynced).add(path)
        if resolved := notice.GetResolvedAssetPathsResyncedPaths():
            self._resynced.update(resolved)


def _has_prefix(path: Sdf.Path, roots: set[Sdf.Path]) -> bool:
    while path not in roots:
        if path == Sdf.Path.absoluteRootPath or path.isEmpty:
            return False
        path = path.GetParentPath()
    return True


def _property_of(path: Sdf.Path) -> Sdf.Path:
    """The property of a path that goes deeper, as a relationship's target does."""
    while not path.IsPrimPropertyPath() and path.GetParentPath().ContainsPropertyElements():
        path = path.GetParentPath()
    return path
