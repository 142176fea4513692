"""PLY files with other polygons than triangles, made into triangles: trimesh reads no binary file that mixes them."""

from __future__ import annotations

import struct

import numpy as np

from usdsdg.meshes.readers.ply_elements import CORNERS, Element, header, row_width, rows_of, with_rows
from usdsdg.meshes.readers.polygons import concave_ones

_BINARY = "format binary_little_endian 1.0"
_PICTURE = "texnumber"  # of a face, among the pictures of the file


def prepared(content: bytes) -> bytes:
    """Return a PLY file with triangles alone; the file itself where it has these already, or cannot be understood."""
    head, mark, body = content.partition(b"end_header")
    body = body.partition(b"\n")[2]
    lines = head.decode("ascii", "replace").splitlines()
    try:
        order, elements = header(lines)
        if not mark or all(each.name != "face" for each in elements):
            return content
        return _cut(lines, order, elements, body) or content
    except (KeyError, IndexError, ValueError, StopIteration, struct.error):
        return content  # trimesh says what is wrong


def by_picture(content: bytes) -> list[bytes]:
    """Return the file once for each of its pictures, with the faces that show it; the file alone where it has one.

    trimesh would show the last one on all faces.
    """
    head, mark, body = content.partition(b"end_header")
    lines = head.decode("ascii", "replace").splitlines()
    pictures = [number for number, line in enumerate(lines) if line.split()[:2] == ["comment", "TextureFile"]]
    if len(pictures) < 2 or not mark:
        return [content]
    body = body.partition(b"\n")[2]
    try:
        order, elements = header(lines)
        faces = next(each for each in elements if each.name == "face")
        before = elements[: elements.index(faces)]
        if not all(each.is_fixed for each in before) or all(each.name != _PICTURE for each in faces.properties):
            return [content]
        start = sum(each.count * row_width(each, order) for each in before)
        text = body.decode("ascii").split() if not order else []
        rows, end = rows_of(faces, order, body, text, start)
        if not order:  # of which trimesh does not read a single face with two lists
            body, order, lines = (
                _binary(before, text),
                "<",
                [_BINARY if each.startswith("format") else each for each in lines],
            )
            start = end = len(body)
            lines = lines[: _end_of(lines, "face")]
    except (KeyError, IndexError, ValueError, StopIteration, struct.error):
        return [content]  # trimesh says what is wrong
    shown = [min(max(int(row[_PICTURE][0]), 0), len(pictures) - 1) for row in rows]
    parts = []
    for picture in sorted(set(shown)):
        head = [line for number, line in enumerate(lines) if number not in pictures or number == pictures[picture]]
        chosen = [row for row, number in zip(rows, shown) if number == picture]
        parts.append(with_rows(head, order, before, faces, chosen, body, (start, end)))
    return parts


def _binary(elements: list[Element], text: list[str]) -> bytes:
    """Return the rows of elements without lists, which are the first words of a text, in little endian."""
    packed, at = [], 0
    for each in elements:
        for _ in range(each.count):
            words = text[at : at + len(each.row)]
            numbers = [float(word) if kind in "fd" else int(float(word)) for kind, word in zip(each.row, words)]
            packed.append(struct.pack("<" + each.row, *numbers))
            at += len(words)
    return b"".join(packed)


def _end_of(lines: list[str], element: str) -> int:
    """Return the line of a head behind an element and its properties."""
    first = next(number for number, line in enumerate(lines) if line.split()[:2] == ["element", element])
    others = (number for number in range(first + 1, len(lines)) if lines[number].split()[:1] == ["element"])
    return next(others, len(lines))


def _cut(lines: list[str], order: str, elements: list[Element], body: bytes) -> bytes | None:
    """Return the file with its polygons cut; None where nothing is to be cut."""
    names = [each.name for each in elements]
    faces = elements[names.index("face")]
    before = elements[: names.index("face")]
    corners = next(each.name for each in faces.properties if each.name in CORNERS and each.count_kind)
    if not all(each.is_fixed for each in before):
        return None
    start = sum(each.count * row_width(each, order) for each in before)
    if order and _are_triangles(faces, order, body, start):
        return None
    text = body.decode("ascii").split() if not order else []
    rows, end = rows_of(faces, order, body, text, start)
    polygons = [[int(each) for each in row[corners]] for row in rows]
    if all(len(each) == 3 for each in polygons):
        return None
    points = _points(before, order, body, text)
    usable = [len(each) >= 3 and min(each) >= 0 and max(each) < len(points) for each in polygons]
    if not all(usable):
        return None
    concave = concave_ones(points, polygons)
    cut = []
    for number, (row, polygon) in enumerate(zip(rows, polygons)):
        triangles = concave[number] if number in concave else [(0, k, k + 1) for k in range(1, len(polygon) - 1)]
        cut += [_corner_values(row, len(polygon), list(map(int, triangle))) for triangle in triangles]
    return with_rows(lines, order, before, faces, cut, body, (start, end))


def _are_triangles(faces: Element, order: str, body: bytes, start: int) -> bool:
    """Whether a binary file has triangles alone, without a look at each row; False where that cannot be said so."""
    lists = [each for each in faces.properties if each.count_kind]
    if len(lists) != 1:
        return False
    kinds: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
    for each in faces.properties:
        if each.count_kind:
            kinds += [("corners", order + each.count_kind), (f"list {each.name}", order + each.kind, (3,))]
        else:
            kinds.append((each.name, order + each.kind))
    row = np.dtype(kinds)
    if len(body) < start + row.itemsize * faces.count:
        return False
    return bool((np.frombuffer(body, row, faces.count, start)["corners"] == 3).all())


def _points(before: list[Element], order: str, body: bytes, text: list[str]) -> np.ndarray:
    """Return the points (V, 3)."""
    start = 0
    for element in before:
        width = row_width(element, order)
        if element.name == "vertex":
            axes = [[each.name for each in element.properties].index(axis) for axis in "xyz"]
            if not order:
                words = np.array(text[start : start + element.count * width]).reshape(-1, width)
                return words[:, axes].astype(np.float64)
            kinds = np.dtype([(str(k), order + each.kind) for k, each in enumerate(element.properties)])
            table = np.frombuffer(body, kinds, element.count, start)
            return np.stack([table[str(axis)].astype(np.float64) for axis in axes], axis=1)
        start += element.count * width
    raise KeyError("vertex")


def _corner_values(row: dict[str, list[float]], corners: int, triangle: list[int]) -> dict[str, list[float]]:
    """Return the values of a triangle: of lists with one or more for each corner those of its own corners."""
    found = {}
    for name, values in row.items():
        per_corner = len(values) // corners if len(values) % corners == 0 else 0
        chosen = [values[k * per_corner + i] for k in triangle for i in range(per_corner)]
        found[name] = chosen if per_corner and len(values) > 1 else values
    return found
