"""Render settings of a run, and units, up axis and physics time step of the stage. Mirrors `rep.settings`."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from numbers import Integral, Real
from typing import Any

from pxr import Usd, UsdGeom

from usdsdg.arguments.parameters import name_parameters
from usdsdg.errors import ConfigError
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import graph
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.session.settings.store import get_settings, normalized
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.physics.scenes import physics_scene, set_steps_per_second, steps_per_second
from usdsdg.stage.semantics.semantic_classes import read_semantic_classes

# The keys that `set_render_rtx_realtime` and `set_render_pathtraced` set.
RENDER_MODE = "/rtx/rendermode"
REALTIME_ANTIALIASING = "/rtx/post/aa/op"
PATHTRACED_TOTAL_SAMPLES_PER_PIXEL = "/rtx/pathtracing/totalSpp"


def carb_settings(setting: str, value: Any) -> ReplicatorItem | None:
    """Set one key: to a constant now, or to a draw of a distribution whenever the enclosing trigger fires.

    Returns:
        The item of the graph node for a distribution, None for a constant.
    """
    if not hasattr(value, "sample"):
        get_settings().set(setting, value)
        return None
    return ReplicatorItem(graph().add(Node("OgnCarbSettings", {"attribute": normalized(setting), "value": value})))


@action("OgnCarbSettings")
def _write_drawn_setting(node: Node, execution: int) -> None:
    """Set the setting of a `carb_settings` node to a new draw, rounded down where the setting is an integer."""
    key = node.inputs["attribute"]
    drawn = node.inputs["value"].sample(f"{node.key}/value", execution, [key])[0]
    value, before = drawn.tolist() if hasattr(drawn, "tolist") else drawn, get_settings().get(key)
    if isinstance(value, float) and isinstance(before, int) and not isinstance(before, bool):
        value = math.floor(value)
    get_settings().set(key, value)


def get_physx_timestep() -> float:
    """Return the physics time step of the current stage [s]: that of its first PhysicsScene, or 1/60."""
    return 1.0 / steps_per_second(physics_scene(current_stage()))


def set_physx_timestep(physx_delta_time: float) -> None:
    """Author the physics time step [s] on the stage's first PhysicsScene, which is created if there is none.

    Raises:
        ConfigError: (a ValueError) `physx_delta_time` is not above 0.
    """
    if not isinstance(physx_delta_time, Real) or not physx_delta_time > 0:
        raise ConfigError(f"settings.set_physx_timestep: {physx_delta_time!r} must be above 0 seconds")
    set_steps_per_second(current_stage(), 1.0 / physx_delta_time)


def set_render_rtx_realtime(antialiasing: str = "FXAA") -> None:
    """Capture in the fast mode: few samples per pixel, then an edge-preserving filter.

    `antialiasing` (off, TAA, FXAA, DLSS, DLAA) is stored in `/rtx/post/aa/op` as its number in Omniverse; it does not
    change images.

    Raises:
        ConfigError: (a ValueError) `antialiasing` is unknown.
    """
    operations = {"off": 0, "taa": 1, "fxaa": 2, "dlss": 3, "dlaa": 4}
    if str(antialiasing).lower() not in operations:
        raise ConfigError(f"antialiasing is {antialiasing!r}; expected one of {', '.join(operations)}")
    get_settings().set(RENDER_MODE, "RaytracedLighting")
    get_settings().set(REALTIME_ANTIALIASING, operations[str(antialiasing).lower()])


def set_render_pathtraced(samples_per_pixel: int = 64) -> None:
    """Capture with the path tracer at `samples_per_pixel`.

    Raises:
        ConfigError: (a ValueError) `samples_per_pixel` is not an integer, or below 1.
    """
    if not isinstance(samples_per_pixel, Integral) or samples_per_pixel < 1:
        raise ConfigError(f"samples_per_pixel is {samples_per_pixel!r}; expected a whole number, 1 or more")
    get_settings().set(RENDER_MODE, "PathTracing")
    get_settings().set(PATHTRACED_TOTAL_SAMPLES_PER_PIXEL, int(samples_per_pixel))


def set_semantic_classes(classes: Any, closed: bool = False) -> None:
    """Fix the classes of the dataset: their ids and colors in masks, and the categories of CocoWriter.

    Without it the classes are those that stage and graph can show, with ids from 2 in the order of their names; parts
    of a dataset that are made by several runs need the same list in each.

    Args:
        classes: names such as ["apple", "pear"]; ids {"apple": 2}; {"apple": {"id": 2, "color": (255, 0, 0)}}; a .json,
            .yaml or .txt file of these; the folder of a dataset, whose classes are taken; None for no fixed classes.
            A name may be "type:label".
        closed: a class that is not listed is an error, not one that is appended with a warning.

    Raises:
        ConfigError: (a ValueError) `classes` is something else, or names a class, an id or a color twice.
    """
    read_semantic_classes(classes)
    get_settings().set("/usdsdg/labels/closedClasses", bool(closed))
    get_settings().set("/usdsdg/labels/semanticClasses", classes)


def set_stage_up_axis(up_axis: str) -> None:
    """Author the stage's up axis, "Y" or "Z" (any case).

    Raises:
        ConfigError: (a ValueError) `up_axis` is another axis.
    """
    if str(up_axis).upper() not in ("Y", "Z"):
        raise ConfigError(f"up axis is {up_axis!r}; expected 'Y' or 'Z'")
    with _root_layer() as stage:
        UsdGeom.SetStageUpAxis(stage, up_axis.upper())


def set_stage_meters_per_unit(meters_per_unit: float) -> None:
    """Author the stage's linear unit [meters]: 0.01 for centimeters.

    Raises:
        ConfigError: (a ValueError) `meters_per_unit` is not above 0.
    """
    if not isinstance(meters_per_unit, Real) or not meters_per_unit > 0:
        raise ConfigError(f"meters per unit is {meters_per_unit!r}; expected a number above 0")
    with _root_layer() as stage:
        UsdGeom.SetStageMetersPerUnit(stage, float(meters_per_unit))


@contextmanager
def _root_layer() -> Iterator[Usd.Stage]:
    """The current stage, edited in its root layer: USD has up axis and unit there only, also inside of `new_layer`."""
    stage = current_stage()
    with Usd.EditContext(stage, stage.GetRootLayer()):
        yield stage


name_parameters(globals())
