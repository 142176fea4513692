"""UsdShade networks to material rows: every input that is read, bindings, fallbacks, what is named."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from usdsdg.stage.colors import srgb_to_linear
from usdsdg.stage.prims.handles import Handles
from usdsdg_render.images.image_files import asset_file
from usdsdg_render.images.textures import TexturePool
from usdsdg_render.materials.bindings import bound_materials
from usdsdg_render.materials.display_color import Shown, fallback_material
from usdsdg_render.materials.material_table import MaterialTable
from usdsdg_render.materials.materials import MaterialLibrary
from usdsdg_render.scene import scene
from usdsdg_render.sync.extract import SceneExtractor

T = Sdf.ValueTypeNames


def written(materials):
    """The rows of materials in a table, and the textures."""
    table = MaterialTable()
    taken = [table.take(material) for material in materials]
    rows, textures = table.write(TexturePool())
    return rows[taken], textures or []


class Looks:
    """A stage with one material, and short ways to author it."""

    def __init__(self, surface="UsdPreviewSurface"):
        self.stage = Usd.Stage.CreateInMemory()
        self.material = UsdShade.Material.Define(self.stage, "/Looks/M")
        self.surface = self.shader("/Looks/M/Surface", surface)
        self.material.CreateSurfaceOutput().ConnectToSource(self.surface.ConnectableAPI(), "surface")

    def shader(self, path, kind):
        shader = UsdShade.Shader.Define(self.stage, path)
        shader.CreateIdAttr(kind)
        return shader

    def texture(self, file, name="Tex", **inputs):
        texture = self.shader(f"/Looks/M/{name}", "UsdUVTexture")
        texture.CreateInput("file", T.Asset).Set(str(file))
        for key, value in inputs.items():
            kind = T.Token if isinstance(value, str) else T.Float4
            texture.CreateInput(key, kind).Set(value)
        return texture

    def connect(self, name, texture, output="rgb"):
        kind = T.Color3f if output == "rgb" else T.Float
        self.surface.CreateInput(name, kind).ConnectToSource(texture.ConnectableAPI(), output)

    def set(self, name, kind, value):
        self.surface.CreateInput(name, kind).Set(value)

    def read(self):
        return MaterialLibrary(self.stage, Handles()).read(self.material.GetPrim())

    def row(self):
        rows, textures = written([self.read()])
        return rows[0], textures


class Mdl(Looks):
    def __init__(self, name="OmniPBR", by="subIdentifier"):
        self.stage = Usd.Stage.CreateInMemory()
        self.material = UsdShade.Material.Define(self.stage, "/Looks/M")
        self.surface = UsdShade.Shader.Define(self.stage, "/Looks/M/Shader")
        self.surface.GetImplementationSourceAttr().Set("sourceAsset")
        self.surface.SetSourceAsset(f"{name}.mdl", "mdl")
        if by == "subIdentifier":
            self.surface.SetSourceAssetSubIdentifier(name, "mdl")
        self.material.CreateSurfaceOutput("mdl").ConnectToSource(self.surface.ConnectableAPI(), "out")


def save(path, value, size=4):
    Image.fromarray(np.full((size, size, len(value)), value, np.uint8)).save(path)
    return path


def test_a_bare_preview_surface_has_the_specs_defaults():
    row, _ = Looks().row()
    np.testing.assert_allclose(row["base_color"], 0.18)
    assert (row["metallic"], row["roughness"], row["opacity"], row["opacity_threshold"]) == (0, 0.5, 1, 0)
    np.testing.assert_allclose(row["specular"], 0.04, rtol=1e-6)  # ior 1.5
    assert (row["emission"] == 0).all()
    assert row["clearcoat"] == 0
    for name in ("base_color", "metallic", "roughness", "opacity", "emission", "normal"):
        assert row[f"{name}_texture"] == scene.NO_TEXTURE


@pytest.mark.parametrize(
    ("name", "kind", "value", "column", "expected"),
    [
        ("diffuseColor", T.Color3f, Gf.Vec3f(0.1, 0.2, 0.3), "base_color", (0.1, 0.2, 0.3)),
        ("metallic", T.Float, 0.7, "metallic", 0.7),
        ("roughness", T.Float, 0.2, "roughness", 0.2),
        ("opacity", T.Float, 0.4, "transmission", 0.6),  # of a clear pane
        ("opacityThreshold", T.Float, 0.3, "opacity_threshold", 0.3),
        ("emissiveColor", T.Color3f, Gf.Vec3f(5, 6, 7), "emission", (5, 6, 7)),
        ("clearcoat", T.Float, 0.6, "clearcoat", 0.6),
        ("clearcoatRoughness", T.Float, 0.05, "clearcoat_roughness", 0.05),
        ("ior", T.Float, 2.0, "specular", (1 / 9, 1 / 9, 1 / 9)),
    ],
)
def test_constants_reach_their_column(name, kind, value, column, expected):
    looks = Looks()
    looks.set(name, kind, value)
    np.testing.assert_allclose(looks.row()[0][column], expected, rtol=1e-6)


def test_specular_workflow_takes_its_color_and_no_metal():
    looks = Looks()
    looks.set("useSpecularWorkflow", T.Int, 1)
    looks.set("specularColor", T.Color3f, Gf.Vec3f(0.3, 0.2, 0.1))
    looks.set("metallic", T.Float, 1.0)
    row, _ = looks.row()
    np.testing.assert_allclose(row["specular"], (0.3, 0.2, 0.1), rtol=1e-6)
    assert row["metallic"] == 0


def test_a_texture_comes_with_its_wraps_and_scale(tmp_path):
    looks = Looks()
    file = save(tmp_path / "a.png", (10, 20, 30))
    texture = looks.texture(file, wrapS="clamp", wrapT="mirror", scale=Gf.Vec4f(0.5, 0.25, 2, 1))
    looks.connect("diffuseColor", texture)
    row, textures = looks.row()
    np.testing.assert_allclose(row["base_color"], (0.5, 0.25, 2.0))
    loaded = textures[row["base_color_texture"]]
    assert (loaded.path, loaded.wrap_s, loaded.wrap_t) == (str(file), scene.WRAP_CLAMP, scene.WRAP_MIRROR)
    assert loaded.srgb
    assert looks.read().uv_primvar == "st"  # docs/materials.md: where no reader is connected


@pytest.mark.parametrize("wrap", ["useMetadata", None])
def test_wraps_repeat_unless_they_say_otherwise(wrap, tmp_path):
    looks = Looks()
    options = {} if wrap is None else {"wrapS": wrap}
    looks.connect("diffuseColor", looks.texture(save(tmp_path / "a.png", (1, 2, 3)), **options))
    row, textures = looks.row()
    assert textures[row["base_color_texture"]].wrap_s == scene.WRAP_REPEAT


@pytest.mark.parametrize(("space", "coded"), [("raw", False), ("sRGB", True), ("auto", True)])
def test_source_color_space(space, coded, tmp_path):
    looks = Looks()
    looks.connect("diffuseColor", looks.texture(save(tmp_path / "a.png", (1, 2, 3)), sourceColorSpace=space))
    row, textures = looks.row()
    assert textures[row["base_color_texture"]].srgb is coded


def test_channels_of_one_packed_file_share_a_texture(tmp_path):
    looks = Looks()
    packed = looks.texture(save(tmp_path / "orm.png", (10, 20, 30, 40)), sourceColorSpace="raw")
    for name, output in (("roughness", "g"), ("metallic", "b"), ("opacity", "a")):
        looks.connect(name, packed, output)
    row, textures = looks.row()
    assert len(textures) == 1
    assert (row["roughness_channel"], row["metallic_channel"], row["opacity_channel"]) == (1, 2, 3)
    assert (row["roughness"], row["metallic"], row["opacity"]) == (1, 1, 1)


def test_scale_and_bias_are_the_textures_own(tmp_path):
    looks = Looks()
    texture = looks.texture(save(tmp_path / "a.png", (51, 51, 51)), sourceColorSpace="raw")
    texture.CreateInput("scale", T.Float4).Set(Gf.Vec4f(0.5))
    texture.CreateInput("bias", T.Float4).Set(Gf.Vec4f(0.25))
    looks.connect("roughness", texture, "r")
    row, textures = looks.row()
    assert row["roughness"] == 1.0
    used = textures[row["roughness_texture"]]
    assert (used.scale, used.bias) == ((0.5,) * 4, (0.25,) * 4)
    assert used.texels[0, 0, 0] == 51


def test_transform_and_primvar_name_are_followed(tmp_path):
    looks = Looks()
    texture = looks.texture(save(tmp_path / "a.png", (1, 2, 3)))
    transform = looks.shader("/Looks/M/Transform", "UsdTransform2d")
    transform.CreateInput("scale", T.Float2).Set(Gf.Vec2f(2, 3))
    transform.CreateInput("rotation", T.Float).Set(90.0)
    transform.CreateInput("translation", T.Float2).Set(Gf.Vec2f(0.25, 0.5))
    reader = looks.shader("/Looks/M/Reader", "UsdPrimvarReader_float2")
    # The name comes through the material's interface, as exporters like it.
    name = looks.material.CreateInput("uvName", T.String)
    name.Set("UVMap")
    reader.CreateInput("varname", T.String).ConnectToSource(name)
    transform.CreateInput("in", T.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
    texture.CreateInput("st", T.Float2).ConnectToSource(transform.ConnectableAPI(), "result")
    looks.connect("diffuseColor", texture)
    row, textures = looks.row()
    np.testing.assert_allclose(textures[row["base_color_texture"]].transform, [[0, -3, 0.25], [2, 0, 0.5]], atol=1e-12)
    assert looks.read().uv_primvar == "UVMap"


def test_transforms_one_after_the_other_are_all_applied(tmp_path):
    looks = Looks()
    texture = looks.texture(save(tmp_path / "a.png", (1, 2, 3)))
    source, output, matrix = looks.shader("/Looks/M/Reader", "UsdPrimvarReader_float2"), "result", np.eye(3)
    for k, (scale, degrees, move) in enumerate([((2, 3), 90, (0.25, 0.5)), ((0.5, 4), -30, (-1, 2))]):
        transform = looks.shader(f"/Looks/M/Transform{k}", "UsdTransform2d")
        transform.CreateInput("scale", T.Float2).Set(Gf.Vec2f(*scale))
        transform.CreateInput("rotation", T.Float).Set(float(degrees))
        transform.CreateInput("translation", T.Float2).Set(Gf.Vec2f(*move))
        transform.CreateInput("in", T.Float2).ConnectToSource(source.ConnectableAPI(), output)
        source, angle = transform, np.radians(degrees)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        step = np.eye(3)
        step[:2, :2], step[:2, 2] = turn @ np.diag(scale), move
        matrix = step @ matrix
    texture.CreateInput("st", T.Float2).ConnectToSource(source.ConnectableAPI(), "result")
    looks.connect("diffuseColor", texture)
    row, textures = looks.row()
    np.testing.assert_allclose(textures[row["base_color_texture"]].transform, matrix[:2], atol=1e-12)


def test_transforms_in_a_circle_are_named(tmp_path):
    looks = Looks()
    texture = looks.texture(save(tmp_path / "a.png", (1, 2, 3)))
    transform = looks.shader("/Looks/M/Transform", "UsdTransform2d")
    transform.CreateInput("in", T.Float2).ConnectToSource(transform.ConnectableAPI(), "result")
    texture.CreateInput("st", T.Float2).ConnectToSource(transform.ConnectableAPI(), "result")
    looks.connect("diffuseColor", texture)
    with pytest.warns(UserWarning, match="/Looks/M/Transform: .*Connect a UsdPrimvarReader_float2"):
        assert looks.read().uv_primvar == "st"


def test_values_come_through_the_interface_and_node_graphs(tmp_path):
    looks = Looks()
    tint = looks.material.CreateInput("tint", T.Color3f)
    tint.Set(Gf.Vec3f(0.9, 0.8, 0.7))
    looks.surface.CreateInput("diffuseColor", T.Color3f).ConnectToSource(tint)
    graph = UsdShade.NodeGraph.Define(looks.stage, "/Looks/Graph")
    texture = looks.shader("/Looks/Graph/Tex", "UsdUVTexture")
    texture.CreateInput("file", T.Asset).Set(str(save(tmp_path / "a.png", (1, 2, 3))))
    graph.CreateOutput("rough", T.Float).ConnectToSource(texture.ConnectableAPI(), "g")
    looks.surface.CreateInput("roughness", T.Float).ConnectToSource(graph.ConnectableAPI(), "rough")
    row, _ = looks.row()
    np.testing.assert_allclose(row["base_color"], (0.9, 0.8, 0.7), rtol=1e-6)
    assert row["roughness_texture"] >= 0
    assert row["roughness_channel"] == 1


@pytest.mark.parametrize("scale", [None, 2.0])
def test_normal_maps_are_raw_and_as_the_kernels_read_them(scale, tmp_path):
    looks = Looks()
    texture = looks.texture(save(tmp_path / "n.png", (128, 64, 255)))
    if scale is not None:
        texture.CreateInput("scale", T.Float4).Set(Gf.Vec4f(2, 2, 2, 1))
        texture.CreateInput("bias", T.Float4).Set(Gf.Vec4f(-1, -1, -1, 0))
    looks.connect("normal", texture)
    row, textures = looks.row()
    loaded = textures[row["normal_texture"]]
    assert not loaded.srgb
    assert loaded.texels[0, 0, :3].tolist() == [128, 64, 255]
    assert (loaded.scale, loaded.bias) == ((1.0,) * 4, (0.0,) * 4)


def test_normal_maps_with_green_turned_round(tmp_path):
    looks = Looks()
    texture = looks.texture(save(tmp_path / "n.png", (128, 64, 255)))
    texture.CreateInput("scale", T.Float4).Set(Gf.Vec4f(2, -2, 2, 1))
    texture.CreateInput("bias", T.Float4).Set(Gf.Vec4f(-1, 1, -1, 0))
    looks.connect("normal", texture)
    row, textures = looks.row()
    loaded = textures[row["normal_texture"]]
    assert (loaded.scale, loaded.bias) == ((1.0, -1.0, 1.0, 1.0), (0.0, 1.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("file", "inputs", "expected"),
    [
        ("n.hdr", {}, (0.5, 0.25, 0.875)),  # the numbers of the file
        ("n.hdr", dict(scale=Gf.Vec4f(2, 2, 2, 1), bias=Gf.Vec4f(-1, -1, -1, 0)), (0.0, -0.5, 0.75)),
        ("n.png", {}, (0.0, -0.5, 0.75)),
        ("n.png", dict(scale=Gf.Vec4f(1), bias=Gf.Vec4f(0)), (0.5, 0.25, 0.875)),
        ("n.png", dict(scale=Gf.Vec4f(2, 2, 2, 1)), (1.0, 0.5, 1.75)),  # the bias of UsdUVTexture is 0
    ],
)
@pytest.mark.filterwarnings("ignore:.*point all normals one way")
def test_normals_are_those_of_floats_or_of_the_authored_scale_and_bias(file, inputs, expected, tmp_path):
    save(tmp_path / "n.png", (128, 64, 223))
    # Radiance: mantissas and the exponent 128 of 2^0.
    (tmp_path / "n.hdr").write_bytes(b"#?RADIANCE\n\n-Y 1 +X 1\n" + bytes([128, 64, 224, 128]))
    looks = Looks()
    looks.connect("normal", looks.texture(tmp_path / file, **inputs))
    row, textures = looks.row()
    loaded = textures[row["normal_texture"]]
    texel = loaded.texels[0, 0] / (255.0 if loaded.texels.dtype == np.uint8 else 1.0)
    # Kernels take 2 * texel - 1.
    found = 2.0 * (texel * loaded.scale + loaded.bias)[:3] - 1.0
    np.testing.assert_allclose(found, expected, atol=0.005)


def test_a_normal_map_whose_normals_all_point_one_way_is_named(tmp_path):
    looks = Looks()
    inputs = dict(scale=Gf.Vec4f(1), bias=Gf.Vec4f(0))
    looks.connect("normal", looks.texture(save(tmp_path / "n.png", (128, 128, 255)), **inputs))
    with pytest.warns(UserWarning, match=r"/Looks/M/Tex: .*\(2, 2, 2, 1\)"):
        looks.read()


@pytest.mark.parametrize("fallback", [None, (0.3, 0.6, 0.9, 1.0)])
@pytest.mark.parametrize("file", ["missing.png", "broken.png"])
def test_unreadable_textures_are_named_and_the_fallback_counts(file, fallback, tmp_path):
    (tmp_path / "broken.png").write_bytes(b"no image")
    looks = Looks()
    texture = looks.texture(tmp_path / file, scale=Gf.Vec4f(9))
    if fallback:
        texture.CreateInput("fallback", T.Float4).Set(Gf.Vec4f(*fallback))
    looks.connect("diffuseColor", texture)
    with pytest.warns(UserWarning, match=f"/Looks/M/Tex.*{file}"):
        row, _ = looks.row()
    assert row["base_color_texture"] == scene.NO_TEXTURE
    np.testing.assert_allclose(row["base_color"], fallback[:3] if fallback else (0.18,) * 3, rtol=1e-6)


def test_specular_and_coat_textures_are_looked_up(tmp_path):
    looks = Looks()
    looks.set("useSpecularWorkflow", T.Int, 1)
    file = save(tmp_path / "s.png", (9, 9, 9))
    looks.connect("specularColor", looks.texture(file, scale=Gf.Vec4f(0.4, 0.2, 0.1, 1)))
    coat = looks.texture(file, "Coat", sourceColorSpace="raw")
    looks.connect("clearcoat", coat, "g")
    looks.connect("clearcoatRoughness", coat, "b")
    row, textures = looks.row()
    np.testing.assert_allclose(row["specular"], (0.4, 0.2, 0.1), rtol=1e-6)
    assert textures[row["specular_texture"]].srgb
    assert row["clearcoat_texture"] == row["clearcoat_roughness_texture"] != row["specular_texture"]
    assert (row["clearcoat_channel"], row["clearcoat_roughness_channel"]) == (1, 2)


def test_a_channel_may_be_a_color(tmp_path):
    looks = Looks()
    looks.connect(
        "diffuseColor", looks.texture(save(tmp_path / "a.png", (10, 20, 30, 40)), sourceColorSpace="raw"), "a"
    )
    row, textures = looks.row()
    assert textures[row["base_color_texture"]].texels[0, 0].tolist() == [40, 40, 40, 40]


def test_tiles_are_read_and_the_fallback_lies_beyond(tmp_path):
    for tile in (1001, 1012):
        save(tmp_path / f"a.{tile}.png", (9, 9, 9))
    looks = Looks()
    looks.connect("diffuseColor", looks.texture(tmp_path / "a.<UDIM>.png", fallback=Gf.Vec4f(0.5, 0.25, 0.125, 1)))
    row, textures = looks.row()
    used = textures[row["base_color_texture"]]
    assert [number for number, _ in used.tiles] == [0, 11]
    np.testing.assert_allclose(used.texels[0, 0], (0.5, 0.25, 0.125, 1))


def test_material_x_has_a_node_of_the_preview_surface():
    looks = Looks("ND_UsdPreviewSurface_surfaceshader")
    looks.set("diffuseColor", T.Color3f, Gf.Vec3f(1, 0.5, 0))
    looks.set("metallic", T.Float, 0.25)
    row, _ = looks.row()
    assert row["base_color"].tolist() == [1, 0.5, 0]
    assert row["metallic"] == 0.25
    looks.material.GetSurfaceOutput().ClearSources()
    looks.material.CreateSurfaceOutput("mtlx").ConnectToSource(looks.surface.ConnectableAPI(), "surface")
    assert looks.row()[0] == row


def test_material_x_has_the_nodes_of_the_preview_surface(tmp_path, recwarn):
    looks = Looks("ND_UsdPreviewSurface_surfaceshader")
    texture = looks.texture(save(tmp_path / "a.png", (10, 20, 30)), wrapS="periodic", wrapT="mirror")
    texture.CreateIdAttr("ND_UsdUVTexture_23")
    texture.GetInput("file").GetAttr().SetColorSpace("srgb_texture")
    reader = looks.shader("/Looks/M/Reader", "ND_UsdPrimvarReader_vector2")
    reader.CreateInput("varname", T.String).Set("UVMap")
    transform = looks.shader("/Looks/M/Transform", "ND_UsdTransform2d")
    transform.CreateInput("scale", T.Float2).Set(Gf.Vec2f(2, 3))
    transform.CreateInput("in", T.Float2).ConnectToSource(reader.ConnectableAPI(), "out")
    texture.CreateInput("st", T.Float2).ConnectToSource(transform.ConnectableAPI(), "out")
    rough = looks.shader("/Looks/M/Rough", "ND_UsdPrimvarReader_float")
    rough.CreateInput("varname", T.String).Set("rough")
    looks.connect("diffuseColor", texture)
    looks.connect("normal", texture)
    looks.connect("roughness", rough, "out")
    row, textures = looks.row()
    color = textures[row["base_color_texture"]]
    assert (color.srgb, color.wrap_s, color.wrap_t) == (True, scene.WRAP_REPEAT, scene.WRAP_MIRROR)
    assert (color.transform.u_row[0], color.transform.v_row[1]) == (2, 3)
    assert row["normal_texture"] >= 0
    material = looks.read()
    assert (material.uv_primvar, [each.primvar for each in material.primvar_inputs]) == ("UVMap", ["rough"])
    assert not recwarn.list


def test_a_surface_without_an_id_is_named():
    looks = Looks()
    looks.surface.GetPrim().RemoveProperty("info:id")
    with pytest.warns(UserWarning, match="/Looks/M: /Looks/M/Surface has no info:id; the displayColor"):
        assert looks.read() is None


@pytest.mark.parametrize("name", [r".\maps\a.png", r"maps\a.png", r".\maps\u.<UDIM>.png"])
def test_paths_that_were_written_on_windows_are_read(name, tmp_path):
    (tmp_path / "maps").mkdir()
    save(tmp_path / "maps" / "a.png", (1, 2, 3))
    save(tmp_path / "maps" / "u.1001.png", (1, 2, 3))
    layer = Sdf.Layer.CreateNew(str(tmp_path / "scene.usda"))
    prim = Sdf.CreatePrimInLayer(layer, "/T")
    Sdf.AttributeSpec(prim, "inputs:file", T.Asset).default = Sdf.AssetPath(name)
    stage = Usd.Stage.Open(layer)
    found = asset_file(stage.GetAttributeAtPath("/T.inputs:file"))
    assert found == (name, str(tmp_path / "maps" / name.replace("\\", "/").split("/")[-1]))


@pytest.mark.parametrize("path", ["maps/a.<UDIM>.png", "./maps/a.<UDIM>.png"])
def test_tiles_are_relative_to_the_layer_with_the_path(tmp_path, path):
    (tmp_path / "asset" / "maps").mkdir(parents=True)
    save(tmp_path / "asset" / "maps" / "a.1002.png", (9, 9, 9))
    asset = Usd.Stage.CreateNew(str(tmp_path / "asset" / "asset.usda"))
    shader = UsdShade.Shader.Define(asset, "/Texture")
    shader.CreateInput("file", T.Asset).Set(Sdf.AssetPath(path))
    asset.SetDefaultPrim(shader.GetPrim())
    asset.Save()
    stage = Usd.Stage.CreateNew(str(tmp_path / "stage.usda"))
    prim = stage.DefinePrim("/Texture")
    prim.GetReferences().AddReference("asset/asset.usda")
    file = prim.GetAttribute("inputs:file")
    file.SetColorSpace("raw")  # an opinion of the stage's layer, which has no value
    authored, resolved = asset_file(file)
    assert authored == path
    assert Path(resolved) == tmp_path / "asset" / "maps" / "a.<UDIM>.png"


def test_every_texture_has_its_transform_and_one_set_of_coordinates_is_asked_for(tmp_path):
    looks = Looks()
    file = save(tmp_path / "a.png", (1, 2, 3))
    for name, output, size, primvar in (("diffuseColor", "rgb", 2.0, "st"), ("roughness", "r", 5.0, "st1")):
        texture = looks.texture(file, name)
        reader = looks.shader(f"/Looks/M/{name}Reader", "UsdPrimvarReader_float2")
        reader.CreateInput("varname", T.String).Set(primvar)
        transform = looks.shader(f"/Looks/M/{name}Transform", "UsdTransform2d")
        transform.CreateInput("scale", T.Float2).Set(Gf.Vec2f(size))
        transform.CreateInput("in", T.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
        texture.CreateInput("st", T.Float2).ConnectToSource(transform.ConnectableAPI(), "result")
        looks.connect(name, texture, output)
    with pytest.warns(UserWarning, match="/Looks/M/roughness: .*st1"):
        row, textures = looks.row()
    assert textures[row["base_color_texture"]].transform.u_row[0] == 2
    assert textures[row["roughness_texture"]].transform.u_row[0] == 5


@pytest.mark.parametrize(
    ("values", "opacity", "transmission", "thin"),
    [
        ({"opacity": 0.25}, 1.0, 0.75, 2),
        ({"opacity": 0.25, "opacityMode": "presence"}, 0.25, 0.0, 0),
        ({"opacity": 0.25, "opacityMode": "transparent"}, 1.0, 0.75, 2),
        ({"opacity": 0.25, "opacityThreshold": 0.1}, 0.25, 0.0, 0),
        ({"opacity": 0.0}, 0.0, 0.0, 0),
    ],
)
def test_opacity_is_that_of_a_pane_or_of_being_there(values, opacity, transmission, thin):
    looks = Looks()
    for name, value in values.items():
        looks.set(name, T.Token if isinstance(value, str) else T.Float, value)
    row, _ = looks.row()
    assert (row["opacity"], row["transmission"], row["thin"]) == (opacity, transmission, thin)


def test_primvars_of_the_gprim_are_inputs():
    looks = Looks()
    for name, kind, primvar in (
        ("diffuseColor", "float3", "tint"),
        ("roughness", "float", "rough"),
        ("metallic", "float", "no"),
    ):
        reader = looks.shader(f"/Looks/M/{primvar}", f"UsdPrimvarReader_{kind}")
        reader.CreateInput("varname", T.String).Set(primvar)
        reader.CreateInput("fallback", T.Float3 if kind == "float3" else T.Float).Set(
            Gf.Vec3f(0.25) if kind == "float3" else 0.25
        )
        looks.surface.CreateInput(name, T.Float).ConnectToSource(reader.ConnectableAPI(), "result")
    group = UsdGeom.Xform.Define(looks.stage, "/W").GetPrim()
    ball = UsdGeom.Sphere.Define(looks.stage, "/W/Ball").GetPrim()
    UsdGeom.PrimvarsAPI(group).CreatePrimvar("tint", T.Color3f, "constant").Set(Gf.Vec3f(0.1, 0.2, 0.3))
    UsdGeom.PrimvarsAPI(ball).CreatePrimvar("rough", T.FloatArray, "vertex").Set([0.25, 0.75])
    UsdShade.MaterialBindingAPI.Apply(ball).Bind(looks.material)
    extractor = SceneExtractor(looks.stage)
    with pytest.warns(UserWarning, match="/W/Ball: primvars:rough"):
        extractor.update()
    row = extractor.scene.materials[extractor.scene.material_slots[0]]
    np.testing.assert_allclose(row["base_color"], (0.1, 0.2, 0.3), rtol=1e-6)
    assert (row["roughness"], row["metallic"]) == (0.5, 0.25)
    UsdGeom.PrimvarsAPI(ball).GetPrimvar("rough").SetIndices([1, 1, 1])
    extractor.update()
    row = extractor.scene.materials[extractor.scene.material_slots[0]]
    assert row["roughness"] == 0.75, "values that no index names do not count"
    group.GetAttribute("primvars:tint").Set(Gf.Vec3f(0.9, 0.8, 0.7))
    extractor.update()
    row = extractor.scene.materials[extractor.scene.material_slots[0]]
    np.testing.assert_allclose(row["base_color"], (0.9, 0.8, 0.7), rtol=1e-6)


def read_tint(kind, value, *, interpolation="constant", reader="float3", width=3):
    """The base color of a ball whose material reads it from its primvar `tint`, 0.25 in its place."""
    looks = Looks()
    shader = looks.shader("/Looks/M/Reader", f"UsdPrimvarReader_{reader}")
    shader.CreateInput("varname", T.String).Set("tint")
    shader.CreateInput("fallback", T.Float3 if width == 3 else T.Float).Set(Gf.Vec3f(0.25) if width == 3 else 0.25)
    name = "diffuseColor" if width == 3 else "roughness"
    looks.surface.CreateInput(name, T.Color3f).ConnectToSource(shader.ConnectableAPI(), "result")
    ball = UsdGeom.Sphere.Define(looks.stage, "/Ball").GetPrim()
    UsdGeom.PrimvarsAPI(ball).CreatePrimvar("tint", kind, interpolation).Set(value)
    UsdShade.MaterialBindingAPI.Apply(ball).Bind(looks.material)
    extractor = SceneExtractor(looks.stage)
    extractor.update()
    row = extractor.scene.materials[extractor.scene.material_slots[0]]
    return row["base_color" if width == 3 else "roughness"]


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        (T.Float4Array, [Gf.Vec4f(0.5, 0.125, 0.75, 1)]),
        (T.Color4f, Gf.Vec4f(0.5, 0.125, 0.75, 1)),
        (T.Vector3dArray, [Gf.Vec3d(0.5, 0.125, 0.75)]),
    ],
)
def test_colors_of_primvars_are_the_first_three_numbers(kind, value, recwarn):
    np.testing.assert_allclose(read_tint(kind, value, reader="float4"), (0.5, 0.125, 0.75))
    assert not recwarn.list


def test_colors_of_four_numbers_are_averaged_as_colors():
    values = [Gf.Vec4f(1, 0, 0, 1), Gf.Vec4f(0, 1, 0, 1), Gf.Vec4f(0, 0, 1, 1)]
    with pytest.warns(UserWarning, match="/Ball: primvars:tint varies over the gprim"):
        np.testing.assert_allclose(read_tint(T.Float4Array, values, interpolation="vertex"), 1 / 3, rtol=1e-6)


@pytest.mark.parametrize(
    ("kind", "value", "width"),
    [
        (T.String, "red", 3),
        (T.Float2Array, [Gf.Vec2f(1, 1)], 3),
        (T.Color3f, Gf.Vec3f(1, math.nan, 1), 3),
        (T.Color3fArray, [Gf.Vec3f(1, 1, 1)], 1),
        (T.FloatArray, [math.inf], 1),
    ],
)
def test_primvars_that_do_not_fit_are_named_and_the_fallback_counts(kind, value, width):
    with pytest.warns(UserWarning, match="/Ball: primvars:tint does not hold .* Correct its type"):
        np.testing.assert_allclose(read_tint(kind, value, width=width, reader="float"), 0.25)


def test_unknown_nodes_are_named_and_the_default_counts():
    looks = Looks()
    noise = looks.shader("/Looks/M/Noise", "PxrFractal")
    looks.connect("diffuseColor", noise)
    with pytest.warns(UserWarning, match="/Looks/M/Noise.*PxrFractal"):
        np.testing.assert_allclose(looks.row()[0]["base_color"], 0.18)


@pytest.mark.parametrize("name", ["useSpecularWorkflow", "opacityThreshold", "ior"])
def test_connected_inputs_that_are_read_as_constants_are_named(name):
    looks = Looks()
    looks.connect(name, looks.shader("/Looks/M/Reader", "UsdPrimvarReader_float"))
    with pytest.warns(UserWarning, match=f"inputs:{name} is connected to /Looks/M/Reader, .* Author a value"):
        looks.row()


@pytest.mark.parametrize("name", ["file", "scale", "bias", "fallback", "wrapS", "sourceColorSpace"])
def test_connected_inputs_of_a_texture_are_named_once(name, tmp_path):
    looks = Looks()
    texture = looks.texture(save(tmp_path / "a.png", (1, 2, 3)))
    reader = looks.shader("/Looks/M/Reader", "UsdPrimvarReader_string")
    texture.CreateInput(name, T.Token).ConnectToSource(reader.ConnectableAPI(), "result")
    looks.connect("diffuseColor", texture)
    with pytest.warns(UserWarning, match="Author a value") as told:
        looks.row()
    assert [str(each.message).split(";")[0] for each in told] == [
        f"/Looks/M/Tex: inputs:{name} is connected to /Looks/M/Reader, but is read as a constant"
    ]


@pytest.mark.parametrize("name", ["scale", "rotation", "translation"])
def test_connected_inputs_of_a_transform_are_named(name, tmp_path):
    looks = Looks()
    texture = looks.texture(save(tmp_path / "a.png", (1, 2, 3)))
    transform = looks.shader("/Looks/M/Transform", "UsdTransform2d")
    reader = looks.shader("/Looks/M/Reader", "UsdPrimvarReader_float2")
    for each in ("in", name):
        transform.CreateInput(each, T.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
    texture.CreateInput("st", T.Float2).ConnectToSource(transform.ConnectableAPI(), "result")
    looks.connect("diffuseColor", texture)
    with pytest.warns(UserWarning, match=f"/Looks/M/Transform: inputs:{name} is connected to /Looks/M/Reader"):
        looks.row()


def test_a_connected_factor_of_gltf_is_named():
    looks = Mdl("gltf_material")
    looks.connect("base_color_factor", looks.shader("/Looks/M/Data", "data_lookup_color"), "out")
    with pytest.warns(UserWarning, match="inputs:base_color_factor is connected to /Looks/M/Data"):
        looks.row()


@pytest.mark.parametrize("has_transform", [False, True])
def test_constant_coordinates_show_one_texel(has_transform, tmp_path):
    looks = Looks()
    given = texture = looks.texture(save(tmp_path / "a.png", (1, 2, 3)))
    place = np.array([0.25, 0.75, 1.0])
    if has_transform:
        given = looks.shader("/Looks/M/Transform", "UsdTransform2d")
        given.CreateInput("scale", T.Float2).Set(Gf.Vec2f(2, 3))
        given.CreateInput("translation", T.Float2).Set(Gf.Vec2f(0.5, 0.25))
        texture.CreateInput("st", T.Float2).ConnectToSource(given.ConnectableAPI(), "result")
    given.CreateInput("in" if has_transform else "st", T.Float2).Set(Gf.Vec2f(*place[:2]))
    looks.connect("diffuseColor", texture)
    row, textures = looks.row()
    transform = np.array(textures[row["base_color_texture"]].transform)
    expected = np.array([2, 3]) * place[:2] + (0.5, 0.25) if has_transform else place[:2]
    for uv in ((0, 0, 1), (0.3, 0.9, 1)):  # of the surface
        np.testing.assert_allclose(transform @ uv, expected)


@pytest.mark.parametrize("target", ["/Looks/Gone.outputs:rgb", "/Looks/M/Tex.outputs:rgb", "/Looks/M/Loop.outputs:a"])
def test_connections_to_nothing_are_named_and_the_default_counts(target):
    looks = Looks()
    looks.texture("a.png")  # without the output that is asked for
    loop = UsdShade.NodeGraph.Define(looks.stage, "/Looks/M/Loop")
    ends = [loop.CreateOutput(name, T.Color3f) for name in "ab"]
    ends[0].ConnectToSource(ends[1])
    ends[1].ConnectToSource(ends[0])
    looks.surface.CreateInput("diffuseColor", T.Color3f).GetAttr().SetConnections([target])
    with pytest.warns(
        UserWarning, match=f"/Looks/M/Surface: inputs:diffuseColor is connected to {target}, which gives no"
    ):
        np.testing.assert_allclose(looks.row()[0]["base_color"], 0.18)


@pytest.mark.parametrize("through_interface", [False, True])
def test_a_value_beside_a_connection_to_nothing_counts_and_is_named(through_interface):
    looks = Looks()
    given = looks.surface.CreateInput("diffuseColor", T.Color3f)
    if through_interface:
        offered = looks.material.CreateInput("paint", T.Color3f)
        given.ConnectToSource(offered)
        given = offered
    given.Set(Gf.Vec3f(0.5, 0.25, 0.125))
    given.GetAttr().SetConnections(["/Looks/Gone.outputs:rgb"])
    path = str(given.GetAttr().GetPrimPath())
    with pytest.warns(UserWarning, match=f"{path}: {given.GetFullName()} is .* the value authored beside it is used"):
        np.testing.assert_allclose(looks.row()[0]["base_color"], (0.5, 0.25, 0.125))


@pytest.mark.parametrize("file", [None, ""])
def test_a_texture_without_a_file_is_named(file):
    looks = Looks()
    texture = looks.texture("")
    if file is None:
        texture.GetInput("file").GetAttr().Clear()
    looks.connect("diffuseColor", texture)
    with pytest.warns(UserWarning, match="/Looks/M/Tex: it names no file"):
        np.testing.assert_allclose(looks.row()[0]["base_color"], 0.18)


@pytest.mark.parametrize(
    ("inputs", "named"),
    [
        ({"sourceColorSpace": "ACEScg"}, "color space 'ACEScg' is not supported"),
        ({"wrapS": "spiral"}, "inputs:wrapS 'spiral' is none of repeat, clamp, mirror, black"),
    ],
)
def test_unknown_words_of_a_texture_are_named(inputs, named, tmp_path):
    looks = Looks()
    looks.connect("diffuseColor", looks.texture(save(tmp_path / "a.png", (9, 9, 9)), **inputs))
    with pytest.warns(UserWarning, match=f"/Looks/M/Tex: {named}"):
        assert looks.row()[0]["base_color_texture"] == 0


@pytest.mark.parametrize(
    ("name", "column", "most"), [("diffuseColor", "base_color", 1e3), ("emissiveColor", "emission", 1e10)]
)
def test_colors_that_would_leave_32_bits_are_named(name, column, most):
    looks = Looks()
    looks.set(name, T.Color3f, Gf.Vec3f(1e30, 0.5, 0))
    with pytest.warns(UserWarning, match="/Looks/M: a color of 1e.30"):
        np.testing.assert_allclose(looks.row()[0][column], (most, 0.5, 0))


def test_impossible_values_are_named():
    looks = Looks()
    looks.set("roughness", T.Float, math.nan)
    with pytest.warns(UserWarning, match="/Looks/M/Surface.*roughness"):
        assert looks.row()[0]["roughness"] == 0.5


@pytest.mark.parametrize("surface", ["PxrSurface", None])
def test_unknown_surfaces_are_named_and_none(surface):
    looks = Looks(surface or "")
    if surface is None:
        looks.stage.RemovePrim("/Looks/M/Surface")
    with pytest.warns(UserWarning, match="/Looks/M.*displayColor"):
        assert looks.read() is None


def test_fallback_materials_are_gray_or_their_color():
    colors = [fallback_material(Shown(None), Shown(None)), fallback_material(Shown((1.0, 0.5, 0.0)), Shown((0.25,)))]
    rows, _ = written(colors)
    np.testing.assert_allclose(rows["base_color"], [(0.5, 0.5, 0.5), (1.0, 0.5, 0.0)])
    assert rows["opacity"].tolist() == [1.0, 0.25]
    assert rows.tobytes() == written([each.material for each in colors])[0].tobytes()


# Omniverse's MDL materials


@pytest.mark.parametrize("by", ["subIdentifier", "file"])
def test_omnipbr_is_known_by_name_and_has_its_defaults(by):
    row, _ = Mdl(by=by).row()
    np.testing.assert_allclose(row["base_color"], 0.2, rtol=1e-6)
    assert (row["roughness"], row["metallic"], row["opacity"]) == (0.5, 0.0, 1.0)
    np.testing.assert_allclose(row["specular"], 0.04, rtol=1e-6)
    assert (row["emission"] == 0).all()


def test_omnipbr_constants():
    looks = Mdl()
    looks.set("diffuse_color_constant", T.Color3f, Gf.Vec3f(0.5, 0.4, 0.2))
    looks.set("diffuse_tint", T.Color3f, Gf.Vec3f(1, 0.5, 0.5))
    looks.set("albedo_brightness", T.Float, 1.5)
    looks.set("albedo_add", T.Float, 0.1)
    looks.set("reflection_roughness_constant", T.Float, 0.25)
    looks.set("metallic_constant", T.Float, 0.75)
    looks.set("specular_level", T.Float, 1.0)
    looks.set("bump_factor", T.Float, 0.3)
    row, _ = looks.row()
    np.testing.assert_allclose(row["base_color"], (0.85, 0.35, 0.2), rtol=1e-5)
    assert (row["roughness"], row["metallic"]) == (0.25, 0.75)
    np.testing.assert_allclose(row["specular"], 0.08, rtol=1e-6)
    assert row["normal_scale"] == pytest.approx(0.3)


def test_omnipbr_diffuse_texture_replaces_the_constant(tmp_path):
    looks = Mdl()
    looks.set("diffuse_color_constant", T.Color3f, Gf.Vec3f(0.01))
    looks.set("diffuse_tint", T.Color3f, Gf.Vec3f(1, 0.5, 0.25))
    looks.set("albedo_brightness", T.Float, 0.5)
    looks.set("diffuse_texture", T.Asset, str(save(tmp_path / "a.png", (1, 2, 3))))
    row, textures = looks.row()
    np.testing.assert_allclose(row["base_color"], (0.5, 0.25, 0.125), rtol=1e-6)
    assert textures[row["base_color_texture"]].srgb


def test_omnipbr_missing_texture_leaves_the_constant(tmp_path):
    looks = Mdl()
    looks.set("diffuse_color_constant", T.Color3f, Gf.Vec3f(0.3, 0.6, 0.9))
    looks.set("diffuse_texture", T.Asset, str(tmp_path / "none.png"))
    with pytest.warns(UserWarning, match=r"/Looks/M/Shader.*none\.png"):
        row, _ = looks.row()
    np.testing.assert_allclose(row["base_color"], (0.3, 0.6, 0.9), rtol=1e-6)


@pytest.mark.parametrize("influence", [0.0, 0.25, 1.0, None])
def test_omnipbr_roughness_texture_is_blended_by_its_influence(influence, tmp_path):
    looks = Mdl()
    looks.set("reflection_roughness_constant", T.Float, 0.8)
    looks.set("reflectionroughness_texture", T.Asset, str(save(tmp_path / "r.png", (51, 51, 51))))
    if influence is not None:
        looks.set("reflection_roughness_texture_influence", T.Float, influence)
    row, textures = looks.row()
    k = row["roughness_texture"]
    seen = row["roughness"]
    if k >= 0:
        seen *= textures[k].texels[0, 0, row["roughness_channel"]] / 255 * textures[k].scale[0] + textures[k].bias[0]
    weight = 1.0 if influence is None else influence
    assert seen == pytest.approx(0.8 * (1 - weight) + 0.2 * weight, abs=0.003)
    assert k < 0 or not textures[k].srgb


def test_omnipbr_orm_counts_only_when_enabled(tmp_path):
    looks = Mdl()
    looks.set("ORM_texture", T.Asset, str(save(tmp_path / "orm.png", (255, 51, 102))))
    assert looks.row()[0]["roughness_texture"] == scene.NO_TEXTURE
    looks.set("enable_ORM_texture", T.Bool, True)
    row, textures = looks.row()
    assert len(textures) == 1
    assert (row["roughness_channel"], row["metallic_channel"]) == (1, 2)


def test_omnipbr_emission_and_opacity_need_their_switches(tmp_path):
    looks = Mdl()
    looks.set("emissive_color", T.Color3f, Gf.Vec3f(1, 0.5, 0))
    looks.set("emissive_intensity", T.Float, 100.0)
    looks.set("emissive_color_texture", T.Asset, str(save(tmp_path / "e.png", (9, 9, 9))))
    looks.set("opacity_constant", T.Float, 0.5)
    looks.set("opacity_threshold", T.Float, 0.2)
    row, _ = looks.row()
    assert (row["emission"] == 0).all()
    assert (row["opacity"], row["opacity_threshold"]) == (1, 0)
    looks.set("enable_emission", T.Bool, True)
    looks.set("enable_opacity", T.Bool, True)
    row, textures = looks.row()
    np.testing.assert_allclose(row["emission"], (100, 50, 0))
    assert textures[row["emission_texture"]].path.endswith("e.png")
    assert (row["opacity"], row["opacity_threshold"]) == pytest.approx((0.5, 0.2))


def test_omnipbr_opacity_texture_and_mode(tmp_path):
    looks = Mdl()
    looks.set("enable_opacity", T.Bool, True)
    looks.set("opacity_texture", T.Asset, str(save(tmp_path / "o.png", (9, 9, 9, 9))))
    assert looks.row()[0]["opacity_channel"] == 0
    looks.set("opacity_mode", T.Int, 0)
    row, _ = looks.row()
    assert (row["opacity_channel"], row["opacity"]) == (3, 1)
    looks.set("enable_opacity_texture", T.Bool, False)
    assert looks.row()[0]["opacity_texture"] == scene.NO_TEXTURE


@pytest.mark.parametrize("space", [None, "sRGB"])
@pytest.mark.parametrize(
    ("mode", "of_color"),
    [
        (None, lambda color: color.mean()),
        (1, lambda color: color.mean()),
        (2, lambda color: color @ (0.2126, 0.7152, 0.0722)),
        (3, lambda color: color.max()),
    ],
)
@pytest.mark.parametrize("name", ["OmniPBR", "OmniGlass"])
def test_opacity_of_a_color_is_the_number_that_the_mode_names(name, mode, of_color, space, tmp_path):
    """Whatever the constant is, which counts without a picture only."""
    glass = name == "OmniGlass"
    looks = Mdl(name)
    picture = "cutout_opacity_texture" if glass else "opacity_texture"
    looks.set("enable_opacity", T.Bool, True)
    looks.set(picture, T.Asset, str(save(tmp_path / "o.png", (200, 100, 50))))
    looks.set("cutout_opacity" if glass else "opacity_constant", T.Float, 0.5)
    if mode is not None:
        looks.set("cutout_opacity_mono_source" if glass else "opacity_mode", T.Int, mode)
    if space is not None:
        looks.surface.GetInput(picture).GetAttr().SetColorSpace(space)
    row, textures = looks.row()
    used = textures[row["opacity_texture"]]
    color = np.array([200, 100, 50]) / 255.0
    expected = of_color(color if space is None else srgb_to_linear(color))
    assert not used.srgb
    seen = row["opacity"] * used.texels[0, 0, row["opacity_channel"]] / np.iinfo(used.texels.dtype).max
    assert seen == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize(
    ("name", "picture", "field"),
    [
        ("OmniPBR", "reflectionroughness_texture", "roughness"),
        ("OmniPBR", "metallic_texture", "metallic"),
        ("OmniGlass", "roughness_texture", "roughness"),
        ("OmniSurface", "metalness_image", "metallic"),
    ],
)
def test_numbers_of_colors_are_their_means(name, picture, field, tmp_path):
    looks = Mdl(name)
    looks.set(picture, T.Asset, str(save(tmp_path / "o.png", (200, 100, 51))))
    row, textures = looks.row()
    texels = textures[row[f"{field}_texture"]].texels
    seen = row[field] * texels[0, 0, row[f"{field}_channel"]] / np.iinfo(texels.dtype).max
    assert seen == pytest.approx(351 / 3 / 255, abs=2e-5)


def test_omnipbr_coordinates_and_normal_map(tmp_path):
    looks = Mdl()
    looks.set("normalmap_texture", T.Asset, str(save(tmp_path / "n.png", (128, 128, 255))))
    looks.set("texture_scale", T.Float2, Gf.Vec2f(2, 3))
    looks.set("texture_rotate", T.Float, 45.0)
    looks.set("texture_translate", T.Float2, Gf.Vec2f(0.1, 0.2))
    looks.set("project_uvw", T.Bool, True)
    with pytest.warns(UserWarning, match="/Looks/M/Shader.*project_uvw"):
        row, textures = looks.row()
    used = textures[row["normal_texture"]]
    assert not used.srgb
    half = math.sqrt(0.5)
    np.testing.assert_allclose(used.transform, [[2 * half, -3 * half, 0.1], [2 * half, 3 * half, 0.2]], rtol=1e-6)
    assert used.scale[:3] == (1.0, -1.0, 1.0), "OmniPBR's maps have green downward"
    assert used.bias[:3] == (0.0, 1.0, 0.0)


def test_other_mdl_names():
    glass = Mdl("OmniGlass")
    glass.set("glass_color", T.Color3f, Gf.Vec3f(0.5, 1, 0.5))
    glass.set("glass_ior", T.Float, 1.6)
    glass.set("thin_walled", T.Bool, True)
    row, _ = glass.row()
    assert (row["transmission"], row["thin"], row["opacity"]) == (1, 1, 1)
    assert row["ior"] == np.float32(1.6)
    np.testing.assert_allclose(row["specular"], (0.6 / 2.6) ** 2, rtol=1e-6)
    np.testing.assert_allclose(row["base_color"], (0.5, 1, 0.5))
    coat = Mdl("OmniPBR_ClearCoat")
    coat.set("clearcoat_weight", T.Float, 0.5)
    assert coat.row()[0]["clearcoat"] == 0.5
    with pytest.warns(UserWarning, match=r"/Looks/M.*Aluminum"):
        assert Mdl("Aluminum_Anodized").read() is None


def test_unknown_mdl_beside_a_preview_surface_is_no_loss():
    looks = Mdl("Aluminum_Anodized")
    surface = looks.shader("/Looks/M/Preview", "UsdPreviewSurface")
    surface.CreateInput("metallic", T.Float).Set(1.0)
    looks.material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    assert looks.row()[0]["metallic"] == 1.0


def gltf(**inputs) -> Mdl:
    looks = Mdl("gltf_material")
    looks.surface.SetSourceAsset("gltf/pbr.mdl", "mdl")
    for name, value in inputs.items():
        kind = T.Color3f if isinstance(value, tuple) else T.Int if isinstance(value, int) else T.Float
        looks.set(name, kind, Gf.Vec3f(*value) if isinstance(value, tuple) else value)
    return looks


def gltf_texture(looks, name, file, **inputs):
    lookup = UsdShade.Shader.Define(looks.stage, f"/Looks/M/{name}")
    lookup.GetImplementationSourceAttr().Set("sourceAsset")
    lookup.SetSourceAsset("gltf/pbr.mdl", "mdl")
    lookup.SetSourceAssetSubIdentifier("gltf_texture_lookup", "mdl")
    lookup.CreateInput("texture", T.Asset).Set(str(file))
    for key, value in inputs.items():
        kind = T.Float2 if isinstance(value, tuple) else T.Int if isinstance(value, int) else T.Float
        lookup.CreateInput(key, kind).Set(Gf.Vec2f(*value) if isinstance(value, tuple) else value)
    looks.surface.CreateInput(name, T.Float3).ConnectToSource(lookup.ConnectableAPI(), "out")


def test_gltf_defaults_are_those_of_gltf():
    row, _ = gltf().row()
    np.testing.assert_allclose(row["base_color"], 1.0)
    assert (row["metallic"], row["roughness"], row["opacity"], row["transmission"]) == (1, 1, 1, 0)
    np.testing.assert_allclose(row["specular"], 0.04, rtol=1e-6)
    assert (row["emission"] == 0).all()


def test_gltf_factors():
    row, _ = gltf(
        base_color_factor=(0.1, 0.2, 0.3), metallic_factor=0.25, roughness_factor=0.75, emissive_factor=(1.0, 0.5, 0.0),
        emissive_strength=8.0, clearcoat_factor=0.5, clearcoat_roughness_factor=0.125, transmission_factor=0.5,
        ior=2.0, specular_factor=0.5, specular_color_factor=(1.0, 0.5, 0.0),
    ).row()  # fmt: skip
    np.testing.assert_allclose(row["base_color"], (0.1, 0.2, 0.3), rtol=1e-6)
    assert (row["metallic"], row["roughness"]) == (0.25, 0.75)
    np.testing.assert_allclose(row["emission"], (8, 4, 0))
    assert (row["clearcoat"], row["clearcoat_roughness"]) == (0.5, 0.125)
    assert (row["transmission"], row["ior"], row["thin"]) == (0.5, 2.0, 1)
    np.testing.assert_allclose(row["specular"], np.array([1, 0.5, 0]) * 0.5 / 9, rtol=1e-6)
    assert gltf(thickness_factor=1.0).row()[0]["thin"] == 0


def test_gltf_textures_have_their_channels_and_wraps(tmp_path):
    looks = gltf()
    color, packed = save(tmp_path / "c.png", (9, 9, 9, 9)), save(tmp_path / "p.png", (1, 2, 3))
    gltf_texture(looks, "base_color_texture", color, wrap_s=33071, wrap_t=33648)
    gltf_texture(looks, "metallic_roughness_texture", packed)
    gltf_texture(looks, "normal_texture", packed)
    row, textures = looks.row()
    base = textures[row["base_color_texture"]]
    assert (base.srgb, base.wrap_s, base.wrap_t) == (True, scene.WRAP_CLAMP, scene.WRAP_MIRROR)
    assert row["metallic_texture"] == row["roughness_texture"] == row["normal_texture"] >= 0
    assert (row["metallic_channel"], row["roughness_channel"]) == (2, 1)
    assert not textures[row["normal_texture"]].srgb


@pytest.mark.parametrize(("mode", "threshold", "textured"), [(0, 0.0, False), (1, 0.25, True), (2, 0.0, True)])
def test_gltf_alpha_modes(mode, threshold, textured, tmp_path):
    looks = gltf(alpha_mode=mode, alpha_cutoff=0.25, base_alpha=0.75)
    gltf_texture(looks, "base_color_texture", save(tmp_path / "c.png", (9, 9, 9, 9)))
    row, _ = looks.row()
    assert row["opacity_threshold"] == threshold
    assert (row["opacity_texture"] >= 0) == textured
    assert (row["opacity"], row["opacity_channel"]) == ((0.75, 3) if textured else (1.0, 0))


def test_gltf_transforms_are_those_of_khr_texture_transform(tmp_path):
    looks = gltf()
    offset, rotation, size = np.array([0.2, 0.3]), 0.6, np.array([2.0, 0.5])
    gltf_texture(
        looks, "base_color_texture", save(tmp_path / "c.png", (9, 9, 9)),
        offset=tuple(offset), rotation=rotation, scale=tuple(size),
    )  # fmt: skip
    row, textures = looks.row()
    found = np.array(textures[row["base_color_texture"]].transform)
    # glTF's v runs downward, and it turns the image's coordinates counter-clockwise as they are seen.
    turn = np.array([[np.cos(rotation), np.sin(rotation)], [-np.sin(rotation), np.cos(rotation)]])
    for u, v in ((0, 0), (1, 0), (0.3, 0.9)):
        there = offset + turn @ (size * [u, 1 - v])
        np.testing.assert_allclose(found @ [u, v, 1], (there[0], 1 - there[1]), atol=1e-6)


def test_gltf_says_what_it_leaves_out():
    with pytest.warns(UserWarning, match="/Looks/M/Shader.*sheen_color_factor"):
        gltf(sheen_color_factor=(1.0, 0.0, 0.0)).row()


def test_omnipbr_adjusts_its_texture_exactly(tmp_path):
    looks = Mdl()
    looks.set("diffuse_texture", T.Asset, str(save(tmp_path / "a.png", (200, 100, 50))))
    looks.set("albedo_brightness", T.Float, 1.5)
    looks.set("albedo_add", T.Float, -0.125)
    looks.set("diffuse_tint", T.Color3f, Gf.Vec3f(1, 0.5, 0.25))
    row, textures = looks.row()
    used = textures[row["base_color_texture"]]
    np.testing.assert_allclose(row["base_color"], (1, 0.5, 0.25))
    assert (used.scale, used.bias) == ((1.5, 1.5, 1.5, 1.0), (-0.125, -0.125, -0.125, 0.0))


@pytest.mark.parametrize(("u", "v"), [(None, None), (True, False), (False, False)])
def test_omnipbr_turns_normal_maps_round_as_told(u, v, tmp_path):
    looks = Mdl()
    for name in ("normalmap_texture", "detail_normalmap_texture"):
        looks.set(name, T.Asset, str(save(tmp_path / "n.png", (128, 64, 255))))
    looks.set("detail_bump_factor", T.Float, 0.75)
    looks.set("detail_texture_scale", T.Float2, Gf.Vec2f(8, 4))
    for name, turn in (("flip_tangent_u", u), ("flip_tangent_v", v)):
        if turn is not None:
            looks.set(name, T.Bool, turn)
    row, textures = looks.row()
    normal, detail = textures[row["normal_texture"]], textures[row["detail_texture"]]
    x, y = bool(u), v is None or v
    assert normal.scale == detail.scale == (-1.0 if x else 1.0, -1.0 if y else 1.0, 1.0, 1.0)
    assert normal.bias == (float(x), float(y), 0.0, 0.0)
    assert row["detail_scale"] == 0.75
    assert (detail.transform.u_row[0], detail.transform.v_row[1]) == (8, 4)


@pytest.mark.parametrize(
    ("template", "name"),
    [("OmniPBR", "uv_space_index"), ("OmniGlass", "uv_space_index"), ("OmniSurface", "uvw_uv_set")],
)
def test_mdl_materials_say_which_texture_coordinates_they_read(template, name):
    looks = Mdl(template)
    for number, primvar in ((None, ""), (0, ""), (1, "st_1"), (3, "st_3")):
        if number is not None:
            looks.set(name, T.Int, number)
        assert looks.read().uv_primvar == primvar


def test_omnipbr_emission_mask(tmp_path):
    looks = Mdl()
    looks.set("enable_emission", T.Bool, True)
    looks.set("emissive_mask_texture", T.Asset, str(save(tmp_path / "m.png", (9, 9, 9))))
    row, textures = looks.row()
    np.testing.assert_allclose(row["emission"], (40, 4, 4), rtol=1e-6)
    assert not textures[row["emission_texture"]].srgb


def test_omniglass_frost_and_its_texture(tmp_path):
    glass = Mdl("OmniGlass")
    glass.set("frosting_roughness", T.Float, 0.4)
    glass.set("roughness_texture", T.Asset, str(save(tmp_path / "r.png", (9, 9, 9))))
    glass.set("roughness_texture_influence", T.Float, 0.25)
    glass.set("reflection_color", T.Color3f, Gf.Vec3f(1, 0, 0))
    with pytest.warns(UserWarning, match="/Looks/M/Shader.*reflection_color"):
        row, textures = glass.row()
    used = textures[row["roughness_texture"]]
    assert (used.scale[0], used.bias[0]) == pytest.approx((0.25, 0.3))
    glass.set("enable_opacity", T.Bool, True)
    glass.set("cutout_opacity", T.Float, 0.5)
    assert glass.row()[0]["opacity"] == 0.5


@pytest.mark.parametrize(("source", "channel"), [(None, 0), (0, 3), (1, 0)])
def test_omniglass_is_cut_out_by_its_texture(source, channel, tmp_path):
    glass = Mdl("OmniGlass")
    glass.set("cutout_opacity", T.Float, 0.25)
    glass.set("cutout_opacity_texture", T.Asset, str(save(tmp_path / "o.png", (9, 9, 9, 200))))
    if source is not None:
        glass.set("cutout_opacity_mono_source", T.Int, source)
    assert glass.row()[0]["opacity_texture"] == scene.NO_TEXTURE
    glass.set("enable_opacity", T.Bool, True)
    row, textures = glass.row()
    assert (row["opacity"], row["opacity_channel"]) == (1, channel)
    assert textures[row["opacity_texture"]].path == str(tmp_path / "o.png")
    (tmp_path / "o.png").unlink()
    with pytest.warns(UserWarning, match="cutout_opacity_texture names"):
        assert glass.row()[0]["opacity"] == 0.25


@pytest.mark.parametrize(
    ("template", "name", "kind", "value"),
    [
        ("OmniGlass", "project_uvw", T.Bool, True),
        ("OmniGlass", "reflection_color_texture", T.Asset, "a.png"),
        ("OmniPBR_ClearCoat", "clearcoat_normalmap_texture", T.Asset, "a.png"),
        ("OmniSurface", "specular_retro_reflection_weight", T.Float, 0.5),
        ("OmniSurface", "diffuse_reflection_roughness", T.Float, 0.5),
        ("OmniSurface", "coat_color", T.Color3f, Gf.Vec3f(1, 0, 0)),
        ("OmniSurface", "coat_normal_image", T.Asset, "a.png"),
    ],
)
def test_inputs_of_mdl_materials_that_are_not_read_are_named(template, name, kind, value, recwarn):
    looks = Mdl(template)
    looks.set("coat_weight", T.Float, 1.0)
    looks.read()
    assert not recwarn
    looks.set(name, kind, value)
    with pytest.warns(UserWarning, match=f"/Looks/M/Shader: .*{name}"):
        looks.read()


def test_omnisurface():
    looks = Mdl("OmniSurface")
    row, _ = looks.row()
    assert row["clearcoat_roughness"] == np.float32(0.1)
    np.testing.assert_allclose(row["base_color"], 0.8, rtol=1e-6)
    assert (row["roughness"], row["transmission"], row["opacity"]) == (np.float32(0.2), 0, 1)
    looks.set("specular_reflection_weight", T.Float, 0.5)
    looks.set("specular_reflection_color", T.Color3f, Gf.Vec3f(1, 0.5, 0))
    looks.set("enable_specular_transmission", T.Bool, True)
    looks.set("specular_transmission_weight", T.Float, 0.75)
    looks.set("specular_transmission_color", T.Color3f, Gf.Vec3f(0, 0.8, 0))
    looks.set("coat_weight", T.Float, 0.25)
    row, _ = looks.row()
    np.testing.assert_allclose(row["specular"], np.array([1, 0.5, 0]) * 0.02, rtol=1e-6)
    np.testing.assert_allclose(row["base_color"], (0.2, 0.8, 0.2), rtol=1e-6)
    assert (row["transmission"], row["clearcoat"]) == (0.75, 0.25)


def test_omnisurface_images_and_what_scatters_below(tmp_path):
    looks = Mdl("OmniSurfaceLite")
    for name in ("specular_reflection_roughness", "metalness", "coat_weight"):
        looks.set(f"{name}_image", T.Asset, str(save(tmp_path / "r.png", (9, 9, 9))))
    row, _ = looks.row()
    assert row["roughness_texture"] == row["metallic_texture"] == row["clearcoat_texture"] >= 0
    assert row["roughness"] == row["metallic"] == row["clearcoat"] == 1
    skin = Mdl("OmniSurface")
    skin.set("enable_diffuse_transmission", T.Bool, True)
    skin.set("subsurface_weight", T.Float, 0.5)
    skin.set("subsurface_scattering_color", T.Color3f, Gf.Vec3f(1, 0.4, 0.2))
    np.testing.assert_allclose(skin.row()[0]["base_color"], (0.9, 0.6, 0.5), rtol=1e-6)


def material_x(surface):
    looks = Looks(f"ND_{surface}_surfaceshader")
    looks.material.GetSurfaceOutput().GetAttr().ClearConnections()
    looks.material.CreateSurfaceOutput("mtlx").ConnectToSource(looks.surface.ConnectableAPI(), "out")
    return looks


def test_standard_surface():
    looks = material_x("standard_surface")
    row, _ = looks.row()
    np.testing.assert_allclose(row["base_color"], 0.8, rtol=1e-6)
    assert (row["roughness"], row["opacity"], row["transmission"]) == (np.float32(0.2), 1, 0)
    for name, value in (("base", 0.5), ("metalness", 0.25), ("specular", 0.5), ("coat", 0.75), ("emission", 4.0)):
        looks.set(name, T.Float, value)
    looks.set("base_color", T.Color3f, Gf.Vec3f(1, 0.5, 0))
    looks.set("emission_color", T.Color3f, Gf.Vec3f(1, 0, 0.5))
    row, _ = looks.row()
    np.testing.assert_allclose(row["base_color"], (0.5, 0.25, 0))
    np.testing.assert_allclose(row["specular"], 0.02, rtol=1e-6)
    np.testing.assert_allclose(row["emission"], (4, 0, 2))
    assert (row["metallic"], row["clearcoat"], row["clearcoat_roughness"]) == (0.25, 0.75, np.float32(0.1))


def test_open_pbr_images_and_their_channels(tmp_path):
    looks = material_x("open_pbr_surface")
    image = looks.shader("/Looks/M/Image", "ND_tiledimage_color3")
    file = image.CreateInput("file", T.Asset)
    file.Set(str(save(tmp_path / "a.png", (10, 20, 30))))
    file.GetAttr().SetColorSpace("srgb_texture")
    image.CreateInput("uvtiling", T.Float2).Set(Gf.Vec2f(2, 3))
    image.CreateInput("uaddressmode", T.String).Set("mirror")
    where = looks.shader("/Looks/M/Where", "ND_geompropvalue_vector2")
    where.CreateInput("geomprop", T.String).Set("UVMap")
    image.CreateInput("texcoord", T.Float2).ConnectToSource(where.ConnectableAPI(), "out")
    pick = looks.shader("/Looks/M/Pick", "ND_separate3_color3")
    pick.CreateInput("in", T.Color3f).ConnectToSource(image.ConnectableAPI(), "out")
    bump = looks.shader("/Looks/M/Bump", "ND_normalmap")
    bump.CreateInput("in", T.Float3).ConnectToSource(image.ConnectableAPI(), "out")
    looks.connect("base_color", image, "out")
    looks.connect("specular_roughness", pick, "outg")
    looks.connect("geometry_normal", bump, "out")
    looks.set("base_weight", T.Float, 0.5)
    row, textures = looks.row()
    base = textures[row["base_color_texture"]]
    assert (base.srgb, base.wrap_s, base.transform.u_row[0], base.transform.v_row[1]) == (True, scene.WRAP_MIRROR, 2, 3)
    np.testing.assert_allclose(row["base_color"], 0.5)
    assert row["roughness_channel"] == 1
    assert row["roughness_texture"] >= 0
    assert not textures[row["normal_texture"]].srgb
    assert looks.read().uv_primvar == "UVMap"


def place2d_by_numpy(uv, *, pivot=(0, 0), scale=(1, 1), rotate=0.0, offset=(0, 0), operationorder=0):
    """The steps of MaterialX's node graph for place2d, and its rotate2d."""

    def turned(x, y):
        sine, cosine = np.sin(np.radians(rotate)), np.cos(np.radians(rotate))
        return np.array([cosine * x + sine * y, -sine * x + cosine * y])

    about = np.array(uv) - pivot
    if operationorder:
        return turned(*(about - offset)) / scale + pivot
    return turned(*(about / scale)) - offset + pivot


