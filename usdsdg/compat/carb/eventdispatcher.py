"""`carb.eventdispatcher`: events by name, for app updates, the timeline, stages, new frames and custom events."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from usdsdg.app.app import get_app
from usdsdg.compat.new_frames import NewFrames
from usdsdg.errors import called_for_script
from usdsdg.graph import evaluate
from usdsdg.session.session import current
from usdsdg.session.timeline import get_timeline

__all__ = ["Event", "EventDispatcher", "Observer", "get_eventdispatcher"]

APP_UPDATE = "omni.kit.app:update"
NEW_FRAME = "omni.usd.context:new_frame"
CUSTOM_EVENT = "omni.graph.action."
TIMELINE_EVENTS = {
    "play": "omni.timeline:play",
    "pause": "omni.timeline:pause",
    "stop": "omni.timeline:stop",
    "loop": "omni.timeline:looped",
    "tick": "omni.timeline:current_time_ticked",
}
TICKED_PERMANENT = "omni.timeline:current_time_ticked_permanent"


def timeline_payload(change: str) -> dict[str, Any]:
    """Return the payload of an event of the timeline: the time, and of a tick also by how much it has changed [s]."""
    timeline = get_timeline()
    ticked = {"dt": timeline.latest_advance} if change == "tick" else {}
    return {"currentTime": timeline.get_current_time(), **ticked}


@dataclass(frozen=True)
class Event:
    """An event; its payload can be read as a mapping."""

    event_name: str
    payload: Mapping[str, Any] = field(default_factory=dict)

    def __getitem__(self, key: str) -> Any:
        return self.payload[key]

    def __contains__(self, key: str) -> bool:
        return key in self.payload

    def get(self, key: str, default: Any = None) -> Any:
        return self.payload.get(key, default)


class Observer:
    """A subscription, which ends with `reset` or when it is garbage collected."""

    def __init__(self, end: Callable[[], object]) -> None:
        self._end = end

    def reset(self) -> None:
        self._end()

    def __del__(self) -> None:
        self._end()


class EventDispatcher:
    """Calls observers of events sorted by `order`, then by time of subscription."""

    def __init__(self) -> None:
        self._observers: dict[int, tuple[str, int, Mapping[str, Any], Callable[[Event], None]]] = {}
        self._keys = itertools.count()
        get_app().subscribe_update(self._notify_update)
        get_timeline().subscribe(self._notify_timeline)
        NewFrames(self._notify_new_frame)
        _ = current().stage_events  # which dispatches here from now on

    def observe_event(
        self,
        order: int = 0,
        event_name: str = "",
        on_event: Callable[[Event], None] | None = None,
        filter: Mapping[str, Any] | None = None,
        observer_name: str = "",
    ) -> Observer:
        """Call `on_event(event)` at every event of that name whose payload has all items of `filter`."""
        if on_event is None or not event_name:
            raise TypeError(f"observe_event {observer_name!r}: give event_name and on_event")
        key = next(self._keys)
        self._observers[key] = (str(event_name), order, filter or {}, on_event)
        return Observer(partial(self._observers.pop, key, None))

    def dispatch_event(self, event_name: str, payload: Mapping[str, Any] | None = None) -> int:
        """Notify all observers of `event_name`; return their number.

        `omni.graph.action.<name>` also fires `rep.trigger.on_custom_event("<name>")`.
        """
        if event_name.startswith(CUSTOM_EVENT):
            evaluate.graph().send(event_name.removeprefix(CUSTOM_EVENT))
        return self._notify(event_name, payload or {})

    def _notify(self, event_name: str, payload: Mapping[str, Any]) -> int:
        event = Event(event_name, payload)
        # Of a list of keys, which is made at once: an observer may be garbage collected, and end, at each tuple.
        due = [
            (order, key, on_event)
            for key in list(self._observers)
            for name, order, required, on_event in filter(None, [self._observers.get(key)])
            if name == event_name and all(payload.get(each) == value for each, value in required.items())
        ]
        for _, key, on_event in sorted(due, key=lambda each: each[:2]):
            if key in self._observers:
                with called_for_script(f"which observes {event_name}"):
                    on_event(event)
        return len(due)

    def _notify_update(self, dt: float) -> None:
        self._notify(APP_UPDATE, {"dt": dt})

    def _notify_new_frame(self, number: int) -> None:
        self._notify(NEW_FRAME, {"swh_frame_number": number})

    def _notify_timeline(self, change: str) -> None:
        if change in TIMELINE_EVENTS:
            self._notify(TIMELINE_EVENTS[change], timeline_payload(change))
        if change == "tick":
            self._notify(TICKED_PERMANENT, timeline_payload(change))


def get_eventdispatcher() -> EventDispatcher:
    """Return the event dispatcher of the session."""
    return current().event_dispatcher
