"""`omni.physx`: steps and scene queries, as Isaac Sim before 6 names them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from usdsdg.compat.carb.eventdispatcher import Observer
from usdsdg.compat.omni.physics.physics_events import (
    ContactDataVector,
    ContactEventHeaderVector,
    FrictionAnchorsDataVector,
    TriggerEventData,
    TriggerSubscriptions,
    contacts_of,
    latest_contacts,
)
from usdsdg.compat.omni.physics.scene_query_hits import (
    PhysxHit,
    PhysxLocatedHit,
    Vector,
    physx_hit,
    physx_located_hit,
)
from usdsdg.compat.omni.physx.body_commands import BodyCommands, push_at, transformation_of
from usdsdg.errors import Unsupported
from usdsdg.session import engines, stage_context

Hit = TypeVar("Hit")
Report = Callable[[Hit], bool]


class Subscription(Observer):
    """A subscription, which ends with `unsubscribe` or when it is garbage collected."""

    unsubscribe = Observer.reset


class PhysxInterface:
    """Steps of physics, with and without the timeline."""

    def subscribe_physics_step_events(self, fn: Callable[[float], None]) -> Subscription:
        """Call `fn(dt)` once per physics step, after poses and velocities are on the stage."""
        return Subscription(engines.subscribe_step(fn))

    def subscribe_physics_on_step_events(
        self, fn: Callable[[float], None], pre_step: bool = False, order: int = 0
    ) -> Subscription:
        """Call `fn(dt)` after every physics step, or before it: lower orders first, then as subscribed."""
        return Subscription(engines.subscribe_step(fn, before=pre_step, order=order))

    def start_simulation(self) -> None:
        """Begin to simulate without the timeline: remember poses and velocities."""
        engines.physics().play()

    def update_simulation(self, elapsedStep: float, currentTime: float = 0.0) -> None:
        """Take one step of `elapsedStep` [s], also while the timeline is paused or stopped; the timeline stays."""
        engines.physics().play()
        engines.physics().step(float(elapsedStep))

    def update_transformations(
        self,
        updateToFastCache: bool = False,
        updateToUsd: bool = True,
        updateVelocitiesToUsd: bool = True,
        outputVelocitiesLocalSpace: bool = False,
    ) -> None:
        """Do nothing: every step writes poses and velocities to the stage."""

    def is_running(self) -> bool:
        """Return whether physics simulates the current stage, with the timeline or without it."""
        physics = engines.physics_if_made()
        return physics is not None and physics.is_playing

    def reset_simulation(self) -> None:
        """Stop simulating, and restore poses and velocities from before."""
        engines.physics().stop()

    def apply_force_at_pos(self, path: str, force: Any, pos: Any, mode: str = "Force") -> None:
        """Push the body at a path during the next step; see `BodyCommands.apply_force_at_pos`."""
        push_at(path, force, pos, mode)

    def get_rigidbody_transformation(self, path: str) -> dict[str, Any]:
        """Return "ret_val", whether a body is simulated, and its "position" (3,) and "rotation" (x, y, z, w)."""
        return transformation_of(path)

    def force_load_physics_from_usd(self) -> None:
        """Do nothing: the stage is read when a simulation begins, and what changes before every step."""


class PhysxSimulationInterface(BodyCommands):
    """Steps of physics without the timeline, and commands for single bodies."""

    def simulate(self, elapsed_time: float, current_time: float = 0.0) -> None:
        """Take one step of `elapsed_time` [s], also while the timeline is paused or stopped; the timeline stays."""
        _interface.update_simulation(elapsed_time, current_time)

    def fetch_results(self) -> None:
        """Do nothing: a step has ended, and its result is on the stage, when `simulate` returns."""

    def check_results(self) -> bool:
        """Return True: the result of the latest step is on the stage."""
        return True

    def get_attached_stage(self) -> int:
        """Return the id of the current stage, which is always the simulated one."""
        return stage_context.stage_id()

    def attach_stage(self, stage_id: int) -> bool:
        """Begin to simulate the current stage, which is the only one that can be attached."""
        engines.physics().play()
        return True

    def detach_stage(self) -> None:
        """Stop simulating; bodies stay where they are."""
        engines.physics().stop(restore=False)

    def flush_changes(self) -> None:
        """Take what has changed on the stage into account now, where queries find it, and not at the next step."""
        engines.physics().read_edits()

    def subscribe_contact_report_events(
        self, fn: Callable[[ContactEventHeaderVector, ContactDataVector], None]
    ) -> Subscription:
        """Call `fn(headers, points)` after every step in which prims with PhysxContactReportAPI touch."""
        return Subscription(engines.subscribe_contacts(lambda events: fn(*contacts_of(events))))

    def subscribe_full_contact_report_events(
        self, fn: Callable[[ContactEventHeaderVector, ContactDataVector, FrictionAnchorsDataVector], None]
    ) -> Subscription:
        """Call `fn(headers, points, anchors)` likewise; impulses of points contain friction, so anchors are empty."""
        return Subscription(
            engines.subscribe_contacts(lambda events: fn(*contacts_of(events), FrictionAnchorsDataVector()))
        )

    def get_contact_report(self) -> tuple[ContactEventHeaderVector, ContactDataVector]:
        """Return the headers and points of the latest step."""
        return latest_contacts()

    def get_full_contact_report(
        self,
    ) -> tuple[ContactEventHeaderVector, ContactDataVector, FrictionAnchorsDataVector]:
        """Return the headers, points and friction anchors, of which there are none, of the latest step."""
        return *latest_contacts(), FrictionAnchorsDataVector()

    def subscribe_physics_trigger_report_events(
        self, trigger_report_fn: Callable[[TriggerEventData], None], stage_id: int = 0, prim_id: int = 0
    ) -> int:
        """Call `trigger_report_fn(data)` for what enters and leaves triggers; return the subscription's number.

        `prim_id` is that of a trigger, 0 for all; `stage_id` is not looked at, since one stage is simulated.
        """
        return _triggers.subscribe(trigger_report_fn, prim_id)

    def unsubscribe_physics_trigger_report_events(self, subscriptionId: int) -> None:
        """End a subscription to triggers."""
        _triggers.unsubscribe(subscriptionId)


class SceneQueryInterface:
    """Queries against enabled colliders: world space, stage units, rotations (x, y, z, w).

    Hits are reported nearest first, and those at the same distance in the order of their paths; overlaps in the order
    of their paths. `reportFn` returns whether to go on. Directions need no unit length. Without `bothSides`, triangles
    of meshes that face along the motion are not hit.
    """

    def overlap_box(
        self,
        halfExtent: Vector,
        pos: Vector,
        rot: Vector,
        reportFn: Report[PhysxHit] | None = None,
        anyHit: bool = False,
    ) -> int:
        """Report every collider that overlaps a box; return how many were reported, at most 1 with `anyHit`."""
        return _reported(map(physx_hit, engines.physics().overlap_box(halfExtent, pos, rot)), reportFn, anyHit)

    def overlap_box_any(self, halfExtent: Vector, pos: Vector, rot: Vector) -> bool:
        """Return whether a collider overlaps a box."""
        return bool(engines.physics().overlap_box(halfExtent, pos, rot))

    def overlap_sphere(
        self, radius: float, pos: Vector, reportFn: Report[PhysxHit] | None = None, anyHit: bool = False
    ) -> int:
        """Report every collider that overlaps a sphere; return how many were reported, at most 1 with `anyHit`."""
        return _reported(map(physx_hit, engines.physics().overlap_sphere(radius, pos)), reportFn, anyHit)

    def overlap_sphere_any(self, radius: float, pos: Vector) -> bool:
        """Return whether a collider overlaps a sphere."""
        return bool(engines.physics().overlap_sphere(radius, pos))

    def raycast_closest(self, origin: Vector, dir: Vector, distance: float, bothSides: bool = False) -> dict[str, Any]:
        """Return {"hit": False}, or the nearest hit: see `_as_dict`."""
        return _as_dict(engines.physics().raycast_all(origin, dir, distance, both_sides=bothSides))

    def raycast_any(self, origin: Vector, dir: Vector, distance: float, bothSides: bool = False) -> bool:
        """Return whether a ray hits."""
        return bool(engines.physics().raycast_all(origin, dir, distance, both_sides=bothSides))

    def raycast_all(
        self,
        origin: Vector,
        dir: Vector,
        distance: float,
        reportFn: Report[PhysxLocatedHit],
        bothSides: bool = False,
    ) -> bool:
        """Report the first hit of every collider along a ray; return whether there is one."""
        hits = engines.physics().raycast_all(origin, dir, distance, both_sides=bothSides)
        return _reported(map(physx_located_hit, hits), reportFn) > 0

    def sweep_sphere_closest(
        self, radius: float, origin: Vector, dir: Vector, distance: float, bothSides: bool = False
    ) -> dict[str, Any]:
        """Return {"hit": False}, or where a moving sphere first touches a collider: see `_as_dict`."""
        return _as_dict(engines.physics().sweep_sphere(radius, origin, dir, distance, both_sides=bothSides))

    def sweep_sphere_any(
        self, radius: float, origin: Vector, dir: Vector, distance: float, bothSides: bool = False
    ) -> bool:
        """Return whether a moving sphere touches a collider."""
        return bool(engines.physics().sweep_sphere(radius, origin, dir, distance, both_sides=bothSides))

    def sweep_sphere_all(
        self,
        radius: float,
        origin: Vector,
        dir: Vector,
        distance: float,
        reportFn: Report[PhysxLocatedHit],
        bothSides: bool = False,
    ) -> bool:
        """Report where a moving sphere touches each collider; return whether there is one."""
        hits = engines.physics().sweep_sphere(radius, origin, dir, distance, both_sides=bothSides)
        return _reported(map(physx_located_hit, hits), reportFn) > 0

    def sweep_box_closest(
        self, halfExtent: Vector, pos: Vector, rot: Vector, dir: Vector, distance: float, bothSides: bool = False
    ) -> dict[str, Any]:
        """Return {"hit": False}, or where a moving box first touches a collider: see `_as_dict`."""
        return _as_dict(engines.physics().sweep_box(halfExtent, pos, rot, dir, distance, both_sides=bothSides))

    def sweep_box_any(
        self, halfExtent: Vector, pos: Vector, rot: Vector, dir: Vector, distance: float, bothSides: bool = False
    ) -> bool:
        """Return whether a moving box touches a collider."""
        return bool(engines.physics().sweep_box(halfExtent, pos, rot, dir, distance, both_sides=bothSides))

    def sweep_box_all(
        self,
        halfExtent: Vector,
        pos: Vector,
        rot: Vector,
        dir: Vector,
        distance: float,
        reportFn: Report[PhysxLocatedHit],
        bothSides: bool = False,
    ) -> bool:
        """Report where a moving box touches each collider; return whether there is one."""
        hits = engines.physics().sweep_box(halfExtent, pos, rot, dir, distance, both_sides=bothSides)
        return _reported(map(physx_located_hit, hits), reportFn) > 0

    def __getattr__(self, name: str) -> Any:
        if name.startswith(("overlap_", "sweep_")):
            raise Unsupported(
                f"PhysXSceneQuery.{name}: queries with the shape of a prim are not available; use overlap_box, "
                "overlap_sphere, sweep_box or sweep_sphere with its bounds"
            )
        raise AttributeError(name)


def _reported(hits: Iterable[Hit], report: Report[Hit] | None, any_hit: bool = False) -> int:
    """Report hits until `report` returns False, or one with `any_hit`; return the number of those reported."""
    count = 0
    for hit in hits:
        count += 1
        wants_more = report is None or report(hit)
        if any_hit or not wants_more:
            break
    return count


def _as_dict(hits: list[Any]) -> dict[str, Any]:
    """Return "hit", and for one: position, normal, distance, faceIndex, collision, rigidBody, material, protoIndex."""
    if not hits:
        return {"hit": False}
    hit = physx_located_hit(hits[0])
    return {
        "hit": True, "position": hit.position, "normal": hit.normal, "distance": hit.distance,
        "faceIndex": hit.face_index, "collision": hit.collision, "rigidBody": hit.rigid_body, "material": hit.material,
        "protoIndex": hit.protoIndex,
    }  # fmt: skip


_triggers = TriggerSubscriptions()
_interface, _queries, _simulation = PhysxInterface(), SceneQueryInterface(), PhysxSimulationInterface()


def get_physx_interface() -> PhysxInterface:
    return _interface


acquire_physx_interface = get_physx_interface


def get_physx_simulation_interface() -> PhysxSimulationInterface:
    return _simulation


def get_physx_scene_query_interface() -> SceneQueryInterface:
    return _queries


acquire_physx_simulation_interface = get_physx_simulation_interface
