"""Materials and primvars of USD files that are converted: the same look as where the file is drawn as it is."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdShade

from tests.meshes.test_conversion import meshes, opened, source_of, surface
from tests.meshes.test_usdz import card

pytestmark = pytest.mark.usefixtures("own_cache")
T = Sdf.ValueTypeNames


def stage_of(shaders):
    return shaders["S"].GetPrim().GetStage()


def texture_coordinates(stage):
    [mesh] = meshes(stage)
    return np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get())


def test_inputs_come_through_the_interface_of_the_material(tmp_path):
    def edit(shaders):
        material = UsdShade.Material(shaders["S"].GetPrim().GetParent())
        for name, kind in (("file", T.Asset), ("scale", T.Float4)):
            given = shaders["T"].CreateInput(name, kind)
            value = given.Get() if name == "file" else Gf.Vec4f(0.5, 0.25, 0.125, 1)
            given.GetAttr().Clear()
            offered = material.CreateInput(name, kind)
            offered.Set(value)
            given.ConnectToSource(offered)

    stage, report, _ = opened(card(tmp_path, edit), tmp_path)
    color, _ = source_of(surface(stage), "diffuseColor")
    assert color.GetInput("file").Get().resolvedPath
    assert color.GetInput("scale").Get() == Gf.Vec4f(0.5, 0.25, 0.125, 1)
    assert report.notes == []


@pytest.mark.parametrize("value", [Gf.Vec3f(1, 0, 0), [Gf.Vec3f(1, 0, 0)]])
@pytest.mark.parametrize("path", ["/card", "/card/Mesh"])
def test_one_color_is_that_of_all_points_wherever_it_is_authored(value, path, tmp_path):
    def edit(shaders):
        stage = stage_of(shaders)
        UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/card/Mesh")).UnbindAllBindings()
        stage.GetPrimAtPath("/card/Mesh").RemoveProperty("primvars:displayColor")
        kind = (
            T.Color3f if isinstance(value, Gf.Vec3f) else T.Color3fArray
        )  # the schema wants an array, files may differ
        spec = stage.GetRootLayer().GetPrimAtPath(path)
        Sdf.AttributeSpec(spec, "primvars:displayColor", kind).default = value

    stage, _, _ = opened(card(tmp_path, edit), tmp_path)
    [mesh] = meshes(stage)
    assert {tuple(each) for each in UsdGeom.Gprim(mesh).GetDisplayColorAttr().Get()} == {(1, 0, 0)}


def test_texture_coordinates_of_another_name_are_found_as_where_they_are_drawn(tmp_path):
    expected = texture_coordinates(opened(card(tmp_path, lambda shaders: None), tmp_path)[0])

    def edit(shaders):
        mesh = stage_of(shaders).GetPrimAtPath("/card/Mesh")
        st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
        UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("UVMap", st.GetTypeName(), st.GetInterpolation()).Set(st.Get())
        mesh.RemoveProperty("primvars:st")

    (tmp_path / "renamed").mkdir()
    stage, _, _ = opened(card(tmp_path / "renamed", edit), tmp_path / "renamed")
    np.testing.assert_array_equal(texture_coordinates(stage), expected)


def test_constant_texture_coordinates_are_those_of_all_points(tmp_path):
    def edit(shaders):
        for name in "TN":
            shaders[name].GetInput("st").GetAttr().ClearConnections()
            shaders[name].GetInput("st").Set(Gf.Vec2f(0.25, 0.75))

    stage, _, _ = opened(card(tmp_path, edit), tmp_path)
    found = texture_coordinates(stage)
    np.testing.assert_array_equal(found, np.broadcast_to((0.25, 0.75), found.shape))


def test_the_color_space_may_be_that_of_the_file_attribute(tmp_path):
    def edit(shaders):
        shaders["T"].GetInput("file").GetAttr().SetColorSpace("raw")

    stage, _, _ = opened(card(tmp_path, edit), tmp_path)
    color, _ = source_of(surface(stage), "diffuseColor")
    assert color.GetInput("sourceColorSpace").Get() == "raw"


@pytest.mark.parametrize("output", ["rgb", "g"])
def test_a_picture_that_is_missing_leaves_its_fallback(output, tmp_path):
    def edit(shaders):
        shaders["T"].GetInput("file").Set(Sdf.AssetPath("gone.png"))
        shaders["T"].CreateInput("fallback", T.Float4).Set(Gf.Vec4f(1, 0.5, 0.25, 1))
        if output == "g":
            shaders["T"].CreateOutput("g", T.Float)
            shaders["S"].CreateInput("roughness", T.Float).ConnectToSource(shaders["T"].ConnectableAPI(), "g")

    stage, _, _ = opened(card(tmp_path, edit), tmp_path)
    shader = surface(stage)
    assert shader.GetInput("diffuseColor").Get() == Gf.Vec3f(1, 0.5, 0.25)
    assert output == "rgb" or shader.GetInput("roughness").Get() == 0.5


def test_what_is_lost_is_named(tmp_path):
    def edit(shaders):
        stage = stage_of(shaders)
        shaders["X"].CreateIdAttr("UsdPrimvarReader_float3")
        shaders["X"].CreateInput("varname", T.String).Set("tint")
        shaders["S"].GetInput("diffuseColor").ConnectToSource(shaders["X"].ConnectableAPI(), "result")
        Sdf.CopySpec(stage.GetRootLayer(), "/card/Mesh", stage.GetRootLayer(), "/Beside")
        Sdf.CopySpec(stage.GetRootLayer(), "/card/Mesh", stage.GetRootLayer(), "/card/Clear")
        UsdGeom.Mesh(stage.GetPrimAtPath("/card/Mesh")).CreateCreaseIndicesAttr([0, 1])
        UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/card/Clear")).UnbindAllBindings()
        UsdGeom.Gprim(stage.GetPrimAtPath("/card/Clear")).CreateDisplayOpacityAttr([0.5])

    _, report, _ = opened(card(tmp_path, edit), tmp_path)
    assert sorted(report.notes) == [
        "/card/M/X: what UsdPrimvarReader_float3 gives to diffuseColor is left out",
        "left out: 1 shape beside the default prim /card",
        "left out: displayOpacity",
        "left out: subdivision",
    ]
