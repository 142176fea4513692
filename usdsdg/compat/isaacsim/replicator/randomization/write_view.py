"""The node that draws values and writes them to a registered view."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from usdsdg.compat.isaacsim.replicator.randomization.attributes import OPERATIONS
from usdsdg.compat.isaacsim.replicator.randomization.registry import RegisteredView, get_registry
from usdsdg.compat.isaacsim.replicator.randomization.rl_frames import in_gate
from usdsdg.distribution import Distribution, uniform
from usdsdg.errors import ArgumentError, counted
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import graph
from usdsdg.graph.node import Node

Array = NDArray[np.float64]

_KINDS = {
    "scene": "OgnWritePhysicsSimulationContext",
    "rigid": "OgnWritePhysicsRigidPrimView",
    "robots": "OgnWritePhysicsArticulationView",
}


def randomize(
    function: str, kind: str, view: str, operation: str, num_buckets: int | None, attributes: dict[str, Any]
) -> None:
    """Add a node for each attribute that is not None, in the order of the mapping.

    Args:
        attributes: distributions, or constant values.

    Raises:
        ArgumentError: (a ValueError) it is not inside of a gate, the view is not registered, or there is no such
            operation.
        Unsupported: an attribute of the view cannot be randomized.
    """
    if not in_gate():
        raise ArgumentError(
            f"{function}: call it inside of `with gate.on_interval(...):` or `with gate.on_env_reset():`"
        )
    if operation not in OPERATIONS:
        raise ArgumentError(f"{function}: operation is {operation!r}; expected one of {', '.join(OPERATIONS)}")
    registered = get_registry().view(kind, view)
    for attribute, values in attributes.items():
        if values is None:
            continue
        registered.remember(attribute)
        inputs = {
            "view": view,
            "attribute": attribute,
            "operation": operation,
            "values": values if isinstance(values, Distribution) else uniform(values, values),
        }
        if num_buckets is not None and attribute == "material_properties":
            inputs["numBuckets"] = num_buckets
        graph().add(Node(_KINDS[kind], inputs))


def _write(kind: str, node: Node, execution: int) -> None:
    frames = get_registry().running()
    selection = frames.selection
    if selection is None:
        raise ArgumentError("it runs within step_randomization only")
    view, attribute = get_registry().view(kind, node.inputs["view"]), node.inputs["attribute"]
    rows = [0] if kind == "scene" else selection.rows
    drawn = _drawn(node, execution, rows, view.initial[attribute].shape[1])
    operation = node.inputs["operation"]
    if selection.on_reset:
        view.reset[attribute][list(rows)] = _combined(view, view.initial, operation, attribute, rows, drawn)
        drawn, operation = view.reset[attribute][list(rows)], "direct"
    view.values.write(attribute, rows, _combined(view, view.reset, operation, attribute, rows, drawn))


def _combined(
    view: RegisteredView, base: dict[str, Array], operation: str, attribute: str, rows: Any, drawn: Array
) -> Array:
    if operation == "direct" or attribute == "force":
        return drawn
    start = view.base(base, attribute, rows)
    return start + drawn if operation == "additive" else start * drawn


def _drawn(node: Node, execution: int, rows: Any, width: int) -> Array:
    """Draw values (n, width), one row for each environment."""
    values: Distribution = node.inputs["values"]
    keys = [f"{node.inputs['view']}[{row}]" for row in rows]
    drawn = np.asarray(values.sample(node.key, execution, keys), np.float64).reshape(len(keys), -1)
    if buckets := node.inputs.get("numBuckets"):
        drawn = _bucketed(values, drawn, int(buckets))
    if width % drawn.shape[1]:
        drawn_numbers = counted(drawn.shape[1], "is", "are")
        raise ArgumentError(f"{node.inputs['attribute']} has {counted(width, 'number')}, but {drawn_numbers} drawn")
    return np.tile(drawn, width // drawn.shape[1])


def _bucketed(values: Distribution, drawn: Array, count: int) -> Array:
    """Round values down to the lower ends of `count` equal parts of the distribution's range."""
    inputs = values.node.inputs
    if values.node.kind == "OgnSampleNormal":
        mean, spread = np.asarray(inputs["mean"], np.float64), 2.0 * np.sqrt(np.asarray(inputs["std"], np.float64))
        low, high = mean - spread, mean + spread
    elif "lower" in inputs:
        low, high = np.asarray(inputs["lower"], np.float64), np.asarray(inputs["upper"], np.float64)
    else:
        raise ArgumentError(f"num_buckets: {values.node.describe()} has no range to divide; use uniform or normal")
    size = (high - low) / count
    part = np.clip(np.floor((drawn - low) / np.where(size > 0.0, size, 1.0)), 0, count - 1)
    return low + part * size


def _register(kind: str) -> None:
    @action(_KINDS[kind])
    def write(node: Node, execution: int) -> None:
        _write(kind, node, execution)


for _kind in _KINDS:
    _register(_kind)
