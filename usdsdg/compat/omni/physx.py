"""`omni.physx`: step events and scene queries."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from usdsdg.compat.carb.eventdispatcher import Observer
from usdsdg.session import engines


class Subscription(Observer):
    """A subscription, which ends with `unsubscribe` or when it is garbage collected."""

    unsubscribe = Observer.reset


class PhysxInterface:
    def subscribe_physics_step_events(self, fn: Callable[[float], None]) -> Subscription:
        """Call `fn(dt)` once per physics step, after poses and velocities are on the stage."""
        return Subscription(engines.subscribe_step(fn))


class SceneQueryInterface:
    """Overlap and ray queries against colliders. Positions are in world space [stage units], rotations xyzw."""

    def overlap_box(
        self, half_extent: Any, pos: Any, rot: Any, report_fn: Callable[[Any], bool] | None = None, anyHit: bool = False
    ) -> int:
        """Report every shape that overlaps the box until `report_fn` returns False; return their number."""
        return self._reported(engines.physics().overlap_box(half_extent, pos, rot), report_fn, anyHit)

    def overlap_sphere(
        self, radius: float, pos: Any, report_fn: Callable[[Any], bool] | None = None, anyHit: bool = False
    ) -> int:
        """Report every shape that overlaps the sphere until `report_fn` returns False; return their number."""
        return self._reported(engines.physics().overlap_sphere(radius, pos), report_fn, anyHit)

    def _reported(self, hits: list[Any], report_fn: Callable[[Any], bool] | None, any_hit: bool) -> int:
        count = 0
        for hit in hits:
            count += 1
            wants_more = report_fn is None or report_fn(
                SimpleNamespace(rigid_body=hit.rigid_body, collision=hit.collision, protoIndex=-1)
            )
            if any_hit or not wants_more:
                break
        return count

    def raycast_closest(self, origin: Any, dir: Any, distance: float, bothSides: bool = False) -> dict[str, Any]:
        """Return {"hit": False}, or the closest hit: rigidBody, collision, position, normal, distance."""
        hit = engines.physics().raycast(origin, dir, distance)
        if hit is None:
            return {"hit": False}
        return {
            "hit": True, "rigidBody": hit.rigid_body, "collision": hit.collision, "position": hit.position,
            "normal": hit.normal, "distance": hit.distance,
        }  # fmt: skip


_interface, _queries = PhysxInterface(), SceneQueryInterface()


def get_physx_interface() -> PhysxInterface:
    return _interface


acquire_physx_interface = get_physx_interface


def get_physx_scene_query_interface() -> SceneQueryInterface:
    return _queries
