"""Captured .usdz as clean USD: geometry, looks and places against what the package itself says."""

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade

import usdsdg as rep
from tests.meshes.test_conversion import meshes, opened, source_of, surface
from tests.meshes.test_places import labels_below, size
from tests.soak.meshes.made_usdz import package
from tests.soak.meshes.shapes import checker, cup, textured_box
from usdsdg.cli.app import app
from usdsdg.errors import AssetError, UsdsdgWarning
from usdsdg.meshes import cache
from usdsdg.session.stage_context import current_stage, open_stage

pytestmark = pytest.mark.usefixtures("own_cache")
T = Sdf.ValueTypeNames


def corners_of(mesh):
    """Position and UV of each corner of the triangles of a trimesh, as a set."""
    both = np.c_[np.asarray(mesh.vertices), mesh.visual.uv][mesh.faces.ravel()]
    return set(map(tuple, np.round(1e4 * both).astype(int).tolist()))


def corners_in(stage):
    """The same of all meshes of a stage."""
    found = set()
    for prim in meshes(stage):
        mesh = UsdGeom.Mesh(prim)
        indices = np.array(mesh.GetFaceVertexIndicesAttr().Get())
        st = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
        uvs = np.array(st.Get())
        uvs = uvs[indices] if st.GetInterpolation() == "vertex" else uvs
        both = np.c_[np.array(mesh.GetPointsAttr().Get())[indices], uvs]
        found |= set(map(tuple, np.round(1e4 * both).astype(int).tolist()))
    return found


@pytest.mark.parametrize(("up", "unit"), [("Y", 0.01), ("Y", 1.0), ("Z", 0.001)])
def test_axes_units_and_uvs(tmp_path, up, unit):
    package(tmp_path / "scan.usdz", textured_box(), up=up, unit=unit)
    stage, report, _ = opened(tmp_path / "scan.usdz", tmp_path)
    assert (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage)) == ("Z", 1.0)
    assert np.allclose(report.size, 0.2)
    assert corners_in(stage) == corners_of(textured_box())
    assert (report.triangles, report.repairs, report.notes) == (12, [], [])


def test_pictures_inside_the_package(tmp_path):
    package(tmp_path / "scan.usdz", textured_box())
    stage, _, _ = opened(tmp_path / "scan.usdz", tmp_path)
    shader = surface(stage)
    color, _ = source_of(shader, "diffuseColor")
    assert color.GetInput("sourceColorSpace").Get() == "sRGB"
    with Image.open(color.GetInput("file").Get().resolvedPath) as image:
        assert np.array_equal(np.array(image.convert("RGB")), np.array(checker(256)))
    rough, output = source_of(shader, "roughness")
    with Image.open(rough.GetInput("file").Get().resolvedPath) as image:
        assert (output, np.array(image)[0, 0, 1]) == ("g", 200)
    assert shader.GetInput("metallic").Get() in (None, 0.0) or source_of(shader, "metallic")[1] == "b"
    assert source_of(shader, "normal")[0].GetInput("sourceColorSpace").Get() == "raw"


def test_subsets_are_parts_with_materials_of_their_own(tmp_path):
    package(tmp_path / "scan.usdz", textured_box(), split=True)
    stage, report, _ = opened(tmp_path / "scan.usdz", tmp_path)
    bound = [UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0].GetPath().name for prim in meshes(stage)]
    assert (sorted(bound), report.triangles) == (["plain", "skin"], 12)


def test_left_handed_meshes_are_turned(tmp_path):
    def edit(stage):
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/scan/Geom/object"))
        mesh.CreateOrientationAttr("leftHanded")
        turned = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)[:, ::-1]
        mesh.GetFaceVertexIndicesAttr().Set(np.ascontiguousarray(turned).ravel().tolist())

    package(tmp_path / "scan.usdz", cup(), edit=edit)
    stage, report, _ = opened(tmp_path / "scan.usdz", tmp_path)
    [mesh] = map(UsdGeom.Mesh, meshes(stage))
    points = np.array(mesh.GetPointsAttr().Get(), float)
    a, b, c = points[np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)].transpose(1, 0, 2)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert volume == pytest.approx(cup().volume, rel=1e-3)
    assert report.repairs == []


