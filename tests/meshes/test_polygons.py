"""Concave polygons of every form that has polygons have the area that the shoelace formula gives."""

import struct

import numpy as np
import pytest
from pxr import UsdGeom

from tests.meshes.test_conversion import meshes, opened
from usdsdg.meshes.readers import read

ARROW = [(0, 0), (2, 1), (0, 2), (0.5, 1)]
CORNER = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
SQUARE, TRIANGLE = [(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 0), (1, 0), (0, 1)]


def shoelace(polygon):
    x, y = np.array(polygon, float).T
    return abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def scattered(polygons, start):
    """Points (V, 3) and faces of polygons side by side in sheared planes; each begins at another corner."""
    points, faces = [], []
    for k, polygon in enumerate(polygons):
        first = len(points)
        points += [(x + 5 * k, y, 0.0) for x, y in polygon]
        faces.append([first + (start + i) % len(polygon) for i in range(len(polygon))])
    return np.array(points, float), faces


def area(stage):
    total = 0.0
    for prim in meshes(stage):
        mesh = UsdGeom.Mesh(prim)
        corners = np.array(mesh.GetPointsAttr().Get(), float)[np.array(mesh.GetFaceVertexIndicesAttr().Get())]
        corners = corners.reshape(-1, 3, 3)
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        total += np.linalg.norm(cross, axis=1).sum() / 2
    return total


def obj(points, faces):
    lines = [f"v {x} {y} {z}" for x, y, z in points] + ["vt 0 0", "vt 1 0"]
    return "\n".join(lines + ["f " + " ".join(f"{i + 1}/{i % 2 + 1}" for i in face) for face in faces]).encode()


def obj_backward(points, faces):
    lines = [f"v {x} {y} {z}" for x, y, z in points]
    return "\r\n".join(lines + ["f " + " ".join(str(i - len(points)) for i in face) for face in faces]).encode()


def off(points, faces):
    lines = ["OFF # of a test", f"{len(points)} {len(faces)} 0"] + [f"{x} {y} {z}" for x, y, z in points]
    return "\n".join(lines + [" ".join(map(str, (len(face), *face, 255, 0, 0))) for face in faces]).encode()


def header(form, points, faces):
    return (
        f"ply\nformat {form} 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()


def ply(points, faces):
    rows = [f"{x} {y} {z}" for x, y, z in points] + [" ".join(map(str, (len(face), *face))) for face in faces]
    return header("ascii", points, faces) + "\n".join(rows).encode() + b"\n"


def ply_binary(points, faces):
    rows = b"".join(struct.pack(f"<B{len(face)}i", len(face), *face) for face in faces)
    return header("binary_little_endian", points, faces) + np.asarray(points, "<f4").tobytes() + rows


def collada(points, groups):
    """A mesh with groups of polygons: texts of elements that have the points as VERTEX, with offset 1 of 2."""
    values = " ".join(str(each) for point in points for each in point)
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="places"><float_array id="p" count="{3 * len(points)}">{values}</float_array><technique_common>
<accessor source="#p" count="{len(points)}" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<source id="flat"><float_array id="n" count="3">0 0 1</float_array><technique_common>
<accessor source="#n" count="1" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#places"/></vertices>{groups}</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()


INPUTS = '<input semantic="NORMAL" source="#flat" offset="0"/><input semantic="VERTEX" source="#v" offset="1"/>'


def dae(points, faces):
    counts, rows = " ".join(str(len(face)) for face in faces), " ".join(f"0 {i}" for face in faces for i in face)
    group = f'<polylist count="{len(faces)}">{INPUTS}<vcount>{counts}</vcount><p>{rows}</p></polylist>'
    return collada(points, group)


def dae_polygons(points, faces):
    rows = "".join("<p>" + " ".join(f"0 {i}" for i in face) + "</p>" for face in faces)
    return collada(points, f'<polygons count="{len(faces)}">{INPUTS}{rows}</polygons>')


@pytest.mark.parametrize("polygons", [[ARROW], [CORNER], [SQUARE], [TRIANGLE, SQUARE, ARROW, CORNER]], ids=len)
@pytest.mark.parametrize("write", [obj, obj_backward, off, ply, ply_binary, dae, dae_polygons])
def test_polygons_have_their_area(write, polygons, tmp_path):
    for start in range(6):
        file = tmp_path / f"polygons.{write.__name__.partition('_')[0]}"
        file.write_bytes(write(*scattered(polygons, start)))
        stage, _, _ = opened(file, tmp_path)
        assert area(stage) == pytest.approx(sum(map(shoelace, polygons)), rel=1e-6)


def test_the_materials_of_cut_polygons_stay(tmp_path):
    points, faces = scattered([SQUARE, CORNER], 1)
    lines = obj(points, faces).decode().splitlines()
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n")
    text = ["mtllib a.mtl", *lines[:-2], "usemtl red", lines[-2], "usemtl blue", lines[-1]]
    (tmp_path / "a.obj").write_text("\n".join(text))
    stage, _, _ = opened(tmp_path / "a.obj", tmp_path)
    found = {}
    for prim in meshes(stage):
        target = str(prim.GetRelationship("material:binding").GetTargets()[0])
        found[target.rpartition("/")[2]] = len(UsdGeom.Mesh(prim).GetFaceVertexCountsAttr().Get())
    assert found == {"red": 2, "blue": 4}


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_strips_of_ply_are_triangles_that_all_look_up(form, tmp_path):
    """As in Stanford's scans. Two strips in one plane, one of which repeats a corner to turn."""
    points = [(x, y, 0.0) for x in range(4) for y in range(2)]
    strip = [0, 2, 1, 3, -1, 4, 6, 5, 7, 7]
    head = (
        f"ply\nformat {form} 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
        "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    )
    if form == "ascii":
        rows = [*points, (len(strip), *strip)]
        body = "".join(" ".join(map(str, row)) + "\n" for row in rows).encode()
    else:
        order = "<" if "little" in form else ">"
        body = b"".join(struct.pack(order + "3f", *point) for point in points)
        body += struct.pack(f"{order}{1 + len(strip)}i", len(strip), *strip)
    (tmp_path / "a.ply").write_bytes(head.encode() + body)
    [part] = read(tmp_path / "a.ply").parts
    corners = part.points[part.triangles]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2
    np.testing.assert_allclose(areas, [0.5] * 4)
    assert sorted(corners.mean(axis=1)[:, 0].round(3).tolist()) == [0.333, 0.667, 2.333, 2.667]
