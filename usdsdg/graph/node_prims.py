"""Write and read graph nodes as OmniGraphNode prims: `inputs:` attributes, targets and connections.

The layout is OmniGraph's: `node:type`, execution from `outputs:execOut` to `inputs:execIn`, samples from
`outputs:samples` of a distribution to the input that draws from it, target prims in the relationship `inputs:prims`.
Values that OmniGraph has no attribute for are under `usdsdg:`.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pxr import Gf, Sdf, Usd, Vt

from usdsdg.stage.scopes import PIPELINE, REPLICATOR, define_scope

TYPE_PREFIX = "omni.replicator.core."
# Types that are OmniGraph's own.
_OMNIGRAPH = {"OnCustomEvent": "omni.graph.action.OnCustomEvent", "OnImpulseEvent": "omni.graph.action.OnImpulseEvent"}

_SCALARS = {bool: Sdf.ValueTypeNames.Bool, int: Sdf.ValueTypeNames.Int64, float: Sdf.ValueTypeNames.Double}
_VECTORS = {
    (int, 2): (Sdf.ValueTypeNames.Int2, Gf.Vec2i),
    (int, 3): (Sdf.ValueTypeNames.Int3, Gf.Vec3i),
    (int, 4): (Sdf.ValueTypeNames.Int4, Gf.Vec4i),
    (float, 2): (Sdf.ValueTypeNames.Double2, Gf.Vec2d),
    (float, 3): (Sdf.ValueTypeNames.Double3, Gf.Vec3d),
    (float, 4): (Sdf.ValueTypeNames.Double4, Gf.Vec4d),
}
_ARRAYS: dict[tuple[type | None, int], tuple[Sdf.ValueTypeName, type]] = {
    (float, 2): (Sdf.ValueTypeNames.Double2Array, Vt.Vec2dArray),
    (float, 3): (Sdf.ValueTypeNames.Double3Array, Vt.Vec3dArray),
    (float, 4): (Sdf.ValueTypeNames.Double4Array, Vt.Vec4dArray),
}
_VECTOR_TYPES = (Gf.Vec2i, Gf.Vec3i, Gf.Vec4i, Gf.Vec2d, Gf.Vec3d, Gf.Vec4d)


@dataclass(frozen=True)
class Link:
    """An input whose values come from another node's `outputs:samples`."""

    path: str


@dataclass
class NodeRecord:
    """The content of a node prim; `kind` is the type without Replicator's prefix."""

    kind: str
    inputs: dict[str, Any] = field(default_factory=dict)  # plain values, or lists of them, or Links
    prims: tuple[str, ...] = ()
    after: str | None = None  # path of the node whose execution starts this one
    metadata: dict[str, str] = field(default_factory=dict)  # under `usdsdg:`


def type_name(kind: str) -> str:
    """Return the type of nodes in full, as OmniGraph names it."""
    return _OMNIGRAPH.get(kind, TYPE_PREFIX + kind)


def define_node(stage: Usd.Stage, path: str, node: NodeRecord) -> Usd.Prim:
    """Author a node at a free path below a graph.

    Raises:
        TypeError: an input is of a type that USD cannot hold; the message names it.
    """
    prim = stage.DefinePrim(path, "OmniGraphNode")
    _attribute(prim, "node:type", Sdf.ValueTypeNames.Token, type_name(node.kind))
    _attribute(prim, "node:typeVersion", Sdf.ValueTypeNames.Int, 1)
    for name, value in node.inputs.items():
        write_input(prim, name, value)
    if node.prims:
        prim.CreateRelationship("inputs:prims", custom=False).SetTargets([Sdf.Path(path) for path in node.prims])
    if node.after:
        started = _attribute(prim, "inputs:execIn", Sdf.ValueTypeNames.UInt)
        started.SetConnections([Sdf.Path(node.after).AppendProperty("outputs:execOut")])
    for name, text in node.metadata.items():
        _attribute(prim, f"usdsdg:{name}", Sdf.ValueTypeNames.String, text)
    return prim


def define_graph(stage: Usd.Stage) -> Usd.Prim:
    """Return the graph prim; author it with OmniGraph's evaluation attributes if there is none."""
    prim = stage.GetPrimAtPath(PIPELINE)
    if prim and prim.GetTypeName() == "OmniGraph":
        return prim
    define_scope(stage, REPLICATOR)
    prim = stage.DefinePrim(PIPELINE, "OmniGraph")
    _attribute(prim, "evaluator:type", Sdf.ValueTypeNames.Token, "execution")
    _attribute(prim, "pipelineStage", Sdf.ValueTypeNames.Token, "pipelineStageSimulation")
    return prim


