"""Elements of PLY files: what the head tells of them, and their rows, read and written."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

_KINDS = {
    "char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H", "uint16": "H",
    "int": "i", "int32": "i", "uint": "I", "uint32": "I", "float": "f", "float32": "f", "double": "d", "float64": "d",
}  # fmt: skip
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
CORNERS = ("vertex_indices", "vertex_index")  # names of the list of a face


class Property(NamedTuple):
    """A value, or a list of values, that each row of an element has."""

    name: str
    kind: str  # as `struct` calls it
    count_kind: str = ""  # of a list


@dataclass
class Element:
    """A table of a file, such as its vertices or faces."""

    name: str
    count: int
    properties: list[Property]

    @property
    def is_fixed(self) -> bool:
        """Whether all rows are of one width: none of the properties is a list."""
        return not any(each.count_kind for each in self.properties)

    @property
    def row(self) -> str:
        """The kinds of one row without lists."""
        return "".join(each.kind for each in self.properties)


def header(lines: list[str]) -> tuple[str, list[Element]]:
    """Return the order of bytes that the head of a file tells, as `struct` calls it, "" of a text; and the elements."""
    order, elements = "", []
    for words in map(str.split, lines):
        if words[:1] == ["format"]:
            order = _ORDERS[words[1]]
        elif words[:1] == ["element"]:
            elements.append(Element(words[1], int(words[2]), []))
        elif words[:2] == ["property", "list"]:
            elements[-1].properties.append(Property(words[4], _KINDS[words[3]], _KINDS[words[2]]))
        elif words[:1] == ["property"]:
            elements[-1].properties.append(Property(words[2], _KINDS[words[1]]))
    return order, elements


def row_width(element: Element, order: str) -> int:
    """Bytes of a row without lists; in a text its words."""
    return struct.calcsize(order + element.row) if order else len(element.properties)


def rows_of(
    faces: Element, order: str, body: bytes, text: list[str], start: int
) -> tuple[list[dict[str, list[float]]], int]:
    """Return the values of each face by property, one or a list, and where they end."""
    rows, at = [], start
    for _ in range(faces.count):
        row: dict[str, list[float]] = {}
        for each in faces.properties:
            count = 1
            if each.count_kind and order:
                [count] = struct.unpack_from(order + each.count_kind, body, at)
                at += struct.calcsize(order + each.count_kind)
            elif each.count_kind:
                count, at = int(text[at]), at + 1
            if order:
                form = f"{order}{count}{each.kind}"
                row[each.name] = list(struct.unpack_from(form, body, at))
                at += struct.calcsize(form)
            else:
                row[each.name] = [float(word) for word in text[at : at + count]]
                at += count
        rows.append(row)
    return rows, at


def with_rows(
    lines: list[str],
    order: str,
    before: list[Element],
    faces: Element,
    rows: list[dict[str, list[float]]],
    body: bytes,
    span: tuple[int, int],
) -> bytes:
    """Return a file with other faces.

    lines: of its head. before: the elements before the faces, which are at `span` of the body.
    """
    counted = ["element", faces.name]
    head = [f"element {faces.name} {len(rows)}" if line.split()[:2] == counted else line for line in lines]
    written = "\n".join([*head, "end_header", ""]).encode()
    if not order:
        kept, first = body.decode("ascii").splitlines(), sum(each.count for each in before)
        kept[first : first + faces.count] = [" ".join(_words(faces, row)) for row in rows]
        return written + "\n".join([*kept, ""]).encode()
    return written + body[: span[0]] + b"".join(_packed(faces, order, row) for row in rows) + body[span[1] :]


def _packed(faces: Element, order: str, row: dict[str, list[float]]) -> bytes:
    parts = []
    for each in faces.properties:
        values = row[each.name] if each.kind in "fd" else list(map(int, row[each.name]))
        head = struct.pack(order + each.count_kind, len(values)) if each.count_kind else b""
        parts.append(head + struct.pack(f"{order}{len(values)}{each.kind}", *values))
    return b"".join(parts)


def _words(faces: Element, row: dict[str, list[float]]) -> Iterator[str]:
    for each in faces.properties:
        values = row[each.name]
        if each.count_kind:
            yield str(len(values))
        yield from (repr(value) if each.kind in "fd" else str(int(value)) for value in values)
