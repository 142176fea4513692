"""Edits of a stage as the text of a layer."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pxr import Gf, Sdf

from usdsdg.operating_system import around_fork

# Attribute, its type and value, or relationship, None and its targets.
Edit = tuple[Sdf.Path, Any, Any]
Property = tuple[Sdf.Path, Any]  # of an edit, with its type

_PLAIN = re.compile(r"[\w:./ -]*", re.ASCII)  # texts that stand in a layer as they are


class EditsText:
    """Writes the text of layers that have some edits alone.

    From frame to frame the same properties have other values, so the text around the values is kept and they are
    formatted into it. USD's export of a layer takes three times as long, in which no other thread runs Python.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Begin anew, as in a forked process, whose parent may have been writing."""
        self._lock = threading.Lock()
        self._properties: list[Property] | None = None  # of the latest edits, None if they failed
        self._template: _Template | None = None  # of these properties, unless it does not fit
        self._layer = _EditLayer()

    def of(self, edits: Sequence[Edit]) -> str:
        """Return the text of a layer with these edits alone."""
        with self._lock:
            properties = [edit[:2] for edit in edits]
            are_new, self._properties = properties != self._properties, None
            text = self._text_of_new(properties, edits) if are_new else self._text_of_known(edits)
            self._properties = properties
            return text

    def _text_of_known(self, edits: Sequence[Edit]) -> str:
        text = self._template.text_of(edits) if self._template is not None else None
        return self._layer.text_of(edits) if text is None else text

    def _text_of_new(self, properties: Sequence[Property], edits: Sequence[Edit]) -> str:
        self._layer.make(properties)
        text, template = self._layer.text_of(edits), _Template(properties)
        # Where it makes another text than USD, as of types that it does not know, it is not used.
        self._template = template if template.text_of(edits) == text else None
        return text


class _Template:
    """The text of some properties, with places for their values."""

    def __init__(self, properties: Sequence[Property]) -> None:
        root = _Over()
        for index, (path, kind) in enumerate(properties):
            root.at(path.GetPrimPath()).properties.append((path.name, kind, index))
        self._order: list[int] = []  # of the properties, as their values stand in the text
        self._kinds: list[Any] = []
        pieces = ["#usda 1.0\n"]
        self._add(root, "", pieces)
        self._text = "".join(pieces) + "\n"

    def _add(self, over: _Over, indent: str, pieces: list[str]) -> None:
        for name, kind, index in sorted(over.properties, key=lambda each: each[0]):
            pieces.append(f"{indent}{kind} {name} = %s\n")
            self._order.append(index)
            self._kinds.append(kind)
        for name, child in over.children.items():
            is_first = pieces[-1].endswith("{\n")
            pieces.append(("" if is_first else "\n") + f'{indent}over "{name}"\n{indent}{{\n')
            self._add(child, f"{indent}    ", pieces)
            pieces.append(f"{indent}}}\n")

    def text_of(self, edits: Sequence[Edit]) -> str | None:
        """Return the text with the values of these edits; None where one of them is of a type that is not known."""
        values = [edits[index][2] for index in self._order]
        texts = [_value_text(value, kind) for value, kind in zip(values, self._kinds)]
        return None if None in texts else self._text % tuple(texts)


class _Over:
    """A prim of the text."""

    def __init__(self) -> None:
        self.properties: list[tuple[str, Any, int]] = []  # names, types and indices
        self.children: dict[str, _Over] = {}

    def at(self, path: Sdf.Path) -> _Over:
        """Return the prim at a path, which is added with its ancestors."""
        if path.isEmpty or path == Sdf.Path.absoluteRootPath:
            return self
        return self.at(path.GetParentPath()).children.setdefault(path.name, _Over())


class _EditLayer:
    """A layer that serves all moments: those that end leave the handles of their specs in memory (USD 26.11)."""

    def __init__(self) -> None:
        self._layer: Sdf.Layer | None = None
        self._specs: list[Sdf.PropertySpec] = []  # in the order in which they were made

    def make(self, properties: Sequence[Property]) -> None:
        """Make these properties in place of those that are there."""
        self._layer = layer = self._layer or Sdf.Layer.CreateAnonymous(".usda")
        with Sdf.ChangeBlock():
            layer.Clear()
            self._specs = [_spec(layer, *each) for each in properties]

    def text_of(self, edits: Sequence[Edit]) -> str:
        """Return the text of the layer with edits of the properties that were made, in their order."""
        assert self._layer is not None
        with Sdf.ChangeBlock():
            for spec, (_, kind, value) in zip(self._specs, edits, strict=True):
                if kind is None:
                    spec.targetPathList.explicitItems = value
                else:
                    spec.default = value
        return self._layer.ExportToString()


def _spec(layer: Sdf.Layer, path: Sdf.Path, kind: Any) -> Sdf.PropertySpec:
    """Make an attribute of a type, or a relationship."""
    if kind is None:
        return Sdf.RelationshipSpec(Sdf.CreatePrimInLayer(layer, path.GetPrimPath()), path.name, custom=False)
    Sdf.JustCreatePrimAttributeInLayer(layer, path, kind)
    return layer.GetAttributeAtPath(path)


def _value_text(value: Any, kind: Any) -> str | None:
    """Return a value as USD writes it into a layer; None where that is not known."""
    of_type = _TEXTS.get(type(value))
    return None if of_type is None else of_type(value, kind)


def _as_printed(value: Any, kind: Any) -> str:
    return str(value)


def _number(value: float, kind: Any) -> str | None:
    """Return a number as that stands in a vector, which has as many digits as its type needs."""
    vector = _VECTORS.get(str(kind))
    return None if vector is None else str(vector(value, 0.0))[1:].partition(",")[0]


def _whole(value: int, kind: Any) -> str | None:
    return str(int(value))


def _quoted(value: str, kind: Any) -> str | None:
    return f'"{value}"' if str(kind) in ("token", "string") and _PLAIN.fullmatch(value) else None


_VECTORS: Mapping[str, Callable[[float, float], Any]] = {"double": Gf.Vec2d, "float": Gf.Vec2f, "half": Gf.Vec2h}
_PRINTED = (
    Gf.Vec2d, Gf.Vec2f, Gf.Vec2h, Gf.Vec2i, Gf.Vec3d, Gf.Vec3f, Gf.Vec3h, Gf.Vec3i, Gf.Vec4d, Gf.Vec4f, Gf.Vec4h,
    Gf.Vec4i, Gf.Quatd, Gf.Quatf, Gf.Quath, Gf.Matrix2d, Gf.Matrix3d, Gf.Matrix4d,
)  # fmt: skip
_TEXTS: Mapping[type, Callable[[Any, Any], str | None]] = {
    **dict.fromkeys(_PRINTED, _as_printed), float: _number, bool: _whole, int: _whole, str: _quoted
}  # fmt: skip


edits_text = EditsText()
around_fork(in_child=edits_text.forget)
