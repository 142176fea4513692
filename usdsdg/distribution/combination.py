"""Vectors of which axes have distributions of their own."""

from collections.abc import Iterator, Sequence
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

    def parts(self, consumer: str) -> Iterator[tuple[Distribution, str]]:
        for axis, part in enumerate(self._parts):
            if isinstance(part, Distribution):
                yield part, f"{consumer}/{axis}"

    def held(self) -> Sequence[Any]:
        return self._parts

    def sample(self, consumer: str, execution: int, prims: Sequence[str]) -> np.ndarray:
        columns = [
            np.asarray(part.sample(f"{consumer}/{axis}", execution, prims), dtype=np.float64)
            if isinstance(part, Distribution)
            else np.full(len(prims), float(part))
            for axis, part in enumerate(self._parts)
        ]
        return np.concatenate([column.reshape(len(prims), -1) for column in columns], axis=1)

    def named_parts(self, consumer: str, execution: int, prims: Sequence[str]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for axis, part in enumerate(self._parts):
            if isinstance(part, Distribution):
                found |= part.named_samples(f"{consumer}/{axis}", execution, prims)
        return found

    def sample_worlds(self, consumer: str, executions: np.ndarray, prims: Sequence[str]) -> np.ndarray:
        columns = [
            part.sample_worlds(f"{consumer}/{axis}", executions, prims)
            if isinstance(part, Distribution)
            else np.full((len(executions), len(prims)), float(part))
            for axis, part in enumerate(self._parts)
        ]
        return np.concatenate([column.reshape(*column.shape[:2], -1) for column in columns], axis=-1)


add_kind("OgnCombine", ("distributions",), lambda inputs, name: Combine(inputs["distributions"], name))


def combine(distributions: Sequence[Any], name: str | None = None) -> Distribution:
    """Combine distributions or numbers into vectors; `name` as in `uniform`.

    Each brings the next axis, one that draws vectors as many axes as they have.

    Raises:
        GraphError: one of them is neither.
    """
    return Combine(distributions, name)
