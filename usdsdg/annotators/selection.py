"""The labeled prims that pass a label filter, and what is found out about them once, for all frames that show them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from usdsdg.annotators.colors import FIRST_LABELED
from usdsdg.annotators.pixels.look_ups import PIXELS, X_MAX, X_MIN


@dataclass(frozen=True)
class Selection:
    """The labeled prims that pass a label filter, in stage order. It serves all frames until a label changes."""

    rows: np.ndarray  # (K,) int64: rows of the `LabeledPrims`
    member_of_gprim: np.ndarray  # (G,) int32: index into rows, -1 for gprims of no selected prim
    labels: tuple[dict[str, str], ...]  # K times {type: "label[,label]"}, as annotators output them
    class_ids: np.ndarray  # (K,) int64: id of the labels in semantic_segmentation, the same in all frames
    class_labels: Mapping[int, dict[str, str]]  # of each class by id, also of those that no prim has now
    class_colors: Mapping[int, tuple[int, int, int, int]]  # RGBA by id, where the user has given them
    numbers: np.ndarray  # (K,) int64: number of the prim among all labeled prims, the same in all frames
    prim_count: int  # numbers are below this
    memo: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)

    @property
    def ids(self) -> np.ndarray:
        """The ids (K,) of the prims in instance_segmentation."""
        return self.keep("ids", lambda: self.numbers + FIRST_LABELED)

    def __len__(self) -> int:
        return len(self.rows)

    def keep(self, key: Any, make: Callable[[], Any]) -> Any:
        """Return `make()`, computed once per selection and `key`."""
        if key not in self.memo:
            self.memo[key] = make()
        return self.memo[key]

    def sum_members(self, sums: np.ndarray) -> np.ndarray:
        """Return visible pixels and their bounds of each prim from those of the gprims, of N pictures at once.

        sums: (N, G, 5) int64, as `Frame.sums`. Returns (N, K, 5) int64, with bounds of -1 for no pixels.
        """
        owned, starts, members = self.keep("owned gprims", self._owned_gprims)
        found = np.full((len(sums), len(self), 5), -1, np.int64)
        found[..., PIXELS] = 0
        if not len(owned):
            return found
        of_gprims = sums[:, owned]
        # What is not seen has bounds of -1, which must not count as the least.
        unseen = of_gprims[..., PIXELS] == 0
        of_gprims[unseen, X_MIN:X_MAX] = np.iinfo(np.int64).max
        merged = np.empty((len(sums), len(members), 5), np.int64)
        merged[..., PIXELS] = np.add.reduceat(of_gprims[..., PIXELS], starts, axis=1)
        merged[..., X_MIN:X_MAX] = np.minimum.reduceat(of_gprims[..., X_MIN:X_MAX], starts, axis=1)
        merged[..., X_MAX:] = np.maximum.reduceat(of_gprims[..., X_MAX:], starts, axis=1)
        merged[merged[..., PIXELS] == 0, X_MIN:] = -1
        found[:, members] = merged
        return found

    def _owned_gprims(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the gprims of selected prims, those of a prim in a row; where each row starts, and its prim."""
        owned = np.argsort(self.member_of_gprim, kind="stable")
        owned = owned[np.searchsorted(self.member_of_gprim[owned], 0) :]
        members, starts = np.unique(self.member_of_gprim[owned], return_index=True)
        return owned, starts, members
