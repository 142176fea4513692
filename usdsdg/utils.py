"""Helpers that scripts call beside the families. Mirrors the part of `rep.utils` that is needed so far."""

from __future__ import annotations

from usdsdg.errors import warn_once
from usdsdg.graph.evaluate import graph
from usdsdg.graph.node import ReplicatorItem
from usdsdg.registry import near_misses

__all__ = ["ReplicatorItem", "send_og_event"]


def send_og_event(event_name: str) -> None:
    """Fire `trigger.on_custom_event(event_name)` at the next app update or step, whichever comes first."""
    known = sorted({trigger.name for trigger in graph().triggers if trigger.kind == "OnCustomEvent"})
    if event_name not in known:
        near = near_misses(event_name, known)
        hint = f"did you mean {near[0]!r}?" if near else f"known events: {', '.join(known) or 'none'}."
        warn_once(f"send_og_event: nothing waits for event {event_name!r}; {hint}")
    graph().send(event_name)
