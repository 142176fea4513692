"""Triggers, which decide when the nodes inside `with rep.trigger...:` run. Mirrors `rep.trigger`."""

import inspect
import math
from collections.abc import Callable
from numbers import Real
from typing import Any

from usdsdg.arguments.parameters import name_parameters
from usdsdg.arguments.registry import register_function
from usdsdg.arguments.values import shown, whole_number
from usdsdg.errors import GraphError, Unsupported, called_for_script
from usdsdg.functional import physics
from usdsdg.graph.evaluate import Trigger, TriggerContext, graph
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.session.settings.store import captures_on_play, get_settings
from usdsdg.session.timeline import get_timeline

# A condition that was false for this many captures in a row no longer counts as one that can end a run.
MAX_FALSE_CAPTURES = 1000
# Relative tolerance that keeps rounding errors in a sum of frame times from delaying a trigger by one frame.
ROUNDING = 1e-6


def on_frame(
    interval: int = 1, num_frames: int = 0, name: str = "on_frame", rt_subframes: int = 1, max_execs: int = 0
) -> ReplicatorItem:
    """Fire every `interval` captures, at most `max_execs` times (0: no limit).

    The preview at initialization has already run the body once, so frame 0 shows that draw and the first capture only
    records the baseline, as in Replicator.

    Args:
        interval: Number of captures.
        num_frames: The older name of `max_execs`.
        name: Name of the node in draws, in the payload of writers and in messages.
        rt_subframes: Minimum number of sub-frames of the captures that it fires for.
        max_execs: A run without a number of frames ends when all triggers that have this limit would fire once more,
            after `interval` times `max_execs` frames.

    Raises:
        GraphError: `interval` is not an integer or below 1, or another number is not an integer.
    """
    whole_number("num_frames", num_frames or 0)
    return _add("OgnOnFrame", name, interval=interval, maxExecs=max_execs or num_frames, rtSubframes=rt_subframes)


def on_time(
    interval: float = 1,
    num: int = 0,
    name: str = "on_time",
    rt_subframes: int = 32,
    enable_capture_on_play: bool = True,
    reset_physics: bool = True,
    max_execs: int = 0,
) -> ReplicatorItem:
    """Fire when `interval` seconds of the timeline have passed since it last fired, or since the start.

    It fires for the first picture that shows that time; loops of the timeline do not reset it. The preview at
    initialization also runs the body, and does not count for `max_execs`: its draw is seen until the first firing.
    A run that its last firing ends has no picture of that: only whole intervals are captured.

    Args:
        interval: seconds.
        num: the older name of `max_execs`.
        name: in the payload of writers, which number their sequences of frames by it.
        rt_subframes: at least so many sub-frames at the capture that it fires for.
        enable_capture_on_play: Switch `orchestrator.set_capture_on_play` on, now; False leaves it as it is.
        reset_physics: At each firing, before the body runs, put all rigid bodies back to where they were when the
            timeline began to play, as `functional.physics.reset` does. The
            picture shows them there, or where the body puts them; they move from the next frame on.
        max_execs: Maximum number of firings; 0: no limit.

    Raises:
        GraphError: `interval` is not above 0, or infinite.
    """
    whole_number("num", num or 0)
    inputs = {"interval": interval, "maxExecs": max_execs or num, "rtSubframes": rt_subframes}
    return _timed(name, enable_capture_on_play, resetPhysics=bool(reset_physics), **inputs)


def on_time_end(
    interval: float = 1,
    name: str = "on_time_end",
    rt_subframes: int = 32,
    enable_capture_on_play: bool = True,
    max_execs: int = 0,
) -> ReplicatorItem:
    """Fire one frame, a time code, before `on_time` with the same `interval`, when physics has not been reset yet.

    Give it to a writer to keep the last frame of every interval. Bodies are not reset, and the preview at
    initialization does not run the body. The arguments are those of `on_time`.

    Raises:
        GraphError: `interval` is not above 0, or infinite.
    """
    inputs = {"interval": interval, "maxExecs": max_execs, "rtSubframes": rt_subframes}
    return _timed(name, enable_capture_on_play, triggerOnLastFrame=True, **inputs)


def _timed(name: str, capture_on_play: bool, *, interval: float, **inputs: Any) -> ReplicatorItem:
    made = _add("OgnOnTime", name, interval=interval, **inputs)
    if capture_on_play:
        get_settings().set("/omni/replicator/captureOnPlay", True)
    return made


def on_custom_event(event_name: str) -> ReplicatorItem:
    """Fire at the evaluation after `rep.utils.send_og_event(event_name)`: at the next app update or step.

    Raises:
        GraphError: `event_name` is not a string, or empty.
    """
    return _add("OnCustomEvent", event_name, eventName=event_name)


def on_condition(condition: Callable[[], bool], max_execs: int = 0, rt_subframes: int = 1) -> ReplicatorItem:
    """Fire at every capture for which `condition()` is true.

    A saved stage cannot hold the Python function; it holds its name, and running it needs the script.
    `max_execs` and `rt_subframes` are as in `on_frame`.

    Raises:
        GraphError: `condition` is not a function, or needs arguments.
    """
    _check_condition(condition)
    name = getattr(condition, "__name__", "condition")
    misses = [0]

    def due(context: TriggerContext) -> bool:
        if context.preview or context.capture < 0:
            return False
        with called_for_script(f"the condition of trigger.on_condition made at {node.line}"):
            met = bool(condition())
        misses[0] = 0 if met else misses[0] + 1
        return met

    def blocked() -> str:
        can_fire = misses[0] < MAX_FALSE_CAPTURES
        return "" if can_fire else f"trigger.on_condition {name!r} was false at the last {misses[0]} captures"

    inputs = {"maxExecs": max_execs, "rtSubframes": rt_subframes}
    node = Node("OgnConditionScript", inputs, name=name)
    _check_limits(node)
    return graph().add_trigger(Trigger(node, due, blocked=blocked, check=_check_limits))


