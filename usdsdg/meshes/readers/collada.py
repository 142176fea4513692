"""What trimesh does not read of COLLADA: axes and units, and polygons that are concave."""

from __future__ import annotations

import importlib.util
import re
import xml.etree.ElementTree as ET

import numpy as np

from usdsdg.meshes.readers.polygons import concave_ones


def is_installed() -> bool:
    """Return whether the package is there by which trimesh reads COLLADA."""
    return importlib.util.find_spec("collada") is not None


def axes(content: bytes) -> tuple[str, float]:
    """Return the up axis and meters per unit of a file; trimesh applies neither."""
    text = content[:20000].decode("utf-8", "replace")
    up = re.search(r"<up_axis>\s*([XYZ])_UP\s*</up_axis>", text)
    unit = re.search(r"<unit\b[^>]*\bmeter\s*=\s*[\"']([^\"']+)[\"']", text)
    return (up[1] if up else "Y"), (float(unit[1]) if unit else 1.0)


def prepared(content: bytes) -> bytes:
    """Return a file whose concave polygons are triangles; the file itself where there are none."""
    # Entities may make a small file a large one.
    if not re.search(rb"<poly(list|gons)\b", content) or b"<!ENTITY" in content:
        return content
    try:
        root = ET.fromstring(content)
        space = root.tag.removesuffix("COLLADA")
        has_changed = [_cut(mesh, space) for mesh in root.iter(f"{space}mesh")]
    except (ET.ParseError, KeyError, ValueError, IndexError, StopIteration):
        return content  # trimesh says what is wrong
    if not any(has_changed):
        return content
    ET.register_namespace("", space.strip("{}"))
    return ET.tostring(root, encoding="utf-8", xml_declaration=True)


def _cut(mesh: ET.Element, space: str) -> bool:
    """Cut the concave polygons of a mesh; return whether there were any."""
    has_changed = False
    for group in [*mesh.findall(f"{space}polylist"), *mesh.findall(f"{space}polygons")]:
        inputs = group.findall(f"{space}input")
        stride = 1 + max(int(each.get("offset", 0)) for each in inputs)
        at, points = next(
            (int(each.get("offset", 0)), _points(mesh, space, each.get("source", "")[1:]))
            for each in inputs
            if each.get("semantic") == "VERTEX"
        )
        polygons = [np.reshape(each, (-1, stride)) for each in _polygons(group, space, stride)]
        corners = [each[:, at].tolist() for each in polygons]
        if any(len(each) < 3 or min(each) < 0 or max(each) >= len(points) for each in corners):
            continue
        concave = concave_ones(points, corners)
        if not concave or group.find(f"{space}ph") is not None:
            continue
        cut = []
        for number, each in enumerate(polygons):
            cut += [each[triangle] for triangle in concave[number]] if number in concave else [each]
        _write(group, space, cut)
        has_changed = True
    return has_changed


def _polygons(group: ET.Element, space: str, stride: int) -> list[list[int]]:
    """Return the indices of each polygon, `stride` for each of its corners."""
    rows = [list(map(int, (each.text or "").split())) for each in group.findall(f"{space}p")]
    if group.tag == f"{space}polygons":
        return rows
    counts = list(map(int, (group.findtext(f"{space}vcount") or "").split()))
    ends = np.cumsum(counts) * stride
    return [rows[0][end - count * stride : end] for count, end in zip(counts, ends.tolist())]


def _points(mesh: ET.Element, space: str, vertices: str) -> np.ndarray:
    """Return the points (V, 3) of the `vertices` with an id."""
    [own] = [each for each in mesh.findall(f"{space}vertices") if each.get("id") == vertices]
    source = next(each for each in own.findall(f"{space}input") if each.get("semantic") == "POSITION").get("source", "")
    [found] = [each for each in mesh.findall(f"{space}source") if each.get("id") == source[1:]]
    values = np.array((found.findtext(f"{space}float_array") or "").split(), np.float64)
    accessor = found.find(f"{space}technique_common/{space}accessor")
    stride = int(accessor.get("stride", 1)) if accessor is not None else 3
    return values.reshape(-1, stride)[:, :3]


def _write(group: ET.Element, space: str, polygons: list[np.ndarray]) -> None:
    """Make an element a polylist of these polygons."""
    group.tag = f"{space}polylist"
    group.set("count", str(len(polygons)))
    for each in [*group.findall(f"{space}p"), *group.findall(f"{space}vcount")]:
        group.remove(each)
    ET.SubElement(group, f"{space}vcount").text = " ".join(str(len(each)) for each in polygons)
    ET.SubElement(group, f"{space}p").text = " ".join(map(str, np.concatenate(polygons).ravel().tolist()))