@pytest.mark.parametrize(
    "chain",
    [
        [{"scale": (0.5, 0.25)}],
        [{"rotate": 90.0, "pivot": (0.5, 0.5)}],
        [{"rotate": 30.0, "scale": (2, 3), "offset": (0.1, 0.4), "pivot": (0.2, 0.7)}],
        [{"rotate": 30.0, "scale": (2, 3), "offset": (0.1, 0.4), "pivot": (0.2, 0.7), "operationorder": 1}],
        [{"rotate": -20.0, "offset": (0.3, 0)}, {"scale": (2, 1), "offset": (0.5, 0.25)}],
    ],
)
def test_place2d_moves_images_as_material_x_does(chain, tmp_path):
    looks = material_x("standard_surface")
    image = looks.shader("/Looks/M/Image", "ND_tiledimage_color3")
    image.CreateInput("file", T.Asset).Set(str(save(tmp_path / "a.png", (10, 20, 30))))
    image.CreateInput("uvtiling", T.Float2).Set(Gf.Vec2f(2, 3))
    looks.connect("base_color", image, "out")
    node = image
    for k, values in enumerate(reversed(chain)):
        place = looks.shader(f"/Looks/M/Place{k}", "ND_place2d_vector2")
        node.CreateInput("texcoord", T.Float2).ConnectToSource(place.ConnectableAPI(), "out")
        for name, value in values.items():
            kind = {"rotate": T.Float, "operationorder": T.Int}.get(name, T.Float2)
            place.CreateInput(name, kind).Set(Gf.Vec2f(*value) if kind == T.Float2 else value)
        node = place
    where = looks.shader("/Looks/M/Where", "ND_geompropvalue_vector2")
    where.CreateInput("geomprop", T.String).Set("UVMap")
    node.CreateInput("texcoord", T.Float2).ConnectToSource(where.ConnectableAPI(), "out")
    row, textures = looks.row()
    transform = textures[row["base_color_texture"]].transform
    for uv in ((0, 0), (1, 0), (0.3, 0.9)):
        expected = uv
        for values in chain:
            expected = place2d_by_numpy(expected, **values)
        np.testing.assert_allclose(np.array(transform) @ (*uv, 1), np.array(expected) * (2, 3), atol=1e-6)
    assert looks.read().uv_primvar == "UVMap"


