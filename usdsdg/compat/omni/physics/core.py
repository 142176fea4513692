"""`omni.physics.core`: steps, scene queries and times of physics, as Isaac Sim 6 names them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeVar

from usdsdg.compat.omni.physics.physics_events import (
    ContactData,
    ContactDataVector,
    ContactEventHeader,
    ContactEventHeaderVector,
    ContactEventType,
    FrictionAnchor,
    FrictionAnchorsDataVector,
    contacts_of,
)
from usdsdg.compat.omni.physics.scene_query_hits import (
    OverlapHit,
    RaycastHit,
    SceneQueryHitLocation,
    SceneQueryHitObject,
    SweepHit,
    Vector,
    overlap_hit,
    raycast_hit,
    sweep_hit,
)
from usdsdg.compat.omni.physx import Subscription
from usdsdg.session import engines, stage_context

__all__ = [
    "ContactData", "ContactDataVector", "ContactEventHeader", "ContactEventHeaderVector", "ContactEventType",
    "FrictionAnchor", "FrictionAnchorsDataVector", "OverlapHit", "PhysicsBenchmarksInterface", "PhysicsProfileStats",
    "PhysicsSceneQueryInterface", "PhysicsSimulationInterface", "PhysicsStepContext", "RaycastHit",
    "SceneQueryHitLocation", "SceneQueryHitObject", "SweepHit", "get_physics_benchmarks_interface",
    "get_physics_scene_query_interface", "get_physics_simulation_interface",
]  # fmt: skip

Hit = TypeVar("Hit")
Report = Callable[[Hit], bool]


@dataclass(frozen=True)
class PhysicsStepContext:
    """What a listener of steps receives beside the step's length."""

    simulation_id: int = 0


@dataclass(frozen=True)
class PhysicsProfileStats:
    """The wall-clock time that a part of the latest step took [ms]."""

    zone_name: str
    ms: float


class PhysicsSimulationInterface:
    """Steps of physics, with and without the timeline."""

    def subscribe_physics_on_step_events(
        self,
        pre_step: bool = False,
        order: int = 0,
        on_update: Callable[[float, PhysicsStepContext], None] | None = None,
    ) -> Subscription:
        """Call `on_update(dt, context)` after every step, or before it: lower orders first, then as subscribed."""
        if on_update is None:
            raise TypeError("subscribe_physics_on_step_events: on_update is missing")
        context = PhysicsStepContext()
        return Subscription(engines.subscribe_step(lambda dt: on_update(dt, context), before=pre_step, order=order))

    def subscribe_physics_contact_report_events(
        self, on_event: Callable[[ContactEventHeaderVector, ContactDataVector, FrictionAnchorsDataVector], None]
    ) -> Subscription:
        """Call `on_event(headers, points, anchors)` after every step in which prims with PhysxContactReportAPI touch.

        Impulses of points contain friction, so anchors are empty.
        """
        return Subscription(
            engines.subscribe_contacts(lambda events: on_event(*contacts_of(events), FrictionAnchorsDataVector()))
        )

    def simulate(self, elapsed_time: float, current_time: float = 0.0) -> None:
        """Take one step of `elapsed_time` [s], also while the timeline is paused or stopped; the timeline stays."""
        physics = engines.physics()
        physics.play()
        physics.step(float(elapsed_time))

    def fetch_results(self) -> None:
        """Do nothing: a step has ended, and its result is on the stage, when `simulate` returns."""

    def check_results(self) -> bool:
        """Return True: the result of the latest step is on the stage."""
        return True

    def flush_changes(self) -> None:
        """Take what has changed on the stage into account now, where queries find it, and not at the next step."""
        engines.physics().read_edits()

    def get_attached_stage(self) -> int:
        """Return the id of the current stage, which is always the simulated one."""
        return stage_context.stage_id()


