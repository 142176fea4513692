"""Ways to write the lines of OBJ files, against the same mesh written plainly."""

import numpy as np
import pytest
from pxr import UsdGeom

from tests.meshes.test_conversion import meshes, opened

POINTS = np.array([(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 3), (2, 0, 3), (2, 2, 3), (0, 2, 3)], float)
UVS = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)


def corners_of(text, tmp_path):
    """Convert a file; return points, in the file's axes, and UVs of the corners of all triangles, and the report."""
    (tmp_path / "thing.obj").write_bytes(text.encode())
    stage, report, _ = opened(tmp_path / "thing.obj", tmp_path)
    points, uvs = [], []
    for prim in meshes(stage):
        mesh = UsdGeom.Mesh(prim)
        indices = np.array(mesh.GetFaceVertexIndicesAttr().Get())
        points.append(np.array(mesh.GetPointsAttr().Get())[indices])
        st = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
        values = np.array(st.Get()) if st else np.full((len(indices), 2), np.nan)
        uvs.append(values[indices] if st and st.GetInterpolation() == "vertex" else values)
    return np.concatenate(points)[:, [0, 2, 1]] * (1, 1, -1), np.concatenate(uvs), report


def squares(*, relative=False, forms=("{p}/{t}", "{p}/{t}"), separator=" ", indent="", end="\n", comment=""):
    """Two squares, each with its points and UVs before its face."""
    lines = []
    for k, form in enumerate(forms):
        for point in POINTS[4 * k : 4 * k + 4]:
            lines.append(separator.join(["v", *map(str, point)]))
        for uv in UVS:
            lines.append(separator.join(["vt", *map(str, uv + k)]))
        lines.append(separator.join(["vn", "0", "0", "1"]))
        corners = [
            form.format(p=i - 4, t=i - 4, n=-1) if relative else form.format(p=4 * k + i + 1, t=4 * k + i + 1, n=k + 1)
            for i in range(4)
        ]
        lines.append(separator.join(["f", *corners]))
    return "".join(f"{indent}{line}{comment}{end}" for line in lines)


@pytest.mark.parametrize(
    "how",
    [
        {"relative": True},
        {"relative": True, "forms": ("{p}/{t}/{n}", "{p}/{t}/{n}")},
        {"separator": "\t"},
        {"indent": "  "},
        {"indent": "\t", "relative": True},
        {"comment": " # a square"},
        {"end": "\r\n", "relative": True},
        {"end": "\r"},
        {"forms": ("{p}/{t}/{n}", "{p}/{t}")},
    ],
    ids=str,
)
def test_a_mesh_is_the_same_however_it_is_written(how, tmp_path):
    points, uvs, _ = corners_of(squares(), tmp_path)
    assert len(points) == 12
    found, found_uvs, report = corners_of(squares(**how), tmp_path)
    np.testing.assert_allclose(found, points)
    np.testing.assert_allclose(found_uvs, uvs)
    assert report.repairs == report.notes == []


@pytest.mark.parametrize("form", ["{p}", "{p}//{n}"])
def test_faces_without_uvs_leave_others_theirs(form, tmp_path):
    points, uvs, _ = corners_of(squares(), tmp_path)
    found, found_uvs, _ = corners_of(squares(forms=("{p}/{t}", form)), tmp_path)
    np.testing.assert_allclose(found, points)
    is_first = points[:, 2] == 0.0
    np.testing.assert_allclose(found_uvs[is_first], uvs[is_first])
    np.testing.assert_allclose(found_uvs[~is_first], 0.0)


def test_faces_without_normals_are_flat(tmp_path):
    text = squares(forms=("{p}//{n}", "{p}")).replace("vn 0 0 1", "vn 1 0 0")
    (tmp_path / "thing.obj").write_text(text)
    stage, _, _ = opened(tmp_path / "thing.obj", tmp_path)
    [mesh] = meshes(stage)
    normals = np.array(UsdGeom.Mesh(mesh).GetNormalsAttr().Get())
    assert {tuple(np.round(each, 5).tolist()) for each in normals} == {(1, 0, 0), (0, -1, 0)}  # Y up became Z up


@pytest.mark.parametrize("index", ["0", "-9"])
def test_faces_of_points_that_are_not_there_are_named(index, tmp_path):
    points, _, _ = corners_of(squares(), tmp_path)
    found, _, report = corners_of(squares() + f"f 1 2 {index}\n", tmp_path)
    np.testing.assert_allclose(found, points)
    assert report.notes == ["1 faces with an index of nothing (0, or before the first) are left out"]


def test_uvs_of_one_number(tmp_path):
    _, uvs, _ = corners_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25\nvt 0.5\nvt 0.75\nf 1/1 2/2 3/3\n", tmp_path)
    np.testing.assert_allclose(uvs, [(0.25, 0), (0.5, 0), (0.75, 0)])
