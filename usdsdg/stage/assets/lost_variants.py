"""Selections of variants that do not exist, for which USD shows nothing and reports nothing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar
from weakref import WeakKeyDictionary

from pxr import Tf, Usd


class LostVariants:
    """What is to be said of such selections on one stage; its prims are visited again once some were resynced."""

    _of_stages: ClassVar[WeakKeyDictionary[Usd.Stage, LostVariants]] = WeakKeyDictionary()

    def __init__(self, stage: Usd.Stage) -> None:
        self._messages: list[str] | None = None
        # Not a ChangeTracker: it reads the paths of each notice, of which whether any prim was resynced is enough here.
        # pxr holds the method weakly.
        self._listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._note, stage)

    @classmethod
    def messages(cls, stage: Usd.Stage) -> list[str]:
        """Return a message for each selection of a variant that does not exist, so that none is there."""
        known = cls._of_stages.get(stage)
        if known is None:
            known = cls._of_stages[stage] = cls(stage)
        if known._messages is None:
            known._messages = list(_lost(stage))
        return known._messages

    def _note(self, notice: Usd.Notice.ObjectsChanged, sender: Usd.Stage) -> None:
        if notice.GetResyncedPaths():
            self._messages = None


def _lost(stage: Usd.Stage) -> Iterator[str]:
    for prim in stage.Traverse():
        if not prim.HasVariantSets():
            continue
        sets = prim.GetVariantSets()
        for name, selected in sets.GetAllVariantSelections().items():
            there = sets.GetVariantSet(name).GetVariantNames() if sets.HasVariantSet(name) else []
            if selected and there and selected not in there:
                yield (
                    f"{prim.GetPath()}: its variant set {name} has no variant {selected!r}, so nothing of the set is "
                    f"there. Select one of {', '.join(there)}."
                )
