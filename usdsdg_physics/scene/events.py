"""What happens in a step that users hear about: colliders in triggers, and contacts."""

from dataclasses import dataclass
from typing import Literal

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class TriggerEvent:
    """A collider that entered a trigger, or left it. The body of a static collider is the collider itself."""

    entered: bool
    trigger: str
    trigger_body: str
    other: str
    other_body: str


@dataclass(frozen=True)
class ContactPoint:
    """A point where two colliders touch, in the world; lengths and masses are in units of the stage."""

    position: Triple
    normal: Triple  # from collider 1 to collider 0
    impulse: Triple  # on collider 0, over the whole step
    separation: float  # negative where they overlap


@dataclass(frozen=True)
class ContactEvent:
    """The contacts of two colliders in a step. The body of a static collider is the collider itself."""

    kind: Literal["found", "persist", "lost"]
    body0: str
    body1: str
    collider0: str
    collider1: str
    material0: str  # "" for the default
    material1: str
    points: tuple[ContactPoint, ...]  # none of a lost contact
