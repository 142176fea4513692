"""`rep.modify.attribute` and `rep.modify.visibility` in many worlds at once."""

from __future__ import annotations

import numpy as np
from pxr import Usd

from usdsdg.distribution import draw_worlds
from usdsdg.errors import ArgumentError, Unsupported
from usdsdg.graph.node import Node
from usdsdg.graph.worlds import in_worlds
from usdsdg.modify.appearance import are_apart
from usdsdg.modify.attributes import attribute_objects, attribute_of, dimension, owners_of
from usdsdg.modify.prims import target_prims
from usdsdg.stage.world_values import WorldValues


@in_worlds("OgnWritePrimAttribute")
def _attributes_in_worlds(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    name, type_name = node.inputs["attribute"], node.inputs.get("attributeType")
    drawn = draw_worlds(node.inputs["value"], node, executions, "value")
    for index, prim in enumerate(target_prims(node)):
        if attribute_objects(prim, name) != [str(prim.GetPath())]:
            raise Unsupported(
                f"{name} of the point instances or prototypes of {prim.GetPath()} cannot differ between worlds"
            )
        for owner in owners_of(prim, name):
            set_in_worlds(attribute_of(owner, name, type_name), drawn[:, index], values, node.describe())


def set_in_worlds(attribute: Usd.Attribute, column: np.ndarray, values: WorldValues, source: str) -> None:
    """Set an attribute to drawn values (worlds, ...), converted as `modify.attribute` converts them.

    Raises:
        Unsupported: the attribute, or what is drawn for it, holds no numbers.
    """
    if column.dtype.kind not in "fiub":
        raise Unsupported(f"{attribute.GetPath()}: only numbers can differ between worlds")
    kind, size = attribute.GetTypeName(), dimension(attribute)
    scalar_size = getattr(type(kind.scalarType.defaultValue), "dimension", 0)
    numbers = np.floor(column) if str(kind.scalarType.cppTypeName) == "int" else column
    if size and numbers.ndim == 1:
        numbers = np.repeat(numbers[:, None], size, axis=1)
    if kind.isArray and numbers.ndim == (2 if scalar_size else 1):
        numbers = numbers[:, None]  # one value is an array of it
    wanted = (1 if kind.isArray else 0) + (1 if scalar_size else 0) + 1
    if numbers.ndim != wanted or (scalar_size and numbers.shape[-1] != scalar_size):
        raise ArgumentError(f"{attribute.GetPath()} of type {kind} does not take {column.shape[1:] or 'one number'}")
    values.set(attribute, np.broadcast_to(numbers, (values.count, *numbers.shape[1:])), source)


@in_worlds("OgnWriteVisibility")
def _visibility_in_worlds(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    prims = target_prims(node)
    if not are_apart(prims):
        raise Unsupported("prims above or below each other, or below a hidden one, cannot be hidden in worlds")
    drawn = draw_worlds(node.inputs["value"], node, executions, "value", patterns=True).astype(bool)
    for index, prim in enumerate(prims):
        values.set_visible(prim, np.broadcast_to(drawn[:, index], values.count), node.describe())
