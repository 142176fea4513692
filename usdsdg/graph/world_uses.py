"""What nodes read and write in worlds, and whether one call of each, in their order, gives what frames would show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pxr import Sdf

from usdsdg.stage.world_values import WorldValues

Attributes = frozenset[tuple[Sdf.Path, str]]


@dataclass(frozen=True)
class _Use:
    cadence: Any  # equal for nodes that run in the same frames
    is_steady: bool  # runs in every frame
    reads: Attributes
    writes: Attributes


class WorldUses:
    """The uses of values by nodes, in the order in which they run.

    Attributes:
        are_in_order: whether each node reads what those before it write in the same frames, and none writes what
            another one writes in other frames.
    """

    def __init__(self) -> None:
        self.are_in_order = True
        self._uses: list[_Use] = []

    def note(self, cadence: Any, values: WorldValues, *, is_steady: bool) -> None:
        """Note what a node has read and written since the last one.

        cadence: equal for nodes that run in the same frames. is_steady: whether it runs in every frame.
        """
        use = _Use(cadence, is_steady, *values.take_uses())
        for earlier in self._uses:
            same = earlier.cadence == use.cadence
            if earlier.reads & use.writes or (not same and earlier.writes & (use.writes | use.reads)):
                self.are_in_order = False
        self._uses.append(use)

    def steady(self) -> Attributes:
        """Return the attributes that every frame writes anew."""
        of_all, of_some = (
            frozenset[tuple[Sdf.Path, str]]().union(*(use.writes for use in self._uses if use.is_steady == is_steady))
            for is_steady in (True, False)
        )
        return of_all - of_some
