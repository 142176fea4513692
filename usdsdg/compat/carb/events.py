"""`carb.events`: streams of events with numbers as types, as Isaac Sim before 6 has them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from usdsdg.app.app import get_app
from usdsdg.compat.carb.eventdispatcher import Observer, timeline_payload
from usdsdg.errors import called_for_script
from usdsdg.listeners import Listeners
from usdsdg.session.timeline import get_timeline

__all__ = ["IEvent", "IEventStream", "ISubscription", "type_from_string"]

# The types of the timeline's events, by the timeline's words; `omni.timeline.TimelineEventType` has the same numbers.
# A step in time is two events, of which Kit sends the first at other changes of the time, too.
TIMELINE_TYPES = {"play": (0,), "pause": (1,), "stop": (2,), "tick": (3, 4), "loop": (100,)}

# The types of the events at the end of the application, in their order; `omni.kit.app` has them under these names.
POST_QUIT_EVENT_TYPE, PRE_SHUTDOWN_EVENT_TYPE = SHUTDOWN_TYPES = (0, 1)


@dataclass(frozen=True)
class IEvent:
    """An event: the number of its type, its sender, and its payload."""

    type: int = 0
    sender: int = 0
    payload: Mapping[str, Any] = field(default_factory=dict)


class ISubscription(Observer):
    """A subscription, which ends with `unsubscribe` or when it is garbage collected."""

    unsubscribe = Observer.reset


class IEventStream:
    """Calls listeners in their order, then in that of subscribing; an event is delivered when it is pushed."""

    def __init__(self, name: str = "") -> None:
        self.name = name
        self._listeners: Listeners[[IEvent]] = Listeners()

    def create_subscription_to_pop(self, fn: Callable[[IEvent], Any], order: int = 0, name: str = "") -> ISubscription:
        """Call `fn(event)` at every event while the subscription is held."""
        return self._subscribe(None, fn, order)

    def create_subscription_to_pop_by_type(
        self, event_type: int, fn: Callable[[IEvent], Any], order: int = 0, name: str = ""
    ) -> ISubscription:
        """Call `fn(event)` at every event of a type while the subscription is held."""
        return self._subscribe(int(event_type), fn, order)

    create_subscription_to_push = create_subscription_to_pop
    create_subscription_to_push_by_type = create_subscription_to_pop_by_type

    def push(self, event_type: int = 0, sender: int = 0, payload: Mapping[str, Any] | None = None) -> None:
        """Deliver an event."""
        self._listeners.call(IEvent(int(event_type), sender, dict(payload or {})))

    dispatch = push

    def pump(self) -> None:
        """Do nothing: events are delivered when they are pushed."""

    def _subscribe(self, event_type: int | None, fn: Callable[[IEvent], Any], order: int) -> ISubscription:
        def hear(event: IEvent) -> None:
            if event_type in (None, event.type):
                with called_for_script(f"which was subscribed to events{f' of {self.name}' if self.name else ''}"):
                    fn(event)

        return ISubscription(self._listeners.subscribe(hear, order=order))


class EventStreams:
    """The streams of the application: its updates and its end, the timeline, and messages between scripts."""

    def __init__(self) -> None:
        self.update, self.timeline = IEventStream("update"), IEventStream("timeline")
        self.pre_update, self.message_bus = IEventStream("pre update"), IEventStream("message bus")
        self.shutdown = IEventStream("shutdown")
        get_app().subscribe_closing(self._on_closing)
        get_app().subscribe_before_update(lambda dt: self.pre_update.push(0, payload={"dt": dt}))
        get_app().subscribe_update(lambda dt: self.update.push(0, payload={"dt": dt}))
        get_timeline().subscribe(self._on_timeline)

    def _on_closing(self) -> None:
        for kind in SHUTDOWN_TYPES:
            self.shutdown.push(kind)

    def _on_timeline(self, change: str) -> None:
        for kind in TIMELINE_TYPES[change]:
            self.timeline.push(kind, payload=timeline_payload(change))


def type_from_string(name: str) -> int:
    """Return the number of an event type that is known by a name: the same for the same name."""
    number = 14695981039346656037
    for byte in name.encode():
        number = (number ^ byte) * 1099511628211 % (1 << 64)
    return number
