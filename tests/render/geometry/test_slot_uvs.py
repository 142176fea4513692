"""Meshes of several materials that read different texture coordinates: each has its own on its faces."""

import warnings

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from usdsdg_render.sync.extract import SceneExtractor

T = Sdf.ValueTypeNames
COUNTS = [4, 3, 4, 5]
INDICES = [0, 1, 5, 4, 1, 2, 5, 2, 3, 7, 6, 2, 6, 10, 9, 5]
# Bent, so that no three points of a face are in a line.
POINTS = np.array([[x - 0.1 * (y - 1) ** 2, y, 0] for y in range(3) for x in range(4)], np.float32)
ELEMENTS = {"vertex": 12, "varying": 12, "faceVarying": 16, "uniform": 4, "constant": 1}


def add_material(stage, name, primvar, image):
    """A material whose texture is read by the coordinates of a primvar; "" = no texture."""
    material = UsdShade.Material.Define(stage, f"/Looks/{name}")
    surface = UsdShade.Shader.Define(stage, f"/Looks/{name}/Surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    if primvar:
        texture = UsdShade.Shader.Define(stage, f"/Looks/{name}/Tex")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", T.Asset).Set(str(image))
        reader = UsdShade.Shader.Define(stage, f"/Looks/{name}/Reader")
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", T.String).Set(primvar)
        texture.CreateInput("st", T.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
        color = surface.CreateInput("diffuseColor", T.Color3f)
        color.ConnectToSource(texture.ConnectableAPI(), "rgb")
    return material


@pytest.fixture
def stage(tmp_path):
    """A mesh of four faces, the first two of which have materials of their own."""
    Image.new("RGB", (2, 2), (9, 9, 9)).save(tmp_path / "a.png")
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/Mesh")
    mesh.CreatePointsAttr([Gf.Vec3f(*p) for p in POINTS.tolist()])
    mesh.CreateFaceVertexCountsAttr(COUNTS)
    mesh.CreateFaceVertexIndicesAttr(INDICES)
    mesh.CreateSubdivisionSchemeAttr("none")
    for name, primvar in (("first", "st"), ("second", "light"), ("rest", "st_1"), ("plain", "")):
        add_material(stage, name, primvar, tmp_path / "a.png")
    for face, name in enumerate(("first", "second")):
        subset = UsdGeom.Subset.CreateGeomSubset(mesh, name, "face", [face], "materialBind")
        bind(subset, name)
    bind(mesh, "rest")
    return stage


def bind(schema, name):
    prim = schema.GetPrim()
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(UsdShade.Material.Get(prim.GetStage(), f"/Looks/{name}"))


def add_uvs(stage, name, interpolation, seed, indexed=False):
    rng = np.random.default_rng(seed)
    count = ELEMENTS[interpolation]
    values = rng.random((5 if indexed else count, 2)).astype(np.float32)
    primvar = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/Mesh")).CreatePrimvar(name, T.TexCoord2fArray, interpolation)
    primvar.Set([Gf.Vec2f(*value) for value in values.tolist()])
    if indexed:
        primvar.SetIndices(rng.integers(0, 5, count).tolist())


def flattened(stage, name):
    """USD's own values of a primvar, of each face-vertex."""
    primvar = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/Mesh")).GetPrimvar(name)
    values = np.array(primvar.ComputeFlattened())
    faces = np.repeat(np.arange(4), COUNTS)
    rows = {"constant": 0 * faces, "uniform": faces, "faceVarying": np.arange(16)}
    return values[rows.get(primvar.GetInterpolation(), INDICES)]


def corner_uvs(scene):
    """Texture coordinates of the drawn mesh by face and point."""
    (drawn,) = scene.instances.prototype
    prototype = scene.prototypes[drawn]
    found = {}
    for triangle, face, uvs in zip(prototype.triangles, prototype.triangle_faces, prototype.uvs):
        for vertex, uv in zip(triangle, uvs):
            found[int(face), int(vertex)] = uv
    return found


def extract(stage):
    extractor = SceneExtractor(stage)
    extractor.update()
    return extractor.scene


@pytest.mark.parametrize("indexed", [False, True])
@pytest.mark.parametrize("second", sorted(ELEMENTS))
@pytest.mark.parametrize("first", sorted(ELEMENTS))
def test_each_material_has_its_own_texture_coordinates(first, second, indexed, stage):
    for seed, (name, kind) in enumerate((("st", first), ("light", second), ("st1", first))):  # also spelled st_1
        add_uvs(stage, name, kind, seed, indexed)
    wanted = {name: flattened(stage, name) for name in ("st", "light", "st1")}
    expected, corner = {}, 0
    for face, (count, name) in enumerate(zip(COUNTS, ("st", "light", "st1", "st1"))):
        for _ in range(count):
            expected[face, INDICES[corner]] = wanted[name][corner]
            corner += 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = corner_uvs(extract(stage))
    assert found.keys() == expected.keys()
    for key, uv in expected.items():
        np.testing.assert_array_equal(found[key], uv, err_msg=str(key))


def test_materials_without_textures_ask_for_no_coordinates(stage):
    add_uvs(stage, "st", "vertex", 0)
    add_uvs(stage, "light", "vertex", 1)
    bind(stage.GetPrimAtPath("/Mesh"), "plain")
    bind(stage.GetPrimAtPath("/Mesh/second"), "plain")
    found = corner_uvs(extract(stage))
    for (_, vertex), uv in found.items():
        np.testing.assert_array_equal(uv, flattened(stage, "st")[INDICES.index(vertex)])


def test_coordinates_of_one_material_that_do_not_fit_leave_the_others_alone(stage):
    add_uvs(stage, "st", "faceVarying", 0)
    add_uvs(stage, "light", "faceVarying", 1)
    add_uvs(stage, "st1", "vertex", 2)
    primvar = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/Mesh")).GetPrimvar("light")
    primvar.Set(primvar.Get()[:5])
    with pytest.warns(UserWarning, match="/Mesh: the faceVarying texture coordinates .* 5 values, too few"):
        found = corner_uvs(extract(stage))
    assert [found[1, vertex].tolist() for vertex in (1, 2, 5)] == [[0, 0]] * 3
    np.testing.assert_array_equal(found[0, 1], flattened(stage, "st")[1])
    np.testing.assert_array_equal(found[2, 3], flattened(stage, "st1")[8])


def test_another_set_of_one_material_shows_in_the_next_frame(stage):
    for seed, name in enumerate(("st", "light", "st1")):
        add_uvs(stage, name, "vertex", seed)
    extractor = SceneExtractor(stage)
    extractor.update()
    stage.GetAttributeAtPath("/Looks/second/Reader.inputs:varname").Set("st1")
    extractor.update()
    np.testing.assert_array_equal(corner_uvs(extractor.scene)[1, 2], flattened(stage, "st1")[5])


def test_meshes_of_one_asset_are_shared_by_the_coordinates_of_all_their_materials(stage):
    for seed, name in enumerate(("st", "light", "st1")):
        add_uvs(stage, name, "vertex", seed)
    stage.CreateClassPrim("/_asset")
    Sdf.CopySpec(stage.GetRootLayer(), "/Mesh", stage.GetRootLayer(), "/_asset/Mesh")
    stage.RemovePrim("/Mesh")
    for k in range(3):
        stage.DefinePrim(f"/o{k}", "Xform").GetReferences().AddInternalReference("/_asset")
    bind(stage.GetPrimAtPath("/o2/Mesh/second"), "first")
    scene = extract(stage)
    assert len(scene.prototypes) == 2
    assert scene.instances.prototype[0] == scene.instances.prototype[1] != scene.instances.prototype[2]