def test_place2d_that_is_computed_is_named(tmp_path):
    looks = material_x("standard_surface")
    image = looks.shader("/Looks/M/Image", "ND_image_color3")
    image.CreateInput("file", T.Asset).Set(str(save(tmp_path / "a.png", (10, 20, 30))))
    looks.connect("base_color", image, "out")
    place = looks.shader("/Looks/M/Place", "ND_place2d_vector2")
    image.CreateInput("texcoord", T.Float2).ConnectToSource(place.ConnectableAPI(), "out")
    wave = looks.shader("/Looks/M/Wave", "ND_sin_float")
    place.CreateInput("rotate", T.Float).ConnectToSource(wave.ConnectableAPI(), "out")
    with pytest.warns(UserWarning, match="/Looks/M/Place: inputs:rotate is connected to /Looks/M/Wave, but"):
        looks.row()


@pytest.mark.parametrize("file", [None, "gone.png"])
@pytest.mark.parametrize("default", [None, Gf.Vec3f(0.5, 0.25, 0.125)])
def test_a_material_x_image_without_a_file_is_named_and_its_default_counts(file, default):
    looks = material_x("standard_surface")
    looks.set("base", T.Float, 1.0)
    image = looks.shader("/Looks/M/Image", "ND_image_color3")
    if file is not None:
        image.CreateInput("file", T.Asset).Set(file)
    if default is not None:
        image.CreateInput("default", T.Color3f).Set(default)
    looks.connect("base_color", image, "out")
    said = "it names no file" if file is None else "inputs:file names gone.png, which does not exist"
    with pytest.warns(UserWarning, match=f"/Looks/M/Image: {said}; the fallback is used"):
        np.testing.assert_allclose(looks.row()[0]["base_color"], (0.8, 0.8, 0.8) if default is None else default)