@pytest.mark.parametrize(("up", "unit"), [("Z", 1.0), ("Y", 0.01)])
def test_an_asset_gets_the_stage_s_axes_and_units_and_its_name_as_class(stage, tmp_path, monkeypatch, up, unit):
    done, inner = [], cache.convert
    monkeypatch.setattr(cache, "convert", lambda source, *rest: done.append(source.name) or inner(source, *rest))
    rep.settings.set_stage_up_axis(up)
    rep.settings.set_stage_meters_per_unit(unit)
    package(tmp_path / "mug.usdz", cup(), unit=0.001)
    for _ in range(2):
        [path] = rep.create.from_usd(str(tmp_path / "mug.usdz")).prims
    assert labels_below(path) == [{"class": ["mug"]}]
    expected = np.ptp(cup().vertices, axis=0) / unit
    assert np.allclose(size(path), expected if up == "Z" else expected[[0, 2, 1]], rtol=1e-4)
    assert done == ["mug.usdz"]
    [path] = rep.create.from_usd(str(tmp_path / "mug.usdz"), semantics=[("class", "cup")]).prims
    assert labels_below(path) == [{"class": ["cup"]}]


@pytest.mark.parametrize("make", ["light", "body"])
def test_what_has_more_than_meshes_stays_as_it_is(stage, tmp_path, make):
    def edit(stage):
        if make == "light":
            UsdLux.SphereLight.Define(stage, "/scan/lamp")
        else:
            UsdPhysics.RigidBodyAPI.Apply(stage.GetDefaultPrim())

    package(tmp_path / "lamp.usdz", textured_box(), edit=edit)
    more = {"light": "lights", "body": "physics"}[make]
    with pytest.warns(UsdsdgWarning, match=rf"lamp.usdz has {more}, so it is not converted.*Y up and 0.01 m per unit"):
        [path] = rep.create.from_usd(str(tmp_path / "lamp.usdz")).prims
    assert np.allclose(size(path), 20.0)
    assert labels_below(path) == []
    _, report, _ = opened(tmp_path / "lamp.usdz", tmp_path)
    assert report.notes == [f"left out: {more}"]


def test_stages_are_opened_as_they_are(stage, tmp_path):
    package(tmp_path / "scan.usdz", textured_box())
    assert open_stage(tmp_path / "scan.usdz").GetDefaultPrim().GetName() == "scan"
    assert UsdGeom.GetStageUpAxis(current_stage()) == "Y"


def test_origin_collider_and_scale_mistakes_from_the_command_line(tmp_path):
    package(tmp_path / "mug.usdz", cup(1000.0), unit=1.0, at=(5000.0, 0.0, 0.0))
    target = tmp_path / "out" / "mug.usda"
    result = CliRunner().invoke(app, ["convert", str(tmp_path / "mug.usdz"), str(target)])
    assert result.exit_code == 0
    assert (
        "mug.usdz is 124 m large, which is odd for an object; if it is in mm, convert it with --unit mm"
        in result.output
    )
    assert "away from its origin" in result.output
    given = ["--unit", "mm", "--origin", "bottom", "--collider", "convexHull", "--label", "cup"]
    result = CliRunner().invoke(app, ["convert", str(tmp_path / "mug.usdz"), str(target), *given])
    assert (result.exit_code, "odd" in result.output) == (0, False)
    stage = Usd.Stage.Open(str(target))
    [mesh] = meshes(stage)
    low, high = UsdGeom.Mesh(mesh).GetExtentAttr().Get()
    assert np.allclose((np.array(low) + high)[:2], 0.0, atol=1e-6)
    assert low[2] == pytest.approx(0.0, abs=1e-6)
    assert mesh.GetAttribute("physics:approximation").Get() == "convexHull"


