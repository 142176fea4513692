"""Description of a room: walls, blocks of furniture, lamps and windows. Meters, z up, linear radiance."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

# Albedo (n, 3) at the surface coordinates u, v (n,) in meters: (y, z), (x, z) or (x, y) by the face's axis.
Pattern = Callable[[np.ndarray, np.ndarray], np.ndarray]
Point = tuple[float, float, float]


@dataclass(frozen=True)
class Block:
    """An axis-aligned box from `low` to `high`, the same pattern on all sides."""

    low: Point
    high: Point
    pattern: Pattern


@dataclass(frozen=True)
class Lamp:
    """A rectangular emitter, flat along one axis, that faces `facing`; with `sky` it looks like a window."""

    low: Point
    high: Point
    facing: Point
    radiance: Point
    sky: bool = False


@dataclass(frozen=True)
class Room:
    """The inside of a box, seen from `eye`."""

    low: Point
    high: Point
    eye: Point
    floor: Pattern
    ceiling: Pattern
    walls: Pattern
    lamps: Sequence[Lamp]
    blocks: Sequence[Block] = field(default_factory=tuple)

    def face_pattern(self, axis: int, upper: bool) -> Pattern:
        """Return the pattern of the face across `axis`, on its upper or lower side."""
        if axis == 2:
            return self.ceiling if upper else self.floor
        return self.walls
