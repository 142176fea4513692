"""Contacts and triggers, in the forms that `omni.physics.core` and `omni.physx` share."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

from usdsdg.compat.carb import Float3
from usdsdg.compat.omni.physics.scene_query_hits import NO_INDEX, ORIGIN, path_id, proto_index
from usdsdg.compat.physics_schema_tools import intToSdfPath, sdfPathToInt
from usdsdg.session import engines, stage_context

if TYPE_CHECKING:
    from usdsdg_physics.scene.events import ContactEvent, TriggerEvent


class ContactEventType(IntEnum):
    """Whether two colliders began to touch, no longer touch, or still touch."""

    CONTACT_FOUND = 0
    CONTACT_LOST = 1
    CONTACT_PERSIST = 2


class TriggerEventType(IntEnum):
    """Whether a collider entered a trigger or left it."""

    TRIGGER_ON_ENTER = 0
    TRIGGER_ON_LEAVE = 1


@dataclass(frozen=True)
class ContactEventHeader:
    """Two colliders that touch; paths are integers of `PhysicsSchemaTools`, and offsets are those of the lists."""

    type: ContactEventType
    stage_id: int
    actor0: int
    actor1: int
    collider0: int
    collider1: int
    contact_data_offset: int
    num_contact_data: int
    friction_anchors_offset: int = 0
    num_friction_anchors_data: int = 0
    proto_index0: int = NO_INDEX
    proto_index1: int = NO_INDEX


@dataclass(frozen=True)
class ContactData:
    """A point where two colliders touch: world, stage units; normal and impulse are those on the first collider."""

    position: Float3 = ORIGIN
    normal: Float3 = ORIGIN
    impulse: Float3 = ORIGIN
    separation: float = 0.0
    face_index0: int = 0
    face_index1: int = 0
    material0: int = 0
    material1: int = 0


@dataclass(frozen=True)
class FrictionAnchor:
    """Where friction acts, and its impulse; none is reported apart from the impulse of a contact."""

    position: Float3 = ORIGIN
    impulse: Float3 = ORIGIN


@dataclass(frozen=True)
class TriggerEventData:
    """A collider that entered a trigger or left it; paths are integers of `PhysicsSchemaTools`."""

    event_type: TriggerEventType
    stage_id: int
    subscription_id: int
    trigger_body_prim_id: int
    trigger_collider_prim_id: int
    other_body_prim_id: int
    other_collider_prim_id: int


class ContactEventHeaderVector(list[ContactEventHeader]):
    """Headers of contacts."""


class ContactDataVector(list[ContactData]):
    """Points of contacts."""


class FrictionAnchorsDataVector(list[FrictionAnchor]):
    """Friction anchors; always empty."""


Contacts = tuple[ContactEventHeaderVector, ContactDataVector]
_KINDS = {
    "found": ContactEventType.CONTACT_FOUND,
    "lost": ContactEventType.CONTACT_LOST,
    "persist": ContactEventType.CONTACT_PERSIST,
}


def contacts_of(events: list[ContactEvent]) -> Contacts:
    """Return the headers and the points of contact events."""
    headers, points = ContactEventHeaderVector(), ContactDataVector()
    stage = stage_context.stage_id()
    for event in events:
        headers.append(
            ContactEventHeader(
                _KINDS[event.kind],
                stage,
                actor0=path_id(event.body0),
                actor1=path_id(event.body1),
                collider0=path_id(event.collider0),
                collider1=path_id(event.collider1),
                contact_data_offset=len(points),
                num_contact_data=len(event.points),
                proto_index0=proto_index(event.collider0),
                proto_index1=proto_index(event.collider1),
            )
        )
        materials = sdfPathToInt(event.material0), sdfPathToInt(event.material1)
        points.extend(
            ContactData(
                Float3(*point.position),
                Float3(*point.normal),
                Float3(*point.impulse),
                point.separation,
                material0=materials[0],
                material1=materials[1],
            )
            for point in event.points
        )
    return headers, points


def latest_contacts() -> Contacts:
    """Return the contacts of the latest step."""
    return contacts_of(engines.physics().contacts)


class TriggerSubscriptions:
    """Subscriptions to triggers by number."""

    def __init__(self) -> None:
        self._ends: dict[int, Callable[[], None]] = {}
        self._numbers = itertools.count(1)

    def subscribe(self, function: Callable[[TriggerEventData], None], trigger: int = 0) -> int:
        """Call `function(data)` for what enters and leaves triggers, or the one of that path; return the number."""
        number = next(self._numbers)
        path = str(intToSdfPath(trigger)) if trigger else ""

        def on_event(event: TriggerEvent) -> None:
            if path in ("", event.trigger):
                kind = TriggerEventType.TRIGGER_ON_ENTER if event.entered else TriggerEventType.TRIGGER_ON_LEAVE
                function(
                    TriggerEventData(
                        kind,
                        stage_context.stage_id(),
                        number,
                        trigger_body_prim_id=path_id(event.trigger_body),
                        trigger_collider_prim_id=path_id(event.trigger),
                        other_body_prim_id=path_id(event.other_body),
                        other_collider_prim_id=path_id(event.other),
                    )
                )

        self._ends[number] = engines.subscribe_triggers(on_event)
        return number

    def unsubscribe(self, number: int) -> None:
        """End a subscription."""
        end = self._ends.pop(number, None)
        if end is not None:
            end()