def _check_condition(condition: Any) -> None:
    if not callable(condition):
        raise GraphError(f"trigger.on_condition: condition is {shown(condition)}; expected a function")
    try:
        parameters = inspect.signature(condition).parameters.values()
    except ValueError:  # some built-in functions have no signature
        return
    optional = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    needed = [each.name for each in parameters if each.default is each.empty and each.kind not in optional]
    if needed:
        raise GraphError(
            f"trigger.on_condition: {getattr(condition, '__name__', 'condition')} needs {', '.join(needed)}, and it is "
            "called without arguments; give defaults"
        )


def _add(kind: str, name: str, **inputs: Any) -> ReplicatorItem:
    return graph().add_trigger(trigger_of(Node(kind, inputs, name=name)))


def _check_limits(node: Node) -> None:
    for role, argument in (("maxExecs", "max_execs"), ("rtSubframes", "rt_subframes")):
        whole_number(argument, node.inputs.get(role, 0))


def _check_frames(node: Node) -> None:
    whole_number("interval", node.inputs["interval"], least=1)
    _check_limits(node)


def _check_time(node: Node) -> None:
    interval = node.inputs["interval"]
    if not isinstance(interval, Real) or not 0 < float(interval) < math.inf:
        function = "on_time_end" if node.inputs.get("triggerOnLastFrame") else "on_time"
        raise GraphError(f"trigger.{function}: interval={interval!r} must be above 0, in seconds, and finite")
    node.inputs["interval"] = float(interval)
    _check_limits(node)


def _check_event(node: Node) -> None:
    event = node.inputs["eventName"]
    if not isinstance(event, str) or not event:
        raise GraphError(f"trigger.on_custom_event: event_name is {event!r}; expected a name")


_CHECKS = {"OgnOnFrame": _check_frames, "OgnOnTime": _check_time, "OnCustomEvent": _check_event}


def trigger_of(node: Node) -> Trigger:
    """Return the trigger that a node describes, new or from a saved graph.

    Its inputs may be set later, as by `item.set_input`.

    Raises:
        GraphError: a trigger of the node's type cannot be made from its inputs.
    """
    makers = {"OgnOnFrame": _on_frame, "OgnOnTime": _on_time, "OnCustomEvent": _on_custom_event}
    if node.kind == "OgnConditionScript":
        raise GraphError(
            f"trigger.on_condition {node.name!r} (made at {node.line}) calls a Python function, which a saved stage "
            "does not hold; run the script instead"
        )
    if node.kind not in makers:
        raise GraphError(f"a node of type {node.kind} is not a trigger; known: {', '.join(makers)}")
    _CHECKS[node.kind](node)
    return makers[node.kind](node)


def _on_frame(node: Node) -> Trigger:
    def due(context: TriggerContext) -> bool:
        return context.preview or (context.capture > 0 and context.capture % int(node.inputs["interval"]) == 0)

    return Trigger(node, due, check=_check_frames)


def _on_time(node: Node) -> Trigger:
    last = [0.0]
    at_end = bool(node.inputs.get("triggerOnLastFrame", False))

    def due(context: TriggerContext) -> bool:
        if context.preview:
            return not at_end
        interval = float(node.inputs["interval"])
        ahead = min(1.0 / get_timeline().get_time_codes_per_seconds(), interval) if at_end else 0.0
        now = context.time + ahead
        if now < last[0]:
            last[0] = 0.0  # the time was set back
        target = last[0] + interval
        if now < target and not math.isclose(now, target, rel_tol=ROUNDING):
            return False
        last[0] = now
        return True

    def blocked() -> str:
        if not get_timeline().is_playing() and not captures_on_play():
            return (
                f"trigger.on_time {node.name!r} waits for the timeline, which does not play (start_timeline=True "
                "plays it)"
            )
        return ""

    # Stages that were saved before this input existed do not have it.
    prepare = physics.reset if node.inputs.get("resetPhysics", False) else None
    return Trigger(node, due, blocked=blocked, prepare=prepare, counts_previews=False, check=_check_time)


def _on_custom_event(node: Node) -> Trigger:
    def due(context: TriggerContext) -> bool:
        return node.inputs["eventName"] in context.events and not context.preview

    return Trigger(node, due, check=_check_event)


def on_key_press(key: Any, modifier: Any = None, name: str | None = None) -> ReplicatorItem:
    """Not available: there is no window to press keys in."""
    raise Unsupported("trigger.on_key_press needs a window; use trigger.on_custom_event and utils.send_og_event.")


def register(fn: Callable[..., Any], override: bool = True, fn_name: str | None = None) -> None:
    """Make `rep.trigger.<name>` call `fn`.

    Raises:
        ValueError: the name is not an identifier, or is taken and `override` is False.
    """
    register_function(globals(), "trigger", fn, override, fn_name)


name_parameters(globals())
