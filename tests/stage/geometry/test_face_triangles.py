"""Triangles of concave faces in models, colliders, scattering and mesh files: they cover the polygon, no more."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from usdsdg.meshes.readers import usd as usd_files
from usdsdg.stage.geometry.triangles import own_triangles
from usdsdg_physics.parse.shapes import mesh_triangles

# A star of eight points around the origin, and an L whose first vertex sees only a part of it.
STAR = [((1.0, 0.35)[k % 2] * np.cos(k * np.pi / 8), (1.0, 0.35)[k % 2] * np.sin(k * np.pi / 8)) for k in range(16)]
L = [(2, 0), (2, 1), (1, 1), (1, 3), (0, 3), (0, 0)]
ARROW = [(0, 0), (2, 1), (0, 2), (0.5, 1)]


def mesh(polygon, *, hands="rightHanded"):
    stage = Usd.Stage.CreateInMemory()
    prim = UsdGeom.Mesh.Define(stage, "/Mesh")
    prim.CreatePointsAttr([Gf.Vec3f(0.3 * y, x, y) for x, y in polygon])
    prim.CreateFaceVertexCountsAttr([len(polygon)])
    prim.CreateFaceVertexIndicesAttr(list(range(len(polygon))))
    prim.CreateOrientationAttr(hands)
    return stage, prim


def in_a_model(stage, prim, _):
    found = own_triangles(prim.GetPrim())
    assert found is not None
    return found.points[found.faces]


def in_a_collider(stage, prim, _):
    holes = np.zeros(0, np.int64)
    arrays = prim.GetPointsAttr(), prim.GetFaceVertexCountsAttr(), prim.GetFaceVertexIndicesAttr()
    points, counts, indices = (np.array(attribute.Get()) for attribute in arrays)
    left = prim.GetOrientationAttr().Get() == "leftHanded"
    found = mesh_triangles._made(points, counts, indices, holes, left)
    return found.points[found.triangles]


def in_a_mesh_file(stage, prim, folder):
    stage.GetRootLayer().Export(str(folder / "mesh.usda"))
    (part,) = usd_files.read(folder / "mesh.usda").parts
    return np.asarray(part.points)[np.asarray(part.triangles)]


def is_inside(polygon, point) -> bool:
    """Whether a ray to the right crosses the outline an odd number of times."""
    crossings = 0
    for (x0, y0), (x1, y1) in zip(polygon, [*polygon[1:], polygon[0]]):
        if (y0 > point[1]) != (y1 > point[1]):
            crossings += point[0] < x0 + (point[1] - y0) * (x1 - x0) / (y1 - y0)
    return crossings % 2 == 1


@pytest.mark.parametrize("hands", ["rightHanded", "leftHanded"])
@pytest.mark.parametrize("polygon", [STAR, L, ARROW, ARROW[1:] + ARROW[:1]], ids=["star", "L", "arrow", "turned arrow"])
@pytest.mark.parametrize("triangles_of", [in_a_model, in_a_collider, in_a_mesh_file])
def test_triangles_cover_a_concave_face_once(triangles_of, polygon, hands, tmp_path):
    stage, prim = mesh(polygon, hands=hands)
    corners = np.asarray(triangles_of(stage, prim, tmp_path), np.float64)
    flat = corners[:, :, 1:]  # the face leans along x
    (x1, y1), (x2, y2) = (flat[:, 1] - flat[:, 0]).T, (flat[:, 2] - flat[:, 0]).T
    areas = (x1 * y2 - y1 * x2) / 2
    shoelace = sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(polygon, [*polygon[1:], polygon[0]])) / 2
    assert len(areas) == len(polygon) - 2
    assert (np.sign(areas) == (1 if hands == "rightHanded" else -1)).all()
    assert abs(areas).sum() == pytest.approx(abs(shoelace), rel=1e-5)
    assert all(is_inside(polygon, middle) for middle in flat.mean(axis=1))
