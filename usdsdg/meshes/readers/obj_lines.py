"""Lines of OBJ files in the form that trimesh reads: no tabs, indents and relative indices, one form of corners."""

from __future__ import annotations

import re

import numpy as np

from usdsdg.meshes.readers.polygons import concave_ones

_KEYS = rb"(?:vt|vn|v|f|usemtl|mtllib|o|g|s)"
_INDENTED = re.compile(rb"^ +(?=" + _KEYS + rb" )", re.MULTILINE)
_COMMENTED = re.compile(rb"^((?:v|vt|vn|f) [^#\n]*)#[^\n]*", re.MULTILINE)
_COLORED = re.compile(rb"^v(?: +[^\s#]+){6}", re.MULTILINE)
_POLYGON = re.compile(rb"^f(?: +[-\d/]+){4,} *\r?$", re.MULTILINE)
# A face with an index that counts from the last line before it (negative), or with 0, which is none.
_RELATIVE = re.compile(rb"^f (?:.*[ /])?(?:-\d|0+(?:[ /\r]|$))", re.MULTILINE)
_CORNER = re.compile(rb"^f +(\S+)", re.MULTILINE)
# Corners of each form: with UVs and a normal, with one of them, a point alone.
_FORMS = (rb"\d+/\d+/\d+", rb"\d+//\d+", rb"\d+/\d+/?", rb"\d+/?/?")


def plain_lines(content: bytes) -> tuple[bytes, list[str]]:
    """Return the text of an OBJ file as trimesh reads it, and notes of what is left out."""
    if b"\n" not in content:
        content = content.replace(b"\r", b"\n")
    if b"\t" in content:
        content = content.replace(b"\t", b" ")
    if content[:1] == b" " or b"\n " in content:
        content = _INDENTED.sub(b"", content)
    if _has_comments_behind_values(content):
        content = _COMMENTED.sub(rb"\1", content)
    if _COLORED.search(content):
        content = _with_whole_colors(content)
    content, lost = _with_absolute_indices(content)
    notes = [f"{lost} faces with an index of nothing (0, or before the first) are left out"] if lost else []
    if _has_several_forms(content):
        content = _with_one_form(content)
    return _with_triangles(content), notes


def _has_comments_behind_values(content: bytes) -> bool:
    at = content.find(b"#", 1)
    while at > 0 and content[at - 1 : at] == b"\n":
        at = content.find(b"#", at + 1)
    return at > 0


def _with_whole_colors(content: bytes) -> bytes:
    """Return the text with a color from 0 to 1 at all points, where trimesh would drop them all, or cut them off at 1.

    Points without one are white. Colors of which one is above 2 are those of programs that write 0 to 255.
    """
    lines = content.split(b"\n")
    numbers = [number for number, line in enumerate(lines) if line.startswith(b"v ")]
    points = [lines[number].split()[1:] for number in numbers]
    try:
        most = max(float(each) for point in points if len(point) >= 6 for each in point[3:6])
    except ValueError:
        return content  # trimesh says what is wrong
    if most <= 2.0 and all(len(point) >= 6 for point in points):
        return content
    unit = 255.0 if most > 2.0 else 1.0  # a little above 1 is rounding
    for number, point in zip(numbers, points):
        color = [b"%.9g" % (float(each) / unit) for each in point[3:6]] if len(point) >= 6 else [b"1"] * 3
        lines[number] = b" ".join([b"v", *point[:3], *color])
    return b"\n".join(lines)


def _has_several_forms(content: bytes) -> bool:
    """Whether some corners of faces have UVs or normals that others lack."""
    first = _CORNER.search(content)
    form = None if first is None else next((each for each in _FORMS if re.fullmatch(each, first[1])), None)
    if form is None or b"/" not in content:
        return False
    return re.search(rb"^f(?!(?: +" + form + rb")+ *\r?$)", content, re.MULTILINE) is not None


