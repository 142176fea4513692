"""Colors in the color space that USD gives them: those of gprims, of materials, of lights; oracle: Gf.ColorSpace."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from usdsdg.errors import Unsupported, UsdsdgWarning, forget_warnings
from usdsdg.stage.prims.handles import Handles
from usdsdg_render.lights.light_values import emitted_color
from usdsdg_render.materials.materials import MaterialLibrary
from usdsdg_render.sync.extract import SceneExtractor
from usdsdg_render.usd.color_spaces import linear_colors, refuse_other_space

T = Sdf.ValueTypeNames
COLOR = (0.5, 0.2, 0.01)
SPACES = ("srgb_rec709_scene", "g18_rec709_scene", "lin_ap1_scene", "srgb_p3d65_scene", "lin_ciexyzd65_scene")


def by_usd(space, color=COLOR):
    """The color as linear Rec. 709, by USD, without what is below 0."""
    linear = Gf.ColorSpace(Gf.ColorSpaceNames.LinearRec709)
    return np.maximum(linear.Convert(Gf.ColorSpace(space), Gf.Vec3f(*color)).GetRGB(), 0.0)


def sphere(stage, path="/World/sphere", colors=(COLOR,)):
    prim = UsdGeom.Sphere.Define(stage, path)
    prim.CreateDisplayColorAttr([Gf.Vec3f(*color) for color in colors])
    return prim


def base_color(stage):
    extractor = SceneExtractor(stage)
    extractor.update()
    scene = extractor.scene
    return scene.materials[scene.material_slots[0]]["base_color"]


@given(color=st.tuples(*[st.floats(0.0, 4.0, width=32)] * 3), space=st.sampled_from(SPACES))
def test_colors_are_converted_as_usd_does(color, space):
    stage = Usd.Stage.CreateInMemory()
    attribute = sphere(stage).GetDisplayColorAttr()
    attribute.SetColorSpace(space)
    assert linear_colors(attribute, np.array([color]))[0] == pytest.approx(by_usd(space, color), rel=1e-4, abs=1e-5)


def test_display_colors_have_the_color_space_of_the_attribute_or_else_of_a_prim_above():
    stage = Usd.Stage.CreateInMemory()
    attribute = sphere(stage).GetDisplayColorAttr()
    assert base_color(stage) == pytest.approx(COLOR)
    Usd.ColorSpaceAPI.Apply(stage.GetPrimAtPath("/World")).CreateColorSpaceNameAttr("srgb_rec709_scene")
    assert base_color(stage) == pytest.approx(by_usd("srgb_rec709_scene"), rel=1e-4)
    attribute.SetColorSpace("lin_ap1_scene")
    assert base_color(stage) == pytest.approx(by_usd("lin_ap1_scene"), rel=1e-4)
    attribute.SetColorSpace("raw")
    assert base_color(stage) == pytest.approx(COLOR)


def test_colors_that_vary_over_a_mesh_are_converted():
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/World/mesh")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    mesh.CreateSubdivisionSchemeAttr("none")
    primvar = mesh.CreateDisplayColorPrimvar("vertex")
    primvar.Set([COLOR, (1, 0, 0), (0, 0, 1)])
    primvar.GetAttr().SetColorSpace("srgb_rec709_scene")
    extractor = SceneExtractor(stage)
    extractor.update()
    colors = extractor.scene.prototypes[0].colors
    assert colors[0, 0, :3] == pytest.approx(by_usd("srgb_rec709_scene"), rel=1e-4)


@pytest.mark.parametrize("name", ["srgb_texture", "sRGB", "srgb_rec709_scene"])
@pytest.mark.parametrize("kind", ["Color3f", "Color4f", "Color3d", "Float3"])
def test_constants_of_materials_have_the_color_space_of_their_input(name, kind):
    stage = Usd.Stage.CreateInMemory()
    material = UsdShade.Material.Define(stage, "/Looks/M")
    shader = UsdShade.Shader.Define(stage, "/Looks/M/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    value = (*COLOR, 1.0) if kind == "Color4f" else COLOR
    attribute = shader.CreateInput("diffuseColor", getattr(T, kind)).GetAttr()
    attribute.Set(value)
    attribute.SetColorSpace(name)
    shader.CreateInput("roughness", T.Float).Set(0.4)
    read = MaterialLibrary(stage, Handles()).read(material.GetPrim())
    expected = COLOR if kind == "Float3" else by_usd("srgb_rec709_scene")
    assert read.base_color.value == pytest.approx(expected, rel=1e-4)
    assert read.roughness.value == pytest.approx((0.4,))


def test_colors_of_materials_are_converted_after_edits_too():
    stage = Usd.Stage.CreateInMemory()
    material = UsdShade.Material.Define(stage, "/Looks/M")
    shader = UsdShade.Shader.Define(stage, "/Looks/M/Shader")
    shader.GetImplementationSourceAttr().Set("sourceAsset")
    shader.SetSourceAsset("OmniPBR.mdl", "mdl")
    shader.SetSourceAssetSubIdentifier("OmniPBR", "mdl")
    material.CreateSurfaceOutput("mdl").ConnectToSource(shader.ConnectableAPI(), "out")
    color = shader.CreateInput("diffuse_color_constant", T.Color3f)
    color.GetAttr().SetColorSpace("srgb_rec709_scene")
    UsdShade.MaterialBindingAPI.Apply(sphere(stage).GetPrim()).Bind(material)
    extractor = SceneExtractor(stage)
    for value in (COLOR, (0.1, 0.2, 0.3), (0.9, 0.8, 0.7)):
        color.Set(value)
        extractor.update()
        scene = extractor.scene
        shown = scene.materials[scene.material_slots[0]]["base_color"]
        assert shown == pytest.approx(by_usd("srgb_rec709_scene", value), rel=1e-4)


def test_colors_of_lights_have_the_color_space_of_their_input():
    stage = Usd.Stage.CreateInMemory()
    light = UsdLux.SphereLight.Define(stage, "/Light")
    light.CreateColorAttr(COLOR).SetColorSpace("srgb_rec709_scene")
    light.CreateIntensityAttr(1.0)
    assert emitted_color(light.GetPrim()) == pytest.approx(by_usd("srgb_rec709_scene"), rel=1e-4)


def test_unknown_color_spaces_are_named_once_and_count_as_linear():
    forget_warnings()
    stage = Usd.Stage.CreateInMemory()
    for name in ("a", "b"):
        sphere(stage, f"/World/{name}").GetDisplayColorAttr().SetColorSpace("bogus")
    with pytest.warns(UsdsdgWarning, match=r"/World/a.primvars:displayColor: its color space 'bogus'") as told:
        assert base_color(stage) == pytest.approx(COLOR)
    assert len(told) == 1


def test_color_spaces_of_numbers_are_nothing(recwarn):
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/World")
    Usd.ColorSpaceAPI.Apply(prim).CreateColorSpaceNameAttr("bogus")
    refuse_other_space(prim.CreateAttribute("inputs:roughness", T.Float))
    assert not recwarn.list


def test_colors_that_differ_between_worlds_are_linear():
    stage = Usd.Stage.CreateInMemory()
    attribute = sphere(stage).GetDisplayColorAttr()
    refuse_other_space(attribute)
    attribute.SetColorSpace("srgb_rec709_scene")
    with pytest.raises(Unsupported, match=r"primvars:displayColor: a color in the color space srgb_rec709_scene"):
        refuse_other_space(attribute)


def test_textures_have_the_color_space_of_a_prim_above_where_they_are_colors(tmp_path):
    Image.fromarray(np.full((2, 2, 3), 128, np.uint8)).save(tmp_path / "a.png")
    stage = Usd.Stage.CreateInMemory()
    material = UsdShade.Material.Define(stage, "/Looks/M")
    Usd.ColorSpaceAPI.Apply(stage.GetPrimAtPath("/Looks")).CreateColorSpaceNameAttr("lin_rec709_scene")
    shader, texture = (UsdShade.Shader.Define(stage, f"/Looks/M/{name}") for name in ("Surface", "Tex"))
    shader.CreateIdAttr("UsdPreviewSurface")
    texture.CreateIdAttr("UsdUVTexture")
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    texture.CreateInput("file", T.Asset).Set(str(tmp_path / "a.png"))
    shader.CreateInput("diffuseColor", T.Color3f).ConnectToSource(texture.ConnectableAPI(), "rgb")
    shader.CreateInput("roughness", T.Float).ConnectToSource(texture.ConnectableAPI(), "r")
    read = MaterialLibrary(stage, Handles()).read(material.GetPrim())
    assert (read.base_color.texture.color_space, read.roughness.texture.color_space) == ("raw", "auto")


def texture_of(tmp_path, space, *, mtlx=False):
    """The color space of the file that an OmniPBR, or a standard_surface of MaterialX, has for its color."""
    Image.fromarray(np.full((2, 2, 3), 90, np.uint8)).save(tmp_path / "a.png")
    stage = Usd.Stage.CreateInMemory()
    material = UsdShade.Material.Define(stage, "/Looks/M")
    shader = UsdShade.Shader.Define(stage, "/Looks/M/Shader")
    material.CreateSurfaceOutput("mtlx" if mtlx else "mdl").ConnectToSource(shader.ConnectableAPI(), "out")
    if mtlx:
        shader.CreateIdAttr("ND_standard_surface_surfaceshader")
        image = UsdShade.Shader.Define(stage, "/Looks/M/Image")
        image.CreateIdAttr("ND_image_color3")
        shader.CreateInput("base_color", T.Color3f).ConnectToSource(image.ConnectableAPI(), "out")
    else:
        shader.GetImplementationSourceAttr().Set("sourceAsset")
        shader.SetSourceAsset("OmniPBR.mdl", "mdl")
        shader.SetSourceAssetSubIdentifier("OmniPBR", "mdl")
        image = shader
    file = image.CreateInput("file" if mtlx else "diffuse_texture", T.Asset)
    file.Set(str(tmp_path / "a.png"))
    if space:
        file.GetAttr().SetColorSpace(space)
    return MaterialLibrary(stage, Handles()).read(material.GetPrim()).base_color.texture.color_space


@pytest.mark.parametrize(
    ("space", "mdl", "mtlx"),
    [
        ("", "sRGB", "raw"), ("auto", "sRGB", "raw"), ("sRGB", "sRGB", "sRGB"), ("srgb_texture", "sRGB", "sRGB"),
        ("lin_rec709_scene", "raw", "raw"), ("lin_rec709", "raw", "raw"), ("raw", "raw", "raw"),
    ],
)  # fmt: skip
def test_textures_of_mdl_and_material_x_have_every_name_of_a_color_space(space, mdl, mtlx, tmp_path, recwarn):
    assert (texture_of(tmp_path, space), texture_of(tmp_path, space, mtlx=True)) == (mdl, mtlx)
    assert not [each for each in recwarn if "color space" in str(each.message)]


@pytest.mark.parametrize("mtlx", [False, True])
def test_color_spaces_that_textures_cannot_have_are_told(mtlx, tmp_path):
    forget_warnings()
    where = "/Looks/M/Image" if mtlx else "/Looks/M/Shader"
    with pytest.warns(UsdsdgWarning, match=f"{where}: .*color space 'lin_ap1_scene' of inputs:"):
        texture_of(tmp_path, "lin_ap1_scene", mtlx=mtlx)