def test_a_package_without_its_picture_or_mesh(tmp_path):
    def without_picture(stage):
        shader = UsdShade.Shader(stage.GetPrimAtPath("/scan/Looks/skin/diffuseColor"))
        shader.GetInput("file").Set("gone.png")

    package(tmp_path / "scan.usdz", textured_box(), edit=without_picture)
    _, report, _ = opened(tmp_path / "scan.usdz", tmp_path)
    assert report.notes == ["the picture gone.png is missing, so its part of the look is left out"]
    package(tmp_path / "bare.usdz", textured_box(), edit=lambda stage: stage.RemovePrim("/scan/Geom"))
    with pytest.raises(AssetError, match=r"bare\.usdz has no triangles"):
        opened(tmp_path / "bare.usdz", tmp_path)


def card(tmp_path, edit):
    """Write a square with one material and two pictures; return the file. `edit` gets the stage and the shaders."""
    Image.fromarray(np.full((2, 2, 3), (10, 20, 30), np.uint8)).save(tmp_path / "a.png")
    stage = Usd.Stage.CreateNew(str(tmp_path / "card.usda"))
    root = UsdGeom.Xform.Define(stage, "/card")
    stage.SetDefaultPrim(root.GetPrim())
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    mesh = UsdGeom.Mesh.Define(stage, "/card/Mesh")
    mesh.CreatePointsAttr([Gf.Vec3f(0), Gf.Vec3f(1, 0, 0), Gf.Vec3f(1, 1, 0), Gf.Vec3f(0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateDisplayColorPrimvar("vertex").Set([Gf.Vec3f(0.25 * k, 0, 1) for k in range(4)])
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", T.TexCoord2fArray, "vertex")
    st.Set([Gf.Vec2f(0, 0), Gf.Vec2f(1, 0), Gf.Vec2f(1, 1), Gf.Vec2f(0, 1)])
    material = UsdShade.Material.Define(stage, "/card/M")
    kinds = {"S": "PreviewSurface", "T": "UVTexture", "N": "UVTexture", "R": "PrimvarReader_float2", "X": "Transform2d"}
    shaders = {name: UsdShade.Shader.Define(stage, f"/card/M/{name}") for name in kinds}
    for name, kind in kinds.items():
        shaders[name].CreateIdAttr(f"Usd{kind}")
    material.CreateSurfaceOutput().ConnectToSource(shaders["S"].ConnectableAPI(), "surface")
    shaders["R"].CreateInput("varname", T.String).Set("st")
    for name, target, kind in (("T", "diffuseColor", T.Color3f), ("N", "normal", T.Normal3f)):
        shaders[name].CreateInput("file", T.Asset).Set("./a.png")
        shaders[name].CreateInput("st", T.Float2).ConnectToSource(shaders["R"].ConnectableAPI(), "result")
        shaders["S"].CreateInput(target, kind).ConnectToSource(shaders[name].ConnectableAPI(), "rgb")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
    edit(shaders)
    stage.GetRootLayer().Save()
    return tmp_path / "card.usda"


def test_transforms_of_uvs_are_applied(tmp_path):
    def edit(shaders):
        shaders["X"].CreateInput("scale", T.Float2).Set(Gf.Vec2f(2, -1))
        shaders["X"].CreateInput("rotation", T.Float).Set(30.0)
        shaders["X"].CreateInput("translation", T.Float2).Set(Gf.Vec2f(0.25, 1))
        shaders["X"].CreateInput("in", T.Float2).ConnectToSource(shaders["R"].ConnectableAPI(), "result")
        for name in "TN":
            shaders[name].GetInput("st").ConnectToSource(shaders["X"].ConnectableAPI(), "result")

    stage, report, _ = opened(card(tmp_path, edit), tmp_path)
    [mesh] = meshes(stage)
    points = np.array(UsdGeom.Mesh(mesh).GetPointsAttr().Get())[:, :2]
    cosine, sine = np.cos(np.pi / 6), np.sin(np.pi / 6)
    expected = points * (2, -1) @ np.array([[cosine, sine], [-sine, cosine]]) + (0.25, 1)
    found = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get())
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert report.notes == []


def test_wrap_modes_color_spaces_and_normal_maps_of_directx(tmp_path):
    def edit(shaders):
        shaders["T"].CreateInput("wrapS", T.Token).Set("clamp")
        shaders["T"].CreateInput("wrapT", T.Token).Set("mirror")
        shaders["T"].CreateInput("sourceColorSpace", T.Token).Set("raw")
        shaders["N"].CreateInput("scale", T.Float4).Set(Gf.Vec4f(1, -1, 2, 1))
        shaders["N"].CreateInput("bias", T.Float4).Set(Gf.Vec4f(-0.5, 0.5, -1, 0))

    stage, _, _ = opened(card(tmp_path, edit), tmp_path)
    color, _ = source_of(surface(stage), "diffuseColor")
    assert [color.GetInput(name).Get() for name in ("wrapS", "wrapT", "sourceColorSpace")] == ["clamp", "mirror", "raw"]
    normal, _ = source_of(surface(stage), "normal")
    assert (normal.GetInput("scale").Get(), normal.GetInput("bias").Get()) == ((1, 1, 2, 1), (-0.5, -0.5, -1, 0))
    with Image.open(normal.GetInput("file").Get().resolvedPath) as image:
        assert image.getpixel((0, 0)) == (10, 235, 30)


def test_a_color_may_be_that_of_the_mesh(tmp_path):
    def edit(shaders):
        shaders["X"].CreateIdAttr("UsdPrimvarReader_float3")
        shaders["X"].CreateInput("varname", T.String).Set("displayColor")
        shaders["S"].GetInput("diffuseColor").ConnectToSource(shaders["X"].ConnectableAPI(), "result")

    stage, _, _ = opened(card(tmp_path, edit), tmp_path)
    reader, _ = source_of(surface(stage), "diffuseColor")
    assert reader.GetInput("varname").Get() == "displayColor"
    [mesh] = meshes(stage)
    found = UsdGeom.Gprim(mesh).GetDisplayColorAttr().Get()
    assert [tuple(each) for each in found] == [(0.25 * k, 0, 1) for k in range(4)]


def test_prototypes_of_point_instancers_are_not_drawn_where_they_stand(tmp_path):
    def edit(shaders):
        stage = shaders["S"].GetPrim().GetStage()
        instancer = UsdGeom.PointInstancer.Define(stage, "/card/Leaves")
        Sdf.CopySpec(stage.GetRootLayer(), "/card/Mesh", stage.GetRootLayer(), "/card/Leaves/Leaf")
        instancer.CreatePrototypesRel().SetTargets(["/card/Leaves/Leaf"])
        instancer.CreateProtoIndicesAttr([0])
        instancer.CreatePositionsAttr([Gf.Vec3f(5, 0, 0)])
        Sdf.CopySpec(stage.GetRootLayer(), "/card/Mesh", stage.GetRootLayer(), "/card/LeavesBeside")

    _, report, _ = opened(card(tmp_path, edit), tmp_path)
    assert (report.triangles, report.notes) == (4, ["left out: point instancers"])


@pytest.mark.parametrize("family", ["materialBind", "other"])
def test_subsets_and_meshes_without_faces_are_nothing(tmp_path, family):
    def edit(shaders):
        stage = shaders["S"].GetPrim().GetStage()
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/card/Mesh"))
        UsdGeom.Subset.CreateGeomSubset(mesh, "none", "face", [], family)
        UsdGeom.Mesh.Define(stage, "/card/Empty")

    stage, report, _ = opened(card(tmp_path, edit), tmp_path)
    assert (len(list(meshes(stage))), report.triangles, report.repairs) == (1, 2, [])


@pytest.mark.parametrize("purpose", ["full", "preview"])
def test_materials_of_all_purposes_are_those_that_are_drawn(tmp_path, purpose):
    def edit(shaders):
        prim = shaders["S"].GetPrim().GetStage().GetPrimAtPath("/card/Mesh")
        binding, material = UsdShade.MaterialBindingAPI(prim), UsdShade.Material(shaders["S"].GetPrim().GetParent())
        binding.UnbindDirectBinding()
        binding.Bind(material, materialPurpose=purpose)

    stage, report, _ = opened(card(tmp_path, edit), tmp_path)
    assert report.materials == 1
    assert source_of(surface(stage), "diffuseColor")[0].GetInput("file").Get().resolvedPath
