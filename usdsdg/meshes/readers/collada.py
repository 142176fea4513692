"""What trimesh does not read of COLLADA: axes and units, concave polygons, skins, and parts without their material."""

from __future__ import annotations

import importlib.util
import io
import re
import xml.etree.ElementTree as ET

import numpy as np

from usdsdg.meshes.readers.collada_skins import pose_skins
from usdsdg.meshes.readers.polygons import concave_ones

# Parts of a file that make no mesh.
_BESIDE = ("camera", "light", "animation", "kinematics", "physics")


def is_installed() -> bool:
    """Return whether the package is there by which trimesh reads COLLADA."""
    return importlib.util.find_spec("collada") is not None


def axes(content: bytes) -> tuple[str, float]:
    """Return the up axis and meters per unit of a file; trimesh applies neither."""
    text = content[:20000].decode("utf-8", "replace")
    up = re.search(r"<up_axis>\s*([XYZ])_UP\s*</up_axis>", text)
    unit = re.search(r"<unit\b[^>]*\bmeter\s*=\s*[\"']([^\"']+)[\"']", text)
    return (up[1] if up else "Y"), (float(unit[1]) if unit else 1.0)


def prepared(content: bytes) -> tuple[bytes, list[str]]:
    """Return a file with triangles in place of concave polygons, and plain meshes in place of skinned ones; and notes.

    The file itself where it has no such, or cannot be understood.
    """
    # Entities may make a small file a large one.
    if b"<!ENTITY" in content:
        return content, []
    try:
        root = ET.fromstring(content)
        space = root.tag.removesuffix("COLLADA")
        has_changed = [_cut(mesh, space) for mesh in root.iter(f"{space}mesh")]
    except (ET.ParseError, KeyError, ValueError, IndexError, StopIteration):
        return content, []  # trimesh says what is wrong
    lost, posed = _without_missing_materials(root, space), pose_skins(root, space)
    notes = [*lost, *(posed or ())]
    if lost or posed is not None or any(has_changed):
        ET.register_namespace("", space.strip("{}"))
        content = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return content, list(dict.fromkeys([*notes, *_parts_left_out(content)]))


def _without_missing_materials(root: ET.Element, space: str) -> list[str]:
    """Take away what binds materials that are not there, for which pycollada would leave out the mesh."""
    known = {each.get("id") for each in root.iter(f"{space}material")}
    missing = []
    for technique in root.iter(f"{space}technique_common"):
        for each in technique.findall(f"{space}instance_material"):
            if (target := each.get("target", "")[1:]) not in known:
                technique.remove(each)
                missing.append(f"the material {target} is missing in the file, so its part of the look is left out")
    return missing


def _parts_left_out(content: bytes) -> list[str]:
    """Return notes of what pycollada does not read, which trimesh leaves out without a word."""
    import collada
    from collada.common import DaeError

    found = collada.Collada(io.BytesIO(content), ignore=[DaeError]).errors
    texts = [str(each).partition(": ")[2] or str(each) for each in found]
    return [f"a part of the file is left out: {text}" for text in texts if not any(w in text.lower() for w in _BESIDE)]


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