@pytest.mark.parametrize("image_first", [False, True])
@pytest.mark.parametrize("factor", [0.5, Gf.Vec3f(0.5, 0.25, 0.125)])
def test_images_of_material_x_are_multiplied_by_constants(image_first, factor, tmp_path):
    looks = material_x("standard_surface")
    looks.set("base", T.Float, 0.5)
    image = looks.shader("/Looks/M/Image", "ND_image_color3")
    image.CreateInput("file", T.Asset).Set(str(save(tmp_path / "a.png", (10, 20, 30))))
    tint = looks.shader(
        "/Looks/M/Tint", "ND_multiply_color3" if isinstance(factor, Gf.Vec3f) else "ND_multiply_color3FA"
    )
    names = ("in1", "in2") if image_first else ("in2", "in1")
    tint.CreateInput(names[0], T.Color3f).ConnectToSource(image.ConnectableAPI(), "out")
    tint.CreateInput(names[1], T.Color3f if isinstance(factor, Gf.Vec3f) else T.Float).Set(factor)
    pick = looks.shader("/Looks/M/Pick", "ND_extract_color3")
    pick.CreateInput("in", T.Color3f).ConnectToSource(tint.ConnectableAPI(), "out")
    pick.CreateInput("index", T.Int).Set(1)
    looks.connect("base_color", tint, "out")
    looks.connect("specular_roughness", pick, "out")
    row, textures = looks.row()
    expected = np.broadcast_to(factor if isinstance(factor, float) else tuple(factor), 3)
    np.testing.assert_allclose(row["base_color"], 0.5 * expected)
    assert (row["roughness"], row["roughness_channel"]) == (expected[1], 1)
    assert textures[row["base_color_texture"]].path.endswith("a.png")