def write_input(prim: Usd.Prim, name: str, value: Any) -> None:
    """Author `inputs:<name>`; a list with Links becomes one attribute per element, `inputs:<name>:i<index>`.

    Raises:
        TypeError: as for `define_node`.
    """
    if isinstance(value, Link):
        drawn = _attribute(prim, f"inputs:{name}", Sdf.ValueTypeNames.Token)
        drawn.SetConnections([Sdf.Path(value.path).AppendProperty("outputs:samples")])
    elif isinstance(value, (list, tuple)) and any(isinstance(each, Link) for each in value):
        for index, each in enumerate(value):
            write_input(prim, f"{name}:i{index}", each)
    else:
        type_name, usd_value, is_json = _encoded(prim, name, value)
        attribute = _attribute(prim, f"inputs:{name}", type_name, usd_value)
        if attribute.HasAuthoredConnections():
            attribute.ClearConnections()
        if is_json:
            attribute.SetCustomDataByKey("usdsdg:json", True)
        else:
            attribute.ClearCustomDataByKey("usdsdg:json")


def read_node(prim: Usd.Prim) -> NodeRecord:
    """Read a node prim: the inverse of `define_node`."""
    kind = str(prim.GetAttribute("node:type").Get()).rsplit(".", 1)[-1]
    node = NodeRecord(kind, prims=tuple(map(str, prim.GetRelationship("inputs:prims").GetTargets())))
    for attribute in prim.GetAuthoredAttributes():
        space, _, name = attribute.GetName().partition(":")
        sources = attribute.GetConnections()
        if name == "execIn":
            node.after = str(sources[0].GetPrimPath()) if sources else None
        elif space == "inputs":
            value = Link(str(sources[0].GetPrimPath())) if sources else decoded(attribute)
            _put(node.inputs, name, value)
        elif space == "usdsdg":
            node.metadata[name] = str(attribute.Get())
    return node


def _put(inputs: dict[str, Any], name: str, value: Any) -> None:
    """Store an input; `choices:i0`, `choices:i1`, ... are the elements of one list."""
    whole, _, index = name.rpartition(":i")
    if whole and index.isdigit():
        inputs.setdefault(whole, []).append(value)
    else:
        inputs[name] = value


def _attribute(prim: Usd.Prim, name: str, type_name: Sdf.ValueTypeName, value: Any = None) -> Usd.Attribute:
    attribute = prim.GetAttribute(name)
    if not attribute:
        attribute = prim.CreateAttribute(name, type_name, custom=not name.startswith(("inputs:", "node:")))
    elif attribute.GetTypeName() != type_name:
        # An input that is set anew, such as bounds that were whole numbers; the old value does not fit the new type.
        attribute.Clear()
        attribute.SetTypeName(type_name)
    if value is not None:
        attribute.Set(value)
    return attribute


def _encoded(prim: Usd.Prim, name: str, value: Any) -> tuple[Sdf.ValueTypeName, Any, bool]:
    """Return USD type, USD value, and whether the value is JSON because USD has no such type."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if type(value) in _SCALARS:
        return _SCALARS[type(value)], value, False
    if isinstance(value, str):
        return Sdf.ValueTypeNames.String, value, False
    if isinstance(value, Sequence) and value:
        if all(isinstance(each, str) for each in value):
            return Sdf.ValueTypeNames.StringArray, list(value), False
        kind = _number_kind(value)
        if kind is not None and isinstance(value, tuple) and (kind, len(value)) in _VECTORS:
            type_name, make = _VECTORS[kind, len(value)]
            return type_name, make(*value), False
        if kind is float:
            return Sdf.ValueTypeNames.DoubleArray, Vt.DoubleArray(list(value)), False
        rows = [each for each in value if isinstance(each, (list, tuple))]
        sizes = {(_number_kind(row), len(row)) for row in rows}
        if len(rows) == len(value) and len(sizes) == 1 and next(iter(sizes)) in _ARRAYS:
            type_name, make = _ARRAYS[next(iter(sizes))]
            return type_name, make([tuple(map(float, row)) for row in rows]), False
    try:
        return Sdf.ValueTypeNames.String, json.dumps(value, default=_json_value), True
    except TypeError as error:
        raise TypeError(f"input {name!r} of {prim.GetPath()} cannot be saved: {error}") from None


def _json_value(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, _VECTOR_TYPES) or hasattr(type(value), "dimension"):
        return list(value)
    if hasattr(value, "GetImaginary"):
        return [value.GetReal(), *value.GetImaginary()]
    raise TypeError(f"{type(value).__name__} is a Python object, not data")


def _number_kind(values: Sequence[Any]) -> type | None:
    kinds = {type(each) for each in values}
    if kinds == {int}:
        return int
    return float if kinds and kinds <= {int, float} else None


def decoded(attribute: Usd.Attribute) -> Any:
    """Return the value of an input as a node has it: the inverse of `write_input`."""
    value = attribute.Get()
    if attribute.GetCustomDataByKey("usdsdg:json"):
        return json.loads(value)
    if isinstance(value, _VECTOR_TYPES):
        return tuple(value)
    if isinstance(value, (Vt.StringArray, Vt.DoubleArray)):
        return list(value)
    if isinstance(value, (Vt.Vec2dArray, Vt.Vec3dArray, Vt.Vec4dArray)):
        return [tuple(row) for row in value]
    return value
