"""Values of worlds that are drawn one after the other, each from what the one before it has."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Sdf, Usd

from usdsdg.errors import Unsupported
from usdsdg.stage.world_values import WorldValues, number_of


class WorldSequence:
    """Values of `count` worlds, of which the stage has the first.

    Attributes:
        now: values of one world, those that the world in turn has instead of what the stage has.
        values: values of all worlds.
    """

    def __init__(self, stage: Usd.Stage, count: int, time: Usd.TimeCode) -> None:
        self.now = WorldValues(1, time)
        self._stage = stage
        self.values = WorldValues(count, time)

    def close(self, world: int) -> None:
        """Take over what `now` has for a world, which is in turn, and for those that follow it."""
        for path, values in self.now.values.items():
            for name, (value,) in values.items():
                self._column(path, name, value)[world:] = value
            self.values.sources[path] = self.now.sources[path]
        for path, values in self.now.unseen.items():
            for name, (value,) in values.items():
                columns = self.values.unseen.setdefault(path, {})
                if name not in columns:
                    columns[name] = np.repeat(value[None], self.values.count, axis=0)
                    self.values.unseen_from[path, name] = world
                columns[name][world:] = value

    def keep(self, written: WorldValues) -> None:
        """Have values of attributes that differ in no world, too: those that the stage has."""
        for path, values in written.values.items():
            for name, (value,) in values.items():
                self._column(path, name, value)
            self.values.sources.setdefault(path, written.sources[path])

    def _column(self, path: Sdf.Path, name: str, like: np.ndarray) -> np.ndarray:
        """Return the values of an attribute in all worlds; before it is written, they are those of the stage."""
        columns = self.values.values.setdefault(path, {})
        if name not in columns:
            attribute = self._stage.GetPrimAtPath(path).GetAttribute(name)
            first: Any = number_of(attribute, self.now.time)
            if first is None or np.shape(first) != np.shape(like):
                lacks = "no value" if first is None else "a value of another size"
                raise Unsupported(
                    f"worlds: {attribute.GetPath()} has {lacks} in world 0 and cannot have one in others. Run without "
                    "worlds."
                )
            columns[name] = np.repeat(np.asarray(first, np.asarray(like).dtype)[None], self.values.count, axis=0)
        return columns[name]