def test_products_of_two_images_of_material_x_are_named(tmp_path):
    looks = material_x("standard_surface")
    tint = looks.shader("/Looks/M/Tint", "ND_multiply_color3")
    for name in ("in1", "in2"):
        image = looks.shader(f"/Looks/M/{name}", "ND_image_color3")
        image.CreateInput("file", T.Asset).Set(str(save(tmp_path / "a.png", (10, 20, 30))))
        tint.CreateInput(name, T.Color3f).ConnectToSource(image.ConnectableAPI(), "out")
    looks.connect("base_color", tint, "out")
    with pytest.warns(UserWarning, match="/Looks/M/Tint: MaterialX node 'ND_multiply_color3' is not evaluated"):
        looks.row()


def test_version_1_0_0_of_standard_surface_has_its_own_defaults():
    looks = material_x("standard_surface")
    looks.surface.CreateIdAttr("ND_standard_surface_surfaceshader_100")
    np.testing.assert_allclose(looks.row()[0]["base_color"], 0.8)
    looks.set("base_color", T.Color3f, Gf.Vec3f(1, 0.5, 0))
    np.testing.assert_allclose(looks.row()[0]["base_color"], (0.8, 0.4, 0))


def test_constant_coordinates_of_a_material_x_image_show_one_texel(tmp_path):
    looks = material_x("standard_surface")
    image = looks.shader("/Looks/M/Image", "ND_image_color3")
    image.CreateInput("file", T.Asset).Set(str(save(tmp_path / "a.png", (10, 20, 30))))
    image.CreateInput("texcoord", T.Float2).Set(Gf.Vec2f(0.25, 0.75))
    looks.connect("base_color", image, "out")
    row, textures = looks.row()
    np.testing.assert_allclose(textures[row["base_color_texture"]].transform, [[0, 0, 0.25], [0, 0, 0.75]])


