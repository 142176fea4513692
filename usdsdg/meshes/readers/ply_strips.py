"""Strips of triangles in PLY files, as Stanford's scans have them, made into triangles: trimesh reads none."""

from __future__ import annotations

import struct

import numpy as np

from usdsdg.meshes.readers.ply_elements import CORNERS, Element, header, row_width, rows_of, with_rows

_STRIPS = "tristrips"


def prepared(content: bytes) -> bytes:
    """Return a PLY file with triangles in place of its strips; the file itself where it has none."""
    head, mark, body = content.partition(b"end_header")
    if not mark or b"element tristrips" not in head:
        return content
    lines = head.decode("ascii", "replace").splitlines()
    body = body.partition(b"\n")[2]
    try:
        order, elements = header(lines)
        names = [each.name for each in elements]
        strips = elements[names.index(_STRIPS)]
        before = elements[: names.index(_STRIPS)]
        corners = next(each.name for each in strips.properties if each.name in CORNERS and each.count_kind)
        if "face" in names or not all(each.is_fixed for each in before):
            return content
        start = sum(each.count * row_width(each, order) for each in before)
        text = body.decode("ascii").split() if not order else []
        rows, end = rows_of(strips, order, body, text, start)
        found = [
            {**row, corners: triangle} for row in rows for triangle in _triangles(np.array(row[corners], np.int64))
        ]
    except (KeyError, IndexError, ValueError, StopIteration, struct.error):
        return content  # trimesh says what is wrong
    named = ["element face 0" if line.split()[:2] == ["element", _STRIPS] else line for line in lines]
    faces = Element("face", strips.count, strips.properties)
    return with_rows(named, order, before, faces, found, body, (start, end))


def _triangles(strip: np.ndarray) -> list[list[float]]:
    """Return the corners of the triangles of strips, between which there is -1; every other one is turned."""
    begins = np.flatnonzero(strip < 0) + 1
    at = np.arange(len(strip))
    place = at - np.concatenate([[0], begins])[np.searchsorted(begins, at, side="right")]
    triangles = np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1) if len(strip) > 2 else np.zeros((0, 3), int)
    turned = place[: len(triangles)] % 2 == 1
    triangles[turned] = triangles[turned][:, [1, 0, 2]]
    a, b, c = triangles.T
    # Strips turn a corner by an index that they repeat.
    return triangles[(triangles >= 0).all(axis=1) & (a != b) & (b != c) & (c != a)].tolist()
