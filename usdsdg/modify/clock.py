"""Timeline and skeletal animation: `rep.modify.timeline`, `time`, `frame` and `animation`."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from pxr import Sdf, Usd, UsdSkel

from usdsdg.arguments.prims import prim_at
from usdsdg.distribution import Distribution, choice, draw
from usdsdg.errors import ArgumentError, BadPrim
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act, graph
from usdsdg.graph.node import Node, ReplicatorItem, current_trigger, plain, prim_paths
from usdsdg.session.timeline import Timeline, get_timeline

_SETTERS: dict[str, Callable[[Timeline, float], None]] = {
    "time": Timeline.show,
    "start_time": Timeline.set_start_time,
    "end_time": Timeline.set_end_time,
}


def timeline(value: Any, modify_type: str) -> ReplicatorItem:
    """Set the timeline's current, start or end time: constants immediately, else whenever the enclosing trigger fires.

    Args:
        value: seconds for the three times, time codes for the three frames.
        modify_type: time, start_time, end_time, frame, start_frame or end_frame.

    Raises:
        ArgumentError: another `modify_type`.
    """
    known = [*_SETTERS, *(kind.replace("time", "frame") for kind in _SETTERS)]
    modify_type = str(modify_type).lower()
    if modify_type not in known:
        raise ArgumentError(f"modify.timeline: modify_type={modify_type!r}; known: {', '.join(known)}")
    node = Node(kind="OgnWriteTimeline", inputs={"attribute": modify_type, "value": plain(value)})
    if current_trigger() is None and not isinstance(value, Distribution):
        _write_timeline(node, 0)
        return ReplicatorItem(node)
    return ReplicatorItem(graph().add(node))


@action("OgnWriteTimeline")
def _write_timeline(node: Node, execution: int) -> None:
    # Distributions sample one value per prim; the timeline is not a prim.
    drawn = draw(node.inputs["value"], replace(node, prims=("timeline",)), execution, "value")
    clock, what, value = get_timeline(), node.inputs["attribute"], float(drawn[0])
    if what.endswith("frame"):
        what, value = what.replace("frame", "time"), value / clock.get_time_codes_per_seconds()
    _SETTERS[what](clock, value)


def time(value: Any) -> ReplicatorItem:
    """Set the timeline's current time [s]; see `timeline`."""
    return timeline(value, "time")


def frame(value: Any) -> ReplicatorItem:
    """Set the timeline's current frame [time codes]; see `timeline`."""
    return timeline(value, "frame")


def animation(values: Any, reset_timeline: bool = False, input_prims: Any = None) -> ReplicatorItem:
    """Bind an animation to every skeleton at or below the prims, and let the timeline play, as Replicator does.

    Prims without a skeleton are left out.

    Args:
        values: a SkelAnimation (path, prim or item), a list of them to choose from, or a distribution.
        reset_timeline: set the timeline to its start time, so that the animation begins.

    Raises:
        BadPrim: at execution, none of the prims has a skeleton, or the animation is not on the stage.
    """
    paths = None if isinstance(values, Distribution) else prim_paths(values)
    drawn = values if paths is None else paths[0] if len(paths) == 1 else choice(list(paths))
    return act("OgnWriteAnimation", input_prims, attribute="animation", value=drawn, resetTimeline=bool(reset_timeline))


@action("OgnWriteAnimation")
def _write_animation(node: Node, execution: int) -> None:
    animated = False
    for path, chosen in zip(node.prims, draw(node.inputs["value"], node, execution, "value")):
        source = prim_at(prim_paths(chosen)[0])
        if not source.IsA(UsdSkel.Animation):
            raise BadPrim(f"{source.GetPath()} is a {source.GetTypeName() or 'typeless prim'}, not a SkelAnimation")
        for skeleton in (prim for prim in Usd.PrimRange(prim_at(path)) if prim.IsA(UsdSkel.Skeleton)):
            binding = UsdSkel.BindingAPI.Apply(skeleton)
            binding.CreateAnimationSourceRel().SetTargets([Sdf.Path(str(source.GetPath()))])
            animated = True
    if not animated:
        raise BadPrim(f"{', '.join(node.prims)}: there is no Skeleton at or below any of these to animate")
    clock = get_timeline()
    if node.inputs["resetTimeline"]:
        clock.set_current_time(clock.get_start_time())
    clock.play()
