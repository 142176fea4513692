"""FBX files made by code, as text and as binary: a square with UVs, colors of points, a material and its pictures."""

from __future__ import annotations

import base64
import struct
from typing import Any

Node = tuple[str, list[Any], list[Any]]  # name, properties, nodes below

_MESH, _MODEL, _MATERIAL = 1001, 1002, 1003
_OBJECTS = ("Geometry", "Model", "Material", "Texture", "Video")
_SEPARATOR = b"\x00\x01"


class Array(list[float]):
    """An array of numbers, all whole or all floats."""


def square(
    pictures: dict[str, tuple[str, bytes | None]],
    *,
    colors: list[float] | None = None,
    material: dict[str, list[float]] | None = None,
    scaling: float = 1.0,
) -> list[Node]:
    """A square of 2 m by 1 m, in centimeters and Y up.

    Args:
        pictures: by the property of the material that they are connected to, their name and what the file holds of
            them; None = nothing.
        colors: RGBA of the points; None = none.
        material: properties of the material; None = no material.
        scaling: of the UVs of all pictures.
    """
    objects = [_mesh(colors, has_material=material is not None)]
    objects.append(_node("Model", _MODEL, "Model::Square", "Mesh", below=[_node("Version", 232)]))
    links = [_node("C", "OO", _MODEL, 0), _node("C", "OO", _MESH, _MODEL)]
    if material is not None:
        given = [_value(name, "Color" if len(value) == 3 else "Number", *value) for name, value in material.items()]
        own = [_node("Version", 102), _node("ShadingModel", "phong"), _node("Properties70", below=given)]
        objects.append(_node("Material", _MATERIAL, "Material::Paint", "", below=own))
        links.append(_node("C", "OO", _MATERIAL, _MODEL))
    for number, (input_name, (name, content)) in enumerate(pictures.items()):
        texture, video = 2001 + 2 * number, 2002 + 2 * number
        relative = _node("RelativeFilename", f"maps\\{name}")
        tiles = _node("Properties70", below=[_value("Scaling", "Vector", scaling, scaling, 1.0)])
        own = [_node("Type", "TextureVideoClip"), tiles, _node("FileName", f"C:\\work\\{name}"), relative]
        objects.append(_node("Texture", texture, f"Texture::{name}", "", below=own))
        own = [_node("Type", "Clip"), _node("Filename", f"C:\\work\\{name}"), relative]
        own += [] if content is None else [_node("Content", content)]
        objects.append(_node("Video", video, f"Video::{name}", "Clip", below=own))
        links += [_node("C", "OP", texture, _MATERIAL, input_name), _node("C", "OO", video, texture)]
    signs = [_value(f"{axis}AxisSign", "int", 1) for axis in ("Up", "Front", "Coord")]
    axes = [_value(f"{axis}Axis", "int", number) for axis, number in (("Up", 1), ("Front", 2), ("Coord", 0))]
    settings = _node("Properties70", below=[*axes, *signs, _value("UnitScaleFactor", "double", 1.0)])
    return [
        _node("FBXHeaderExtension", below=[_node("FBXHeaderVersion", 1003), _node("FBXVersion", 7400)]),
        _node("GlobalSettings", below=[_node("Version", 1000), settings]),
        _node("Objects", below=objects),
        _node("Connections", below=links),
    ]


def _mesh(colors: list[float] | None, *, has_material: bool) -> Node:
    below = [
        _node("Vertices", Array([0.0, 0.0, 0.0, 200.0, 0.0, 0.0, 200.0, 100.0, 0.0, 0.0, 100.0, 0.0])),
        _node("PolygonVertexIndex", Array([0, 1, 2, -4])),
        _node("GeometryVersion", 124),
        _layer("UV", "ByPolygonVertex", "Direct", _node("UV", Array([0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]))),
    ]
    if colors is not None:
        below.append(_layer("Color", "ByPolygonVertex", "Direct", _node("Colors", Array(colors))))
    if has_material:
        below.append(_layer("Material", "AllSame", "IndexToDirect", _node("Materials", Array([0]))))
    parts = [name for name, _, _ in below if name.startswith("LayerElement")]
    elements = [_node("LayerElement", below=[_node("Type", part), _node("TypedIndex", 0)]) for part in parts]
    below.append(_node("Layer", 0, below=[_node("Version", 100), *elements]))
    return _node("Geometry", _MESH, "Geometry::Square", "Mesh", below=below)


