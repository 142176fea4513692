"""Scene queries in the units of a stage, which a physics engine has beside its steps."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from pxr import Usd

from usdsdg.errors import warn_once
from usdsdg.stage.poses.transforms import meters_per_unit
from usdsdg_physics.queries.scene_queries import Overlap, RayHit, SceneQueries, Vector
from usdsdg_physics.scene.records import ShapeKind


class StageQueries(ABC):
    """Overlaps, rays and sweeps with lengths in stage units; a subclass says what is asked, and where bodies are.

    Directions and rotations may have any length. As in PhysX, queries with numbers that nothing has find nothing, with
    a warning.
    """

    _stage: Usd.Stage

    @abstractmethod
    def _queries(self) -> tuple[SceneQueries, np.ndarray]:
        """Return the queries of a scene and the poses (N, 7) [m] of its bodies."""

    def overlap_box(
        self, half_extent: Sequence[float], origin: Sequence[float], rotation_xyzw: Sequence[float] = (0, 0, 0, 1)
    ) -> list[Overlap]:
        """Return the enabled colliders that overlap a box [stage units], sorted by collider path."""
        if not _is_meant("overlap_box", half_extent, origin, turns=(rotation_xyzw,)):
            return []
        queries, poses = self._queries()
        return queries.overlap_box(poses, self._meters(half_extent), self._meters(origin), rotation_xyzw)

    def overlap_sphere(self, radius: float, origin: Sequence[float]) -> list[Overlap]:
        """Return the enabled colliders that overlap a sphere [stage units], sorted by collider path."""
        if not _is_meant("overlap_sphere", (radius,), origin):
            return []
        queries, poses = self._queries()
        return queries.overlap_sphere(poses, radius * meters_per_unit(self._stage), self._meters(origin))

    def raycast(self, origin: Sequence[float], direction: Sequence[float], distance: float) -> RayHit | None:
        """Return the nearest enabled collider along a ray [stage units], None when there is none within `distance`."""
        return next(iter(self.raycast_all(origin, direction, distance)), None)

    def raycast_all(
        self, origin: Sequence[float], direction: Sequence[float], distance: float, *, both_sides: bool = True
    ) -> list[RayHit]:
        """Return the first hit of every enabled collider along a ray [stage units], nearest first, then in path order.

        Triangles of meshes that face along the ray are hit if `both_sides`.
        """
        if not _is_meant("raycast", (distance,), origin, turns=(direction,)):
            return []
        queries, poses = self._queries()
        meters = meters_per_unit(self._stage)
        hits = queries.raycast(poses, self._meters(origin), direction, distance * meters, both_sides=both_sides)
        return [hit.scaled(1.0 / meters) for hit in hits]

    def sweep_sphere(
        self,
        radius: float,
        origin: Sequence[float],
        direction: Sequence[float],
        distance: float,
        *,
        both_sides: bool = True,
    ) -> list[RayHit]:
        """Return where a sphere that moves from `origin` [stage units] touches each enabled collider, nearest first."""
        size = (radius * meters_per_unit(self._stage), 0.0, 0.0)
        return self._sweep("sphere", size, origin, (0.0, 0.0, 0.0, 1.0), direction, distance, both_sides)

    def sweep_box(
        self,
        half_extent: Sequence[float],
        origin: Sequence[float],
        rotation_xyzw: Sequence[float],
        direction: Sequence[float],
        distance: float,
        *,
        both_sides: bool = True,
    ) -> list[RayHit]:
        """Return where a box that moves from `origin` [stage units] touches each enabled collider, nearest first."""
        size = self._meters(half_extent)
        return self._sweep("box", size, origin, rotation_xyzw, direction, distance, both_sides)

    def _sweep(
        self,
        kind: ShapeKind,
        size: Sequence[float] | np.ndarray,
        origin: Sequence[float],
        rotation: Sequence[float],
        direction: Sequence[float],
        distance: float,
        both_sides: bool,
    ) -> list[RayHit]:
        if not _is_meant(f"sweep_{kind}", (*size, distance), origin, turns=(direction, rotation)):
            return []
        queries, poses = self._queries()
        meters = meters_per_unit(self._stage)
        hits = queries.sweep(
            poses, kind, size, self._meters(origin), rotation, direction, distance * meters, both_sides=both_sides
        )
        return [hit.scaled(1.0 / meters) for hit in hits]

    def _meters(self, vector: Sequence[float]) -> np.ndarray:
        return np.array([float(component) for component in vector]) * meters_per_unit(self._stage)


def _is_meant(query: str, lengths: Sequence[float], origin: Sequence[float], *, turns: Sequence[Vector] = ()) -> bool:
    """Return whether a query can find something; warn where `lengths` are below zero or `turns` have no direction."""
    if not all(float(length) >= 0.0 for length in lengths):
        wrong = "has a radius, an extent or a distance that is below zero or not a number. Give lengths from 0 on."
    elif not all(map(math.isfinite, map(float, origin))):
        wrong = "begins at a point that is not finite. Give three numbers."
    elif not all(0.0 < math.hypot(*map(float, turn)) < math.inf for turn in turns):
        wrong = (
            "has a direction or a rotation without a length. Give a vector or a quaternion (x, y, z, w) that has one."
        )
    else:
        return True
    warn_once(f"{query} finds nothing, since it {wrong}")
    return False
