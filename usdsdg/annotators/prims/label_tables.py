"""Numbers of labeled prims that stay the same for all frames of a stage, and ids of classes that do not."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from usdsdg.annotators.colors import FIRST_LABELED

Output = Mapping[str, str]  # {type: "label[,label]"}


class PrimTable:
    """Numbers of the labeled prims that one label filter selects.

    They count from 0: at first the prims of the stage in its order, visible or not, then what comes up later.
    """

    def __init__(self) -> None:
        self._numbers: dict[str, int] = {}

    def numbers(self, names: Iterable[str]) -> np.ndarray:
        """Return the number of each labeled prim, int64 (N,)."""
        return np.array([self._numbers.setdefault(name, len(self._numbers)) for name in names], np.int64)

    def __len__(self) -> int:
        return len(self._numbers)


class FrameClasses:
    """Ids of the classes that one frame shows, counted in the order in which they come, as in Isaac Sim."""

    def __init__(self) -> None:
        self._ids: dict[tuple[tuple[str, str], ...], int] = {}

    def ids(self, outputs: Sequence[Output]) -> np.ndarray:
        """Return the id of each set of labels, int64 (N,)."""
        keys = [tuple(sorted(output.items())) for output in outputs]
        return np.array([self._ids.setdefault(key, len(self._ids) + FIRST_LABELED) for key in keys], np.int64)

    def labels(self) -> dict[int, dict[str, str]]:
        """Return the labels of each class by id."""
        return {number: dict(key) for key, number in self._ids.items()}

    def colors(self) -> dict[int, tuple[int, int, int, int]]:
        """Return no colors: those of the ids apply."""
        return {}
