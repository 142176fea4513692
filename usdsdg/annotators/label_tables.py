"""Numbers of classes and of labeled prims that stay the same for all frames of a stage.

A class is a set of labels as annotators output it. Numbers count from 0: at first classes and prims in stage order,
whether or not they are visible, then what comes up later.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

Output = Mapping[str, str]  # {type: "label[,label]"}


class LabelTable:
    """The classes and labeled prims that one label filter selects."""

    def __init__(self) -> None:
        self._classes: dict[tuple[tuple[str, str], ...], int] = {}
        self._prims: dict[str, int] = {}

    def classes(self, outputs: Iterable[Output]) -> np.ndarray:
        """Return the number of each set of labels, int64 (N,)."""
        keys = [tuple(sorted(output.items())) for output in outputs]
        return np.array([self._classes.setdefault(key, len(self._classes)) for key in keys], np.int64)

    def prims(self, names: Sequence[str]) -> np.ndarray:
        """Return the number of each labeled prim, int64 (N,)."""
        return np.array([self._prims.setdefault(name, len(self._prims)) for name in names], np.int64)

    def labels(self) -> tuple[dict[str, str], ...]:
        """Return the labels of each class, by number."""
        return tuple(dict(key) for key in self._classes)

    def prim_count(self) -> int:
        """Return how many labeled prims have a number."""
        return len(self._prims)
