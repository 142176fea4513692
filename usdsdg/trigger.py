"""Triggers: when the nodes inside `with rep.trigger...:` run. Mirrors `rep.trigger`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from usdsdg.errors import GraphError, Unsupported
from usdsdg.graph.evaluate import Moment, Trigger, graph
from usdsdg.graph.node import ReplicatorItem


def on_frame(
    interval: int = 1, num_frames: int = 0, name: str = "on_frame", rt_subframes: int = 1, max_execs: int = 0
) -> ReplicatorItem:
    """Fire every `interval` captures, at most `max_execs` times (0: without end).

    The preview at initialisation already ran the body once, so frame 0 shows that draw and the first capture only
    records the baseline, as in Replicator.
    """
    if interval < 1:
        raise GraphError(f"trigger.on_frame: interval={interval!r} must be at least 1")

    def due(moment: Moment) -> bool:
        return moment.preview or (moment.capture > 0 and moment.capture % interval == 0)

    return graph().add_trigger(Trigger("OgnOnFrame", name, due, max_execs or num_frames, rt_subframes))


def on_time(
    interval: float = 1,
    num: int = 0,
    name: str = "on_time",
    rt_subframes: int = 32,
    enable_capture_on_play: bool = True,
    reset_physics: bool = True,
    max_execs: int = 0,
) -> ReplicatorItem:
    """Fire whenever the timeline has moved on by `interval` seconds, first at `interval`."""
    if interval <= 0:
        raise GraphError(f"trigger.on_time: interval={interval!r} must be above 0")
    last = [0.0]

    def due(moment: Moment) -> bool:
        if moment.time < last[0]:
            last[0] = 0.0
        if moment.preview or moment.time < last[0] + interval:
            return False
        last[0] += interval
        return True

    return graph().add_trigger(Trigger("OgnOnTime", name, due, max_execs or num, rt_subframes))


def on_custom_event(event_name: str) -> ReplicatorItem:
    """Fire at the evaluation after `rep.utils.send_og_event(event_name)`."""
    if not event_name:
        raise GraphError("trigger.on_custom_event: event_name is empty")
    return graph().add_trigger(
        Trigger("OnCustomEvent", event_name, lambda moment: event_name in moment.events and not moment.preview)
    )


def on_condition(condition: Callable[[], bool], max_execs: int = 0, rt_subframes: int = 1) -> ReplicatorItem:
    """Fire at every capture for which `condition()` is true."""

    def due(moment: Moment) -> bool:
        return not moment.preview and moment.capture >= 0 and bool(condition())

    name = getattr(condition, "__name__", "condition")
    return graph().add_trigger(Trigger("OgnConditionScript", name, due, max_execs, rt_subframes))


def on_key_press(key: Any, modifier: Any = None, name: str | None = None) -> ReplicatorItem:
    """Not available: there is no window to press keys in."""
    raise Unsupported("trigger.on_key_press needs a window; use trigger.on_custom_event and utils.send_og_event.")
