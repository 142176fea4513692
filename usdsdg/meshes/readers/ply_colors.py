"""Colors of PLY files, by the names and in the bytes that trimesh reads: it drops the upper bytes of longer numbers."""

from __future__ import annotations

import re
import struct
from typing import NamedTuple

import numpy as np

from usdsdg.meshes.readers.ply_elements import Element, Property, header, row_width, rows_of, with_rows

_COLORS = ("red", "green", "blue", "alpha")
_OLD = re.compile(rb"^(property +\w+ +)diffuse_(red|green|blue|alpha)\b", re.MULTILINE)
_INTEGERS = "hHiI"  # longer than a byte, as `struct` calls them


class _Place(NamedTuple):
    """An element of a file, and where it begins."""

    lines: list[str]  # of the head
    order: str
    before: list[Element]
    element: Element
    body: bytes


def prepared(content: bytes) -> bytes:
    """Return a PLY file whose colors trimesh reads: from `r`, `diffuse_red` and the like, and from 16 or 32 bits.

    A file that cannot be understood is returned as it is.
    """
    head, mark, body = content.partition(b"end_header")
    content = _renamed(_OLD.sub(rb"\1\2", head)) + mark + body
    for name in ("face", "vertex"):
        try:
            place = _place(content, name)
            content = content if place is None else _with_bytes(place)
        except (KeyError, IndexError, ValueError, StopIteration, struct.error):
            continue  # trimesh says what is wrong
    return content


def _renamed(head: bytes) -> bytes:
    """Give colors their full names where they have initials."""
    lines = head.split(b"\n")
    words = [line.split() for line in lines]
    starts = [number for number, each in enumerate(words) if each[:1] == [b"element"]]
    for start, end in zip(starts, [*starts[1:], len(lines)]):
        names = [each[-1] if each[:1] == [b"property"] else b"" for each in words[start:end]]
        if not {b"r", b"g", b"b"} <= set(names) or b"red" in names:
            continue
        for number, name in enumerate(names, start):
            full = next((each for each in _COLORS if name == each[:1].encode()), None)
            if full is not None:
                lines[number] = b" ".join([*words[number][:-1], full.encode()])
    return b"\n".join(lines)


def _place(content: bytes, name: str) -> _Place | None:
    """Return an element; None where it is missing, has no long colors, or cannot be found."""
    head, mark, body = content.partition(b"end_header")
    lines = head.decode("ascii", "replace").splitlines()
    order, elements = header(lines)
    number = next((k for k, each in enumerate(elements) if each.name == name), None)
    if not mark or number is None or not any(map(_is_long, elements[number].properties)):
        return None
    before = elements[:number]
    if not all(each.is_fixed for each in before):
        return None
    return _Place(lines, order, before, elements[number], body.partition(b"\n")[2])


def _is_long(given: Property) -> bool:
    return given.name in _COLORS and not given.count_kind and given.kind in _INTEGERS


def _with_bytes(place: _Place) -> bytes:
    """Return the file with the colors of an element in bytes."""
    lines, order, before, element, body = place
    start = sum(each.count * row_width(each, order) for each in before)
    names = [each.name for each in element.properties if _is_long(each)]
    if order and element.is_fixed:  # of which there may be millions
        head = "\n".join([*_with_kinds(lines, element.name, names), "end_header", ""]).encode()
        end = start + element.count * row_width(element, order)
        return head + body[:start] + _table_with_bytes(element, order, body, start, names) + body[end:]
    rows, end = rows_of(element, order, body, body.decode("ascii").split() if not order else [], start)
    colors = _as_bytes(np.array([[row[name][0] for name in names] for row in rows]), element, names)
    for row, values in zip(rows, colors.tolist()):
        row.update({name: [value] for name, value in zip(names, values)})
    properties = [each._replace(kind="B") if each.name in names else each for each in element.properties]
    changed = Element(element.name, element.count, properties)
    return with_rows(_with_kinds(lines, element.name, names), order, before, changed, rows, body, (start, end))


def _table_with_bytes(element: Element, order: str, body: bytes, start: int, names: list[str]) -> bytes:
    kinds = {each.name: order + each.kind for each in element.properties}
    if len(kinds) < len(element.properties):
        raise ValueError("a property is there twice")
    table = np.frombuffer(body, np.dtype(list(kinds.items())), element.count, start)
    changed = np.empty(len(table), np.dtype([(each, "u1" if each in names else kind) for each, kind in kinds.items()]))
    for each in kinds.keys() - set(names):
        changed[each] = table[each]
    colors = _as_bytes(np.stack([table[each].astype(np.float64) for each in names], axis=1), element, names)
    for each, values in zip(names, colors.T):
        changed[each] = values
    return changed.tobytes()


def _as_bytes(colors: np.ndarray, element: Element, names: list[str]) -> np.ndarray:
    """(N, C) numbers from 0 to 255."""
    top = _top(colors, {each.kind for each in element.properties if each.name in names})
    return np.round(np.clip(colors / top, 0.0, 1.0) * 255.0)


def _top(colors: np.ndarray, kinds: set[str]) -> float:
    """Return which number is full color: up to 255 they were bytes, whatever the file calls them."""
    largest = colors.max(initial=0)
    if largest <= 255:
        return 255.0
    if largest <= 65535 and kinds != {"h"}:
        return 65535.0
    return float(max(np.iinfo(np.dtype(kind)).max for kind in kinds))


def _with_kinds(lines: list[str], element: str, names: list[str]) -> list[str]:
    found, current = [], ""
    for line in lines:
        words = line.split()
        if words[:1] == ["element"]:
            current = words[1]
        is_color = current == element and words[:1] == ["property"] and words[-1] in names
        found.append(f"property uchar {words[-1]}" if is_color else line)
    return found