def _with_absolute_indices(content: bytes) -> tuple[bytes, int]:
    """Return the text with indices that count from the start of the file, and the number of faces that are left out.

    trimesh would count negative ones from the end of the file, and take 0 for the last.
    """
    if not _RELATIVE.search(content):
        return content, 0
    lines, lost = content.split(b"\n"), 0
    counts = {b"v": 0, b"vt": 0, b"vn": 0}
    for number, line in enumerate(lines):
        words = line.split()
        if words and words[0] in counts:
            counts[words[0]] += 1
        elif words and words[0] == b"f":
            corners = [_absolute(corner, tuple(counts.values())) for corner in words[1:]]
            lines[number] = b"" if None in corners else b"f " + b" ".join(filter(None, corners))
            lost += None in corners
    return b"\n".join(lines), lost


def _absolute(corner: bytes, counts: tuple[int, ...]) -> bytes | None:
    """Return a corner, point/UV/normal, with positive indices; None where one of them is of nothing."""
    found = []
    for index, count in zip(corner.split(b"/"), counts):
        if not re.fullmatch(rb"[+-]?\d+", index):
            found.append(index)  # of nothing, or for trimesh to say what is wrong
            continue
        value = int(index)
        value += count + 1 if value < 0 else 0
        if value < 1:
            return None
        found.append(str(value).encode())
    return b"/".join(found)


def _with_one_form(content: bytes) -> bytes:
    """Return the text with UVs and normals at all corners of faces, where trimesh would drop those of all of them.

    Corners without UVs get the origin, those without a normal that of their face.
    """
    lines = content.split(b"\n")
    counts = {b"v": 0, b"vt": 0, b"vn": 0}
    for line in lines:
        key = line[:2].rstrip()
        counts[key] = counts.get(key, 0) + (key in counts)
    has_uvs, has_normals = counts[b"vt"] > 0, counts[b"vn"] > 0
    places = _points(lines)
    if places is None:
        return content
    added = [b"vt 0 0"] if has_uvs else []
    nowhere, next_normal = str(counts[b"vt"] + 1).encode(), counts[b"vn"] + 1
    for number, line in enumerate(lines):
        if not line.startswith(b"f "):
            continue
        corners = [(*corner.split(b"/"), b"", b"")[:3] for corner in line.split()[1:]]
        normal = b""
        if has_normals and not all(corner[2] for corner in corners):
            points = [int(corner[0]) - 1 for corner in corners]
            if max(points) >= len(places):
                return content  # trimesh says what is wrong
            added.append(b"vn %.7g %.7g %.7g" % _normal(places[points]))
            normal, next_normal = str(next_normal).encode(), next_normal + 1
        whole = [(p, (uv or nowhere) if has_uvs else b"", n or normal) for p, uv, n in corners]
        lines[number] = b"f " + b" ".join(b"/".join(corner).rstrip(b"/") for corner in whole)
    return b"\n".join([*lines, *added, b""])


def _normal(corners: np.ndarray) -> tuple[float, float, float]:
    """Return the unit normal of a polygon (Newell); the z axis for one without area."""
    x, y, z = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0).tolist()
    length = (x * x + y * y + z * z) ** 0.5
    return (x / length, y / length, z / length) if length > 0.0 else (0.0, 0.0, 1.0)


def _points(lines: list[bytes]) -> np.ndarray | None:
    """Return all points (P, 3); None where a line of one is damaged."""
    try:
        points = [[float(each) for each in line.split()[1:4]] for line in lines if line.startswith(b"v ")]
        return np.array(points, np.float64).reshape(-1, 3)
    except ValueError:
        return None


def _with_triangles(content: bytes) -> bytes:
    """Return the text with each concave polygon as lines of triangles."""
    if not _POLYGON.search(content):
        return content
    lines = content.split(b"\n")
    where: list[int] = []
    polygons: list[list[int]] = []
    for number, line in enumerate(lines):
        if line.startswith(b"f ") and len(corners := line.split()[1:]) > 3:
            polygons.append([int(corner.split(b"/")[0]) - 1 for corner in corners])
            where.append(number)
    places = _points(lines)
    if places is None or any(min(each) < 0 or max(each) >= len(places) for each in polygons):
        return content  # trimesh says what is wrong
    for polygon, triangles in concave_ones(places, polygons).items():
        corners = lines[where[polygon]].split()[1:]
        lines[where[polygon]] = b"\n".join(b"f " + b" ".join(corners[k] for k in each) for each in triangles)
    return b"\n".join(lines)
