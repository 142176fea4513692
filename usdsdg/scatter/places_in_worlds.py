"""Where prims are in many worlds, for positions that are scattered in each of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Sdf, Usd

from usdsdg.scatter.stage_bodies import Places
from usdsdg.stage.geometry.triangles import TriangleInstance, triangles_below
from usdsdg.stage.poses.transforms import as_array, local_to_world
from usdsdg.stage.world_values import WorldValues


class PlacesInWorlds:
    """Where prims are in many worlds. The triangles are read of the stage once, and must not change meanwhile."""

    def __init__(self, values: WorldValues) -> None:
        self._values = values
        self._read: dict[tuple[Sdf.Path, ...], list[tuple[TriangleInstance, np.ndarray | None]]] = {}

    def differ(self, prims: Sequence[Usd.Prim]) -> bool:
        """Return whether triangles at or below prims are not where the stage has them."""
        return any(matrices is not None for _, matrices in self._placed(prims))

    def of(self, world: int) -> Places:
        """Return where prims are in one world."""
        return _InWorld(self, world)

    def triangles(self, prims: Sequence[Usd.Prim], world: int) -> list[TriangleInstance]:
        """Return the triangles at and below prims, where they are in a world."""
        return [
            placed if matrices is None else placed._replace(to_world=matrices[world % len(matrices)])
            for placed, matrices in self._placed(prims)
        ]

    def origin(self, prim: Usd.Prim, world: int) -> np.ndarray:
        """Return (3,) the position of a prim's origin in a world."""
        own, to_world = self._values.translation(prim), self._values.parent_to_world(prim)
        return (np.append(own[world % len(own)], 1.0) @ to_world[world % len(to_world)])[:3]

    def _placed(self, prims: Sequence[Usd.Prim]) -> list[tuple[TriangleInstance, np.ndarray | None]]:
        """Return triangles with their transforms (worlds or 1, 4, 4); None for what is where the stage has it."""
        key = tuple(prim.GetPath() for prim in prims)
        if key not in self._read:
            self._read[key] = [(each, self._matrices(prim, each)) for prim in prims for each in triangles_below([prim])]
        return self._read[key]

    def _matrices(self, root: Usd.Prim, placed: TriangleInstance) -> np.ndarray | None:
        name, _, instance = placed.path.partition("[")
        prim = root.GetStage().GetPrimAtPath(name)
        matrices = self._values.local_to_world(prim)  # also if it is not used: `values` notes that it was read
        if not self._values.move(prim):
            return None
        if not instance:
            return matrices
        return placed.to_world @ np.linalg.inv(as_array(local_to_world(prim))) @ matrices


class _InWorld:
    """Where prims are in one world."""

    def __init__(self, everywhere: PlacesInWorlds, world: int) -> None:
        self._everywhere, self._world = everywhere, world

    def triangles(self, prims: Sequence[Usd.Prim]) -> list[TriangleInstance]:
        return self._everywhere.triangles(prims, self._world)

    def origin(self, prim: Usd.Prim) -> np.ndarray:
        return self._everywhere.origin(prim, self._world)