@pytest.mark.parametrize(
    ("name", "nodes", "value", "expected"),
    [
        ("base_color", ["ND_constant_color3"], Gf.Vec3f(0.1, 0.2, 0.3), (0.1, 0.2, 0.3)),
        ("base_color", ["ND_dot_color3", "ND_constant_color3"], Gf.Vec3f(0.1, 0.2, 0.3), (0.1, 0.2, 0.3)),
        ("base_color", ["ND_convert_float_color3"], 0.25, (0.25,) * 3),
        ("base_color", ["ND_constant_color3"], None, (0.0,) * 3),  # MaterialX's default
        ("specular_roughness", ["ND_constant_float"], 0.75, 0.75),
        ("specular_roughness", ["ND_extract_color3", "ND_constant_color3"], Gf.Vec3f(0.1, 0.2, 0.3), 0.2),
    ],
)
def test_constants_behind_nodes_of_material_x_are_read(name, nodes, value, expected):
    looks = material_x("standard_surface")
    looks.set("base", T.Float, 1.0)
    shaders = [looks.shader(f"/Looks/M/Node{k}", kind) for k, kind in enumerate(nodes)]
    looks.connect(name, shaders[0], "out")
    for first, after in itertools.pairwise(shaders):
        first.CreateInput("in", T.Color3f).ConnectToSource(after.ConnectableAPI(), "out")
    if "extract" in nodes[0]:
        shaders[0].CreateInput("index", T.Int).Set(1)
    if value is not None:
        end = shaders[-1].CreateInput(
            "value" if "constant" in nodes[-1] else "in", T.Float if isinstance(value, float) else T.Color3f
        )
        end.Set(value)
    row, _ = looks.row()
    np.testing.assert_allclose(row["base_color" if name == "base_color" else "roughness"], expected, rtol=1e-6)


