"""Triggers: when the nodes inside `with rep.trigger...:` run. Mirrors `rep.trigger`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from usdsdg.errors import GraphError, Unsupported
from usdsdg.graph.evaluate import Moment, Trigger, graph
from usdsdg.graph.node import ReplicatorItem
from usdsdg.timeline import get_timeline

# After so many captures without being true a condition no longer counts as something that will end a run.
PATIENCE = 1000


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

    def blocked() -> str:
        timeline = get_timeline()
        if not timeline.is_playing():
            return (
                f"trigger.on_time {name!r} waits for the timeline, which does not play (start_timeline=True plays it)"
            )
        if timeline.is_looping() and interval >= timeline.get_end_time():
            return f"trigger.on_time {name!r} waits for {interval:g} s, and the timeline loops before that"
        return ""

    return graph().add_trigger(Trigger("OgnOnTime", name, due, max_execs or num, rt_subframes, blocked=blocked))


def on_custom_event(event_name: str) -> ReplicatorItem:
    """Fire at the evaluation after `rep.utils.send_og_event(event_name)`."""
    if not event_name:
        raise GraphError("trigger.on_custom_event: event_name is empty")
    return graph().add_trigger(
        Trigger("OnCustomEvent", event_name, lambda moment: event_name in moment.events and not moment.preview)
    )


def on_condition(condition: Callable[[], bool], max_execs: int = 0, rt_subframes: int = 1) -> ReplicatorItem:
    """Fire at every capture for which `condition()` is true."""
    name = getattr(condition, "__name__", "condition")
    misses = [0]

    def due(moment: Moment) -> bool:
        if moment.preview or moment.capture < 0:
            return False
        met = bool(condition())
        misses[0] = 0 if met else misses[0] + 1
        return met

    def blocked() -> str:
        patient = misses[0] < PATIENCE
        return "" if patient else f"trigger.on_condition {name!r} was false at the last {misses[0]} captures"

    return graph().add_trigger(Trigger("OgnConditionScript", name, due, max_execs, rt_subframes, blocked=blocked))


def on_key_press(key: Any, modifier: Any = None, name: str | None = None) -> ReplicatorItem:
    """Not available: there is no window to press keys in."""
    raise Unsupported("trigger.on_key_press needs a window; use trigger.on_custom_event and utils.send_og_event.")