class PhysicsSceneQueryInterface:
    """Queries against enabled colliders: world space, stage units, rotations (x, y, z, w).

    Hits are reported nearest first, and those at the same distance in the order of their paths; overlaps in the order
    of their paths. `report_fn` returns whether to go on. Directions need no unit length.
    """

    def raycast_closest(
        self, origin: Vector, unit_dir: Vector, distance: float, both_sides: bool
    ) -> tuple[bool, RaycastHit]:
        """Return whether a ray hits, and the nearest hit."""
        hits = engines.physics().raycast_all(origin, unit_dir, distance, both_sides=both_sides)
        return bool(hits), raycast_hit(hits[0]) if hits else RaycastHit()

    def raycast_any(self, origin: Vector, unit_dir: Vector, distance: float, both_sides: bool) -> bool:
        """Return whether a ray hits."""
        return bool(engines.physics().raycast_all(origin, unit_dir, distance, both_sides=both_sides))

    def raycast_all(
        self, origin: Vector, unit_dir: Vector, distance: float, report_fn: Report[RaycastHit], both_sides: bool
    ) -> None:
        """Report the first hit of every collider along a ray."""
        hits = engines.physics().raycast_all(origin, unit_dir, distance, both_sides=both_sides)
        reported(map(raycast_hit, hits), report_fn)

    def sweep_sphere_closest(
        self, radius: float, origin: Vector, unit_dir: Vector, distance: float, both_sides: bool
    ) -> tuple[bool, SweepHit]:
        """Return whether a moving sphere touches a collider, and the first hit."""
        hits = engines.physics().sweep_sphere(radius, origin, unit_dir, distance, both_sides=both_sides)
        return bool(hits), sweep_hit(hits[0]) if hits else SweepHit()

    def sweep_sphere_any(
        self, radius: float, origin: Vector, unit_dir: Vector, distance: float, both_sides: bool
    ) -> bool:
        """Return whether a moving sphere touches a collider."""
        return bool(engines.physics().sweep_sphere(radius, origin, unit_dir, distance, both_sides=both_sides))

    def sweep_sphere_all(
        self,
        radius: float,
        origin: Vector,
        unit_dir: Vector,
        distance: float,
        report_fn: Report[SweepHit],
        both_sides: bool,
    ) -> None:
        """Report where a moving sphere touches each collider."""
        hits = engines.physics().sweep_sphere(radius, origin, unit_dir, distance, both_sides=both_sides)
        reported(map(sweep_hit, hits), report_fn)

    def sweep_box_closest(
        self,
        half_extent: Vector,
        position: Vector,
        rotation: Vector,
        unit_dir: Vector,
        distance: float,
        both_sides: bool,
    ) -> tuple[bool, SweepHit]:
        """Return whether a moving box touches a collider, and the first hit."""
        hits = engines.physics().sweep_box(half_extent, position, rotation, unit_dir, distance, both_sides=both_sides)
        return bool(hits), sweep_hit(hits[0]) if hits else SweepHit()

    def sweep_box_any(
        self,
        half_extent: Vector,
        position: Vector,
        rotation: Vector,
        unit_dir: Vector,
        distance: float,
        both_sides: bool,
    ) -> bool:
        """Return whether a moving box touches a collider."""
        return self.sweep_box_closest(half_extent, position, rotation, unit_dir, distance, both_sides)[0]

    def sweep_box_all(
        self,
        half_extent: Vector,
        position: Vector,
        rotation: Vector,
        unit_dir: Vector,
        distance: float,
        report_fn: Report[SweepHit],
        both_sides: bool,
    ) -> None:
        """Report where a moving box touches each collider."""
        hits = engines.physics().sweep_box(half_extent, position, rotation, unit_dir, distance, both_sides=both_sides)
        reported(map(sweep_hit, hits), report_fn)

    def overlap_sphere(self, radius: float, position: Vector, report_fn: Report[OverlapHit]) -> int:
        """Report every collider that overlaps a sphere; return the number of those reported."""
        return reported(map(overlap_hit, engines.physics().overlap_sphere(radius, position)), report_fn)

    def overlap_sphere_any(self, radius: float, position: Vector) -> bool:
        """Return whether a collider overlaps a sphere."""
        return bool(engines.physics().overlap_sphere(radius, position))

    def overlap_box(
        self, half_extent: Vector, position: Vector, rotation: Vector, report_fn: Report[OverlapHit]
    ) -> int:
        """Report every collider that overlaps a box; return the number of those reported."""
        return reported(map(overlap_hit, engines.physics().overlap_box(half_extent, position, rotation)), report_fn)

    def overlap_box_any(self, half_extent: Vector, position: Vector, rotation: Vector) -> bool:
        """Return whether a collider overlaps a box."""
        return bool(engines.physics().overlap_box(half_extent, position, rotation))


class PhysicsBenchmarksInterface:
    """How long steps take."""

    def subscribe_profile_stats_events(self, fn: Callable[[list[PhysicsProfileStats]], None]) -> Subscription:
        """Call `fn(stats)` after every step with its time, under the name that it has in PhysX."""

        def on_step(_dt: float) -> None:
            fn([PhysicsProfileStats("PhysX Update", engines.physics().step_seconds * 1000.0)])

        return Subscription(engines.subscribe_step(on_step))


def reported(hits: Iterable[Hit], report: Report[Hit]) -> int:
    """Report hits until `report` returns False; return the number of those reported."""
    count = 0
    for hit in hits:
        count += 1
        if not report(hit):
            break
    return count


_simulation, _queries = PhysicsSimulationInterface(), PhysicsSceneQueryInterface()
_benchmarks = PhysicsBenchmarksInterface()


def get_physics_simulation_interface() -> PhysicsSimulationInterface:
    return _simulation


def get_physics_scene_query_interface() -> PhysicsSceneQueryInterface:
    return _queries


def get_physics_benchmarks_interface() -> PhysicsBenchmarksInterface:
    return _benchmarks