@pytest.mark.parametrize("height", [0.0, 0.3, "image"])
def test_a_displacement_of_its_own_is_named_where_it_moves_anything(height, recwarn):
    looks = material_x("standard_surface")
    node = looks.shader("/Looks/M/Height", "ND_displacement_float")
    looks.material.CreateDisplacementOutput("mtlx").ConnectToSource(node.ConnectableAPI(), "out")
    value = node.CreateInput("displacement", T.Float)
    if height == "image":
        value.ConnectToSource(looks.shader("/Looks/M/Image", "ND_image_float").ConnectableAPI(), "out")
    else:
        value.Set(height)
    looks.row()
    told = [str(each.message) for each in recwarn]
    expected = "/Looks/M/Height: displacement is not supported and is ignored. Bake it into the mesh."
    assert told == ([expected] if height else [])


def test_normal_maps_of_object_space_are_named(tmp_path):
    looks = material_x("standard_surface")
    image = looks.shader("/Looks/M/Image", "ND_image_vector3")
    image.CreateInput("file", T.Asset).Set(str(save(tmp_path / "a.png", (128, 128, 255))))
    bump = looks.shader("/Looks/M/Bump", "ND_normalmap")
    bump.CreateInput("in", T.Float3).ConnectToSource(image.ConnectableAPI(), "out")
    bump.CreateInput("space", T.String).Set("object")
    looks.connect("normal", bump, "out")
    with pytest.warns(UserWarning, match="/Looks/M/Bump: inputs:space object is not supported"):
        looks.row()


def test_other_material_x_nodes_are_named():
    looks = material_x("standard_surface")
    looks.connect("base_color", looks.shader("/Looks/M/Noise", "ND_noise2d_color3"), "out")
    with pytest.warns(UserWarning, match="/Looks/M/Noise: MaterialX node 'ND_noise2d_color3'"):
        np.testing.assert_allclose(looks.row()[0]["base_color"], 0.8, rtol=1e-6)
    circle = looks.shader("/Looks/M/Circle", "ND_extract_color3")
    circle.CreateInput("in", T.Color3f).ConnectToSource(circle.ConnectableAPI(), "out")
    looks.connect("metalness", circle, "out")
    with pytest.warns(UserWarning, match="/Looks/M/Circle"):
        assert looks.row()[0]["metallic"] == 0


def test_material_x_images_pass_conversions_and_end_at_their_border(tmp_path):
    """`convert` and `dot` pass an image on; `constant` is 0 outside of it; a normal map has its own scale."""
    looks = material_x("standard_surface")
    image = looks.shader("/Looks/M/Image", "ND_tiledimage_color4")
    image.CreateInput("file", T.Asset).Set(str(save(tmp_path / "a.png", (10, 20, 30))))
    image.CreateInput("uaddressmode", T.String).Set("constant")
    image.CreateInput("uvtiling", T.Float2).Set(Gf.Vec2f(2, 3))
    image.CreateInput("uvoffset", T.Float2).Set(Gf.Vec2f(0.5, 0))
    image.CreateInput("realworldimagesize", T.Float2).Set(Gf.Vec2f(4, 1))
    where = looks.shader("/Looks/M/Where", "ND_texcoord_vector2")
    where.CreateInput("index", T.Int).Set(1)
    image.CreateInput("texcoord", T.Float2).ConnectToSource(where.ConnectableAPI(), "out")
    passed = image
    for name, kind in (("Same", "ND_dot_color4"), ("Fewer", "ND_convert_color4_color3")):
        node = looks.shader(f"/Looks/M/{name}", kind)
        node.CreateInput("in", T.Color4f).ConnectToSource(passed.ConnectableAPI(), "out")
        passed = node
    green = looks.shader("/Looks/M/Green", "ND_extract_color4")
    green.CreateInput("in", T.Color4f).ConnectToSource(image.ConnectableAPI(), "out")
    green.CreateInput("index", T.Int).Set(1)
    bump = looks.shader("/Looks/M/Bump", "ND_normalmap_float")
    bump.CreateInput("in", T.Float3).ConnectToSource(passed.ConnectableAPI(), "out")
    bump.CreateInput("scale", T.Float).Set(0.25)
    looks.connect("base_color", passed, "out")
    looks.connect("specular_color", green, "out")
    looks.connect("normal", bump, "out")
    row, textures = looks.row()
    base, specular = textures[row["base_color_texture"]], textures[row["specular_texture"]]
    assert (base.wrap_s, base.wrap_t) == (scene.WRAP_BLACK, scene.WRAP_REPEAT)
    # MaterialX: (coordinates * uvtiling - uvoffset) / realworldimagesize
    np.testing.assert_allclose(base.transform.u_row, (0.5, 0, -0.125))
    np.testing.assert_allclose(base.transform.v_row, (0, 3, 0))
    assert base.texels[0, 0, :3].tolist() == [10, 20, 30]
    assert specular.texels[0, 0, :3].tolist() == [20, 20, 20]
    assert (row["normal_scale"], looks.read().uv_primvar) == (0.25, "st1")


def test_an_input_of_the_interface_without_a_value_leaves_the_default(recwarn):
    """Flattened MaterialX files connect inputs without a value to inputs of the material that have none either."""
    looks = material_x("standard_surface")
    left = looks.material.CreateInput("specular_roughness", T.Float)
    looks.surface.CreateInput("specular_roughness", T.Float).ConnectToSource(left)
    assert looks.row()[0]["roughness"] == np.float32(0.2)
    assert not recwarn.list
    left.GetAttr().AddConnection("/Looks/Nowhere.outputs:out")
    with pytest.warns(UserWarning, match="inputs:specular_roughness is connected to .* which gives no value"):
        assert looks.row()[0]["roughness"] == np.float32(0.2)


def test_material_x_scatters_the_color_of_an_image(tmp_path):
    looks = material_x("open_pbr_surface")
    image = looks.shader("/Looks/M/Image", "ND_image_color3")
    image.CreateInput("file", T.Asset).Set(str(save(tmp_path / "skin.png", (10, 20, 30))))
    looks.connect("subsurface_color", image, "out")
    looks.set("subsurface_weight", T.Float, 1.0)
    row, textures = looks.row()
    assert textures[row["base_color_texture"]].texels[0, 0, :3].tolist() == [10, 20, 30]
    np.testing.assert_allclose(row["base_color"], 1.0)
    looks.set("subsurface_weight", T.Float, 0.25)
    with pytest.warns(UserWarning, match="inputs:subsurface_color counts for 0.25 of the color"):
        assert looks.row()[0]["base_color_texture"] < 0


@pytest.mark.parametrize(
    ("surface", "name", "value", "weights"),
    [
        ("standard_surface", "coat_color", Gf.Vec3f(1, 0, 0), {"coat": 1.0}),
        ("standard_surface", "transmission_depth", 0.5, {"transmission": 1.0}),
        ("standard_surface", "specular_anisotropy", 0.5, {}),
        ("open_pbr_surface", "coat_color", Gf.Vec3f(1, 0, 0), {"coat_weight": 1.0}),
        ("open_pbr_surface", "transmission_scatter", Gf.Vec3f(1, 0, 0), {"transmission_weight": 1.0}),
        ("open_pbr_surface", "thin_film_weight", 0.5, {}),
    ],
)
def test_inputs_of_material_x_that_are_not_read_are_named(surface, name, value, weights, recwarn):
    looks = material_x(surface)
    looks.set(name, T.Float if isinstance(value, float) else T.Color3f, value)
    if weights:
        looks.row()  # without its weight it changes nothing
        assert not recwarn.list
    for weight, amount in weights.items():
        looks.set(weight, T.Float, amount)
    with pytest.warns(UserWarning, match=f"/Looks/M/.*: inputs:{name} is not supported and is ignored"):
        looks.row()


