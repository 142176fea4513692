"""TetMesh: its surface is drawn and bounded, wound outwards, with the materials of its faces."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from usdsdg.annotators import LabeledPrimReader
from usdsdg.stage.geometry.triangles import own_triangles
from usdsdg.stage.semantics.labels import add_labels
from usdsdg_render.sync.extract import SceneExtractor

# Two tetrahedra that share the face (1, 2, 3); the last point belongs to none.
POINTS = [Gf.Vec3f(*p) for p in [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]]
TETRAHEDRA = [Gf.Vec4i(0, 1, 2, 3), Gf.Vec4i(1, 2, 3, 4)]
VOLUME = 1 / 6 + 1 / 3


@pytest.fixture
def stage():
    return Usd.Stage.CreateInMemory()


@pytest.fixture
def mesh(stage):
    mesh = UsdGeom.TetMesh.Define(stage, "/Tet")
    mesh.CreatePointsAttr(POINTS)
    mesh.CreateTetVertexIndicesAttr(TETRAHEDRA)
    return mesh


def extract(mesh, time=None):
    extractor = SceneExtractor(mesh.GetPrim().GetStage())
    extractor.update(time)
    return extractor.scene


def volume(points, triangles):
    a, b, c = points[triangles].astype(float).transpose(1, 0, 2)
    return np.einsum("ti,ti->", a, np.cross(b, c)) / 6


@pytest.mark.parametrize("handed", ["rightHanded", "leftHanded"])
@pytest.mark.parametrize("authored", [False, True])
def test_the_surface_is_closed_and_faces_outwards(handed, authored, mesh):
    if handed == "leftHanded":
        mesh.CreatePointsAttr([Gf.Vec3f(-p[0], p[1], p[2]) for p in POINTS])
        mesh.CreateOrientationAttr(handed)
    if authored:
        mesh.CreateSurfaceFaceVertexIndicesAttr(UsdGeom.TetMesh.ComputeSurfaceFaces(mesh, Usd.TimeCode.Default()))
    [found] = extract(mesh).prototypes
    assert len(found.triangles) == 6
    assert volume(found.points, found.triangles) == pytest.approx(VOLUME)
    own = own_triangles(mesh.GetPrim())
    assert own is not None
    assert volume(own.points, own.faces) == pytest.approx(VOLUME)


def test_faces_have_the_materials_of_their_subsets(stage, mesh):
    UsdGeom.Subset.CreateGeomSubset(mesh, "part", "face", [1, 2], "materialBind", "partition")
    for path in ("/Tet", "/Tet/part"):
        material = UsdShade.Material.Define(stage, f"/Looks{path.replace('/', '_')}")
        shader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("Surface"))
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(len(path) / 10))
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath(path)).Bind(material)
    scene = extract(mesh)
    [found] = scene.prototypes
    colors = scene.materials["base_color"][scene.material_slots][:, 0]
    np.testing.assert_allclose(colors[found.triangle_slots], [0.4, 0.9, 0.9, 0.4, 0.4, 0.4])


def test_its_box_is_that_of_its_points_in_the_frame_of_its_owner(stage, mesh):
    add_labels(mesh.GetPrim(), {"class": ["jelly"]})
    mesh.AddRotateZOp().Set(45.0)
    prims = LabeledPrimReader(stage).read(["/Tet"])
    np.testing.assert_allclose(prims.bounds, [[(0, 0, 0), (1, 1, 1)]])
    mesh.CreateTetVertexIndicesAttr(TETRAHEDRA[:1])
    assert len(extract(mesh).prototypes[0].triangles) == 4


def test_a_deforming_one_is_drawn_at_its_time(mesh):
    mesh.GetPointsAttr().Clear()
    for time in (0, 10):
        mesh.GetPointsAttr().Set([p * (1 + time) for p in POINTS], time)
    [found] = extract(mesh, Usd.TimeCode(5)).prototypes
    assert volume(found.points, found.triangles) == pytest.approx(VOLUME * 6**3)


def test_an_empty_one_is_named(mesh):
    mesh.GetTetVertexIndicesAttr().Clear()
    with pytest.warns(UserWarning, match="/Tet: the mesh is empty .* Author points, tetVertexIndices"):
        assert not extract(mesh).prototypes
