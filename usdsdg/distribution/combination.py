"""Vectors of which each axis has a distribution of its own."""

from collections.abc import Sequence
from numbers import Real
from typing import Any, Self

import numpy as np

from usdsdg.arguments.values import shown
from usdsdg.distribution.base import Distribution, add_kind, all_seeded
from usdsdg.errors import GraphError
from usdsdg.graph.node import plain


class Combine(Distribution):
    def __init__(self, distributions: Sequence[Any], name: str | None) -> None:
        super().__init__("OgnCombine", None, name)
        self._parts = self._listed("distributions", distributions)
        self.node.inputs["distributions"] = plain(self._parts)
        for part in self._parts:
            if not isinstance(part, (Distribution, Real)):
                raise GraphError(f"{self.node.describe()}: {shown(part)} is neither a number nor a distribution")

    def seeded(self, seed: int) -> Self:
        twin = super().seeded(seed)
        twin._parts = twin.node.inputs["distributions"] = all_seeded(self._parts, seed)
        return twin

    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> np.ndarray:
        columns = [
            np.asarray(part.sample(f"{consumer}/{axis}", execution, prims), dtype=np.float64)
            if isinstance(part, Distribution)
            else np.full(len(prims), float(part))
            for axis, part in enumerate(self._parts)
        ]
        if wide := [axis for axis, column in enumerate(columns) if column.ndim != 1]:
            raise GraphError(
                f"{self.node.describe()}: distribution {wide[0]} draws several numbers; give one for each axis"
            )
        return np.stack(columns, axis=1)

    def sample_worlds(self, consumer: str, executions: np.ndarray, prims: Sequence[str]) -> np.ndarray:
        columns = [
            part.sample_worlds(f"{consumer}/{axis}", executions, prims)
            if isinstance(part, Distribution)
            else np.full((len(executions), len(prims)), float(part))
            for axis, part in enumerate(self._parts)
        ]
        if wide := [axis for axis, column in enumerate(columns) if column.ndim != 2]:
            raise GraphError(
                f"{self.node.describe()}: distribution {wide[0]} draws several numbers; give one for each axis"
            )
        return np.stack(columns, axis=-1)


add_kind("OgnCombine", ("distributions",), lambda inputs, name: Combine(inputs["distributions"], name))


def combine(distributions: Sequence[Any], name: str | None = None):
    """Combine distributions or numbers, one per axis, into vectors; `name` as in `uniform`.

    Raises:
        GraphError: one of them is neither. At execution: one draws several numbers.
    """
    return Combine(distributions, name)