def test_a_thin_film_without_weight_is_not_warned_of(recwarn):
    looks = material_x("open_pbr_surface")
    looks.set("thin_film_thickness", T.Float, 0.5)
    looks.row()
    assert not recwarn.list


@pytest.mark.parametrize("name", ["base", "specular", "transmission", "specular_IOR", "emission"])
def test_images_where_material_x_may_only_have_numbers_are_named(name, tmp_path):
    looks = material_x("standard_surface")
    image = looks.shader("/Looks/M/Image", "ND_image_float")
    image.CreateInput("file", T.Asset).Set(str(save(tmp_path / "a.png", (10, 20, 30))))
    looks.connect(name, image, "out")
    with pytest.warns(UserWarning, match=f"inputs:{name} is connected to /Looks/M/Image, but is read as a constant"):
        looks.row()


OAK = """
mdl 1.4;
using ::OmniPBR import OmniPBR;  // a template
/* export material Oak(*) = OmniGlass(); */
export material Oak(*) [[ anno::display_name("Oak (light)"), anno::author("A, B") ]]
= OmniPBR(
    diffuse_color_constant: color(0.25f, 0.5, 0.75),
    diffuse_tint: color(0.5f),
    diffuse_texture: texture_2d("./oak (1), new.png", ::tex::gamma_srgb),
    reflectionroughness_texture: texture_2d(),
    reflection_roughness_constant: .125f,
    enable_emission: true,
    emissive_intensity: 1e2,
    texture_scale: float2(2.f, 4.0f),
    opacity_mode: mono_alpha,
    bump_factor: 0.5f);
export material Plywood(*) = Layers(a: 1.0);
"""


@pytest.mark.parametrize("authored", [None, 0.75])
def test_mdl_files_that_fill_in_a_template_are_read(authored, tmp_path):
    (tmp_path / "Wood.mdl").write_text(OAK)
    save(tmp_path / "oak (1), new.png", (1, 2, 3))
    looks = Mdl("Oak")
    looks.surface.SetSourceAsset(str(tmp_path / "Wood.mdl"), "mdl")
    if authored is not None:
        looks.set("reflection_roughness_constant", T.Float, authored)
    row, textures = looks.row()
    np.testing.assert_allclose(row["base_color"], 0.5)
    base = textures[row["base_color_texture"]]
    assert base.srgb
    assert (base.transform.u_row[0], base.transform.v_row[1]) == (2, 4)
    assert row["roughness"] == (authored or 0.125)
    assert (row["roughness_texture"], row["normal_scale"]) == (scene.NO_TEXTURE, 0.5)
    np.testing.assert_allclose(row["emission"], (100, 10, 10), rtol=1e-6)
    (tmp_path / "oak (1), new.png").unlink()
    np.testing.assert_allclose(looks_without_texture(looks, tmp_path), np.array([0.25, 0.5, 0.75]) * 0.5)


def looks_without_texture(looks, folder):
    with pytest.warns(UserWarning, match="oak"):
        return looks.row()[0]["base_color"]


@pytest.mark.parametrize("name", ["Plywood", "Steel"])
def test_mdl_files_that_say_more_are_named(name, tmp_path):
    (tmp_path / "Wood.mdl").write_text(OAK)
    looks = Mdl(name)
    looks.surface.SetSourceAsset(str(tmp_path / "Wood.mdl"), "mdl")
    with pytest.warns(UserWarning, match=f"/Looks/M.*{name}"):
        assert looks.read() is None


# Bindings


def bind_stage():
    stage = Usd.Stage.CreateInMemory()
    group = UsdGeom.Xform.Define(stage, "/Group").GetPrim()
    ball = UsdGeom.Sphere.Define(stage, "/Group/Ball").GetPrim()
    materials = {name: UsdShade.Material.Define(stage, f"/Looks/{name}") for name in "abc"}
    return stage, group, ball, materials


def bound_name(prim):
    (material,) = bound_materials([prim])
    return material and material.GetName()


def test_bindings_are_inherited_and_strength_is_respected():
    stage, group, ball, materials = bind_stage()
    assert bound_name(ball) is None
    UsdShade.MaterialBindingAPI.Apply(group).Bind(materials["a"])
    assert bound_name(ball) == "a"
    UsdShade.MaterialBindingAPI.Apply(ball).Bind(materials["b"])
    assert bound_name(ball) == "b"
    UsdShade.MaterialBindingAPI(group).Bind(materials["a"], UsdShade.Tokens.strongerThanDescendants)
    assert bound_name(ball) == "a"
    assert stage


def test_full_wins_over_all_purpose_which_wins_over_preview():
    stage, _, ball, materials = bind_stage()
    api = UsdShade.MaterialBindingAPI.Apply(ball)
    weaker = UsdShade.Tokens.fallbackStrength
    api.Bind(materials["a"], weaker, UsdShade.Tokens.preview)
    assert bound_name(ball) == "a"
    api.Bind(materials["b"])
    assert bound_name(ball) == "b"
    api.Bind(materials["c"], weaker, UsdShade.Tokens.full)
    assert bound_name(ball) == "c"
    assert stage


def test_collections_bind():
    stage, group, ball, materials = bind_stage()
    collection = Usd.CollectionAPI.Apply(group, "shiny")
    collection.IncludePath(ball.GetPath())
    UsdShade.MaterialBindingAPI.Apply(group).Bind(collection, materials["c"], "shiny")
    assert bound_name(ball) == "c"
    assert stage


def test_instances_have_the_material_of_their_variant():
    stage = Usd.Stage.CreateInMemory()
    asset = UsdGeom.Xform.Define(stage, "/Asset").GetPrim()
    ball = UsdGeom.Sphere.Define(stage, "/Asset/Ball").GetPrim()
    look = asset.GetVariantSets().AddVariantSet("look")
    UsdShade.MaterialBindingAPI.Apply(ball)
    for name, color in (("red", (1, 0, 0)), ("blue", (0, 0, 1))):
        material = UsdShade.Material.Define(stage, f"/Asset/{name}")
        shader = UsdShade.Shader.Define(stage, f"/Asset/{name}/Surface")
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("diffuseColor", T.Color3f).Set(Gf.Vec3f(*color))
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        look.AddVariant(name)
        look.SetVariantSelection(name)
        with look.GetVariantEditContext():
            UsdShade.MaterialBindingAPI(ball).Bind(material)
    for k, name in enumerate(("red", "blue")):
        placed = UsdGeom.Xform.Define(stage, f"/Placed{k}").GetPrim()
        placed.GetReferences().AddInternalReference("/Asset")
        placed.GetVariantSet("look").SetVariantSelection(name)
        placed.SetInstanceable(True)
    extractor = SceneExtractor(stage)

    def colors():
        extractor.update()
        instances, table = extractor.scene.instances, extractor.scene.materials["base_color"]
        rows = extractor.scene.material_slots[instances.slot_offset]
        return {path: tuple(table[row]) for path, row in zip(instances.paths, rows)}

    before = colors()
    assert (before["/Placed0/Ball"], before["/Placed1/Ball"]) == ((1, 0, 0), (0, 0, 1))
    stage.GetPrimAtPath("/Placed1").GetVariantSet("look").SetVariantSelection("red")
    assert colors()["/Placed1/Ball"] == (1, 0, 0)


def test_a_binding_to_nothing_is_named():
    stage, group, ball, _ = bind_stage()
    UsdShade.MaterialBindingAPI.Apply(group)
    group.GetRelationship("material:binding") or group.CreateRelationship("material:binding")
    group.GetRelationship("material:binding").SetTargets(["/Looks/gone"])
    with pytest.warns(UserWarning, match="/Group: .*gone"):
        assert bound_name(ball) is None
    assert stage


def test_a_binding_to_two_materials_is_named():
    stage, group, ball, _ = bind_stage()
    UsdShade.MaterialBindingAPI.Apply(group)
    group.CreateRelationship("material:binding").SetTargets(["/Looks/red", "/Looks/green"])
    with pytest.warns(UserWarning, match="/Group: material:binding names 2 materials, so none counts"):
        assert bound_name(ball) is None
    assert stage


@pytest.mark.parametrize(
    ("name", "kind", "value", "said", "used"),
    [
        ("metallic", T.Float, 1e30, "/Looks/M: its metallic is 1e\\+30, of which 1 is used", 1.0),
        ("roughness", T.Float, -5.0, "/Looks/M: its roughness is -5, of which 0 is used", 0.0),
        ("opacity", T.Float, 2.0, "/Looks/M: its opacity is 2, of which 1 is used", 1.0),
        ("opacityThreshold", T.Float, 3.0, "/Looks/M: its opacity threshold is 3, of which 1", 1.0),
        ("clearcoat", T.Float, -1.0, "/Looks/M: its clearcoat is -1, of which 0", 0.0),
        ("diffuseColor", T.Color3f, (-1, 0.5, 0), "/Looks/M: its base color is -1, of which 0", (0.0, 0.5, 0.0)),
        ("emissiveColor", T.Color3f, (0, -2, 0), "/Looks/M: its emission is -2, of which 0", (0.0, 0.0, 0.0)),
        ("ior", T.Float, 0.0, "/Looks/M/Surface: inputs:ior = 0 is no index of refraction", 0.0),
    ],
)
def test_numbers_out_of_range_are_named_once_and_limited(name, kind, value, said, used, recwarn):
    looks = Looks()
    looks.set(name, kind, value)
    columns = {"diffuseColor": "base_color", "emissiveColor": "emission", "opacityThreshold": "opacity_threshold"}
    with pytest.warns(UserWarning, match=said):
        row = looks.row()[0]
    looks.set(name, kind, tuple(2 * x for x in value) if isinstance(value, tuple) else 2 * value)
    looks.row()
    assert not recwarn
    np.testing.assert_array_equal(row[columns.get(name, name)], used)


def test_inputs_of_many_materials_that_are_out_of_range_are_named_each():
    """Where they are written all at once, as a randomizer's."""
    stage = Usd.Stage.CreateInMemory()
    shaders = []
    for k in range(3):
        material = UsdShade.Material.Define(stage, f"/M{k}")
        shader = UsdShade.Shader.Define(stage, f"/M{k}/S")
        shader.CreateIdAttr("UsdPreviewSurface")
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        shader.CreateInput("roughness", T.Float).Set(0.5)
        cube = UsdGeom.Cube.Define(stage, f"/C{k}").GetPrim()
        UsdShade.MaterialBindingAPI.Apply(cube).Bind(material)
        shaders.append(shader)
    extractor = SceneExtractor(stage)
    extractor.update()
    for roughness in (0.25, -0.5):
        with Sdf.ChangeBlock():
            for shader in shaders[:2]:
                shader.GetInput("roughness").Set(roughness)
        if roughness > 0.0:
            extractor.update()
    with pytest.warns(UserWarning, match="its roughness is -0.5") as caught:
        extractor.update()
    assert sorted(str(each.message).split(",")[0] for each in caught) == [
        "/M0: its roughness is -0.5",
        "/M1: its roughness is -0.5",
    ]
    assert sorted(extractor.scene.materials["roughness"].tolist())[:2] == [0.0, 0.0]


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("metallic_constant", 2.0, "its metallic is 2, of which 1"),
        ("specular_level", -1.0, "inputs:specular_level is -1, of which 0 is used. Author 0 or more"),
        ("diffuse_color_constant", (-1.0, 0.5, 0.5), "inputs:diffuse_color_constant has a negative color"),
        (
            "diffuse_color_constant",
            (255.0, 128.0, 0.0),
            "is 255, .* divide levels of 0 to 255 by 255",
        ),
    ],
)
def test_numbers_of_omni_pbr_out_of_range_are_named(name, value, said):
    looks = Mdl("OmniPBR")
    looks.set(name, T.Color3f if isinstance(value, tuple) else T.Float, value)
    with pytest.warns(UserWarning, match=said):
        looks.row()