def _layer(kind: str, mapping: str, reference: str, values: Node) -> Node:
    below = [_node("Version", 101), _node("Name", kind), _node("MappingInformationType", mapping)]
    below += [_node("ReferenceInformationType", reference), values]
    return _node(f"LayerElement{kind}", 0, below=below)


def _value(name: str, kind: str, *values: float) -> Node:
    return _node("P", name, kind, "", "A", *values)


def _node(name: str, *properties: Any, below: list[Node] | None = None) -> Node:
    return name, list(properties), below or []


def as_text(nodes: list[Node]) -> bytes:
    """Return a file as text."""
    return b"; FBX 7.4.0 project file\n" + b"".join(_text(node, 0) for node in nodes)


def _text(node: Node, depth: int) -> bytes:
    name, properties, below = node
    tabs = b"\t" * depth
    if len(properties) == 1 and isinstance(properties[0], Array):
        values = ",".join(map(repr, properties[0])).encode()
        return tabs + b"%s: *%d {\n%s\ta: %s\n%s}\n" % (name.encode(), len(properties[0]), tabs, values, tabs)
    if len(properties) == 1 and isinstance(properties[0], bytes):
        return tabs + name.encode() + b": ,\n" + tabs + b'"' + base64.b64encode(properties[0]) + b'"\n'
    words = ", ".join(f'"{each}"' if isinstance(each, str) else repr(each) for each in properties).encode()
    line = tabs + name.encode() + b": " + words
    if not below:
        return line + b"\n"
    return line + b" {\n" + b"".join(_text(each, depth + 1) for each in below) + tabs + b"}\n"


def as_binary(nodes: list[Node], version: int) -> bytes:
    """Return a binary file; from version 7500 on its records have numbers of 64 bits."""
    body = b"Kaydara FBX Binary  \x00\x1a\x00" + struct.pack("<I", version)
    head = struct.Struct("<QQQB" if version >= 7500 else "<IIIB")
    for node in nodes:
        body += _record(node, len(body), head)
    return body + bytes(head.size) + bytes(160)


def _record(node: Node, start: int, head: struct.Struct) -> bytes:
    name, properties, below = node
    has_ids = name == "C" or name in _OBJECTS
    if name in _OBJECTS:  # their names are the other way round
        kind, _, own = properties[1].partition("::")
        properties = [properties[0], own.encode() + _SEPARATOR + kind.encode(), *properties[2:]]
    packed = b"".join(_property(each, is_raw=name == "Content", is_id=has_ids) for each in properties)
    content = name.encode() + packed
    for each in below:
        content += _record(each, start + head.size + len(content), head)
    if below:
        content += bytes(head.size)
    return head.pack(start + head.size + len(content), len(properties), len(packed), len(name)) + content


def _property(value: Any, *, is_raw: bool, is_id: bool) -> bytes:
    if isinstance(value, Array):
        is_whole = all(isinstance(each, int) for each in value)
        data = struct.pack(f"<{len(value)}{'i' if is_whole else 'd'}", *value)
        return (b"i" if is_whole else b"d") + struct.pack("<III", len(value), 0, len(data)) + data
    if isinstance(value, (str, bytes)):
        data = value.encode() if isinstance(value, str) else value
        return (b"R" if is_raw else b"S") + struct.pack("<I", len(data)) + data
    if isinstance(value, float):
        return b"D" + struct.pack("<d", value)
    return b"L" + struct.pack("<q", value) if is_id else b"I" + struct.pack("<i", value)
