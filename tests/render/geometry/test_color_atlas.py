"""displayColor and displayOpacity that vary over a gprim."""

import re

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from tests.render.scenes import view_from
from tests.render.sync.test_extract_scene import add_material, base_colors, bind, extract, make_stage
from usdsdg.stage.colors import srgb_to_linear
from usdsdg_render.geometry.color_atlas import BLOCK_SIZES, MAX_WIDTH, atlas_uvs, color_atlas
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.sync.extract import SceneExtractor

SQUARE = [Gf.Vec3f(-1, -1, 0), Gf.Vec3f(1, -1, 0), Gf.Vec3f(1, 1, 0), Gf.Vec3f(-1, 1, 0)]


def add_square(stage, interpolation=None, values=(), indices=None, path="/Mesh"):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(SQUARE)
    mesh.CreateFaceVertexCountsAttr([3, 3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 0, 2, 3])
    mesh.CreateSubdivisionSchemeAttr("none")
    if interpolation is not None:
        color = mesh.CreateDisplayColorPrimvar(interpolation)
        color.Set([Gf.Vec3f(*map(float, value)) for value in values])
        if indices is not None:
            color.SetIndices(indices)
    return mesh


def look_up(texels, uv):
    """Bilinear, as the renderer does, in linear values; (N, 4)."""
    height, width = texels.shape[:2]
    linear = texels / 255.0
    linear[..., :3] = srgb_to_linear(linear[..., :3])
    x, y = uv[:, 0] * width - 0.5, (1 - uv[:, 1]) * height - 0.5
    left, top = np.floor(x + 1e-6).astype(int), np.floor(y + 1e-6).astype(int)
    right, down = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    fx, fy = (x - left)[:, None], (y - top)[:, None]
    upper = linear[top, left] * (1 - fx) + linear[top, right] * fx
    return upper * (1 - fy) + (linear[down, left] * (1 - fx) + linear[down, right] * fx) * fy


@pytest.mark.parametrize("side", [8, 4, 2])
@pytest.mark.parametrize("count", [1, 7, MAX_WIDTH // 2 + 3])
def test_the_atlas_interpolates_over_every_triangle(count, side, monkeypatch):
    monkeypatch.setattr("usdsdg_render.geometry.color_atlas.BLOCK_SIZES", ((10**12, side),))
    rng = np.random.default_rng(0)
    # The plane of these colors stays in [0, 1] over the whole block.
    colors = rng.uniform(0.34, 0.66, (count, 3, 4)).astype(np.float32)
    weights = rng.dirichlet(np.ones(3), count)
    uv = np.einsum("tk,tki->ti", weights, atlas_uvs(count).astype(np.float64))
    expected = np.einsum("tk,tki->ti", weights, colors)
    # Half a step of the sRGB curve at these values is 0.0045 at most.
    np.testing.assert_allclose(look_up(color_atlas(colors), uv), expected, atol=0.006)


def test_corners_of_full_colors_leak_little():
    """Between green and blue there is no red, though the red corner's continuation beyond them would be below zero."""
    count = 4
    colors = np.tile(np.append(np.eye(3), np.ones((3, 1)), axis=1).astype(np.float32), (count, 1, 1))
    uv = atlas_uvs(count).astype(np.float64)[:, 1:].mean(axis=1)
    middle = look_up(color_atlas(colors), uv)
    assert middle[:, 0].max() < 0.04
    np.testing.assert_allclose(middle[:, 1:3], 0.5, atol=0.02)
    assert BLOCK_SIZES[0][1] == 8


@pytest.mark.parametrize(
    ("interpolation", "where", "indices"),
    [
        ("uniform", [[0, 0, 0], [1, 1, 1]], None),
        ("vertex", [[0, 1, 2], [0, 2, 3]], None),
        ("varying", [[0, 1, 2], [0, 2, 3]], None),
        ("faceVarying", [[0, 1, 2], [3, 4, 5]], None),
        ("faceVarying", [[5, 4, 3], [2, 1, 0]], [5, 4, 3, 2, 1, 0]),
    ],
)
@pytest.mark.filterwarnings("ignore:.*those at the end are ignored")
def test_every_interpolation_comes_to_the_corners(interpolation, where, indices):
    values = np.random.default_rng(1).random((6, 3)).astype(np.float32)
    stage = make_stage()
    add_square(stage, interpolation, values, indices)
    scene = extract(stage)
    prototype = scene.prototypes[0]
    np.testing.assert_allclose(prototype.colors[..., :3], values[where], atol=1e-6)
    assert (prototype.colors[..., 3] == 1).all()
    assert base_colors(scene, 0) == [[1, 1, 1]]
    row = scene.materials[scene.material_slots[0]]
    texture = scene.textures[row["base_color_texture"]]
    seen = look_up(texture.texels, prototype.uvs.reshape(-1, 2).astype(np.float64))
    np.testing.assert_allclose(seen[:, :3], values[where].reshape(-1, 3), atol=0.005)
    assert row["opacity_texture"] == -1


def test_the_drawn_color_is_that_of_the_corners():
    """Red at the left, green at the right, seen from above: the albedo of a pixel is the mixture there."""
    stage = make_stage()
    add_square(stage, "vertex", [(0.8, 0, 0.2), (0, 0.8, 0.2), (0, 0.8, 0.2), (0.8, 0, 0.2)])
    renderer = WarpRenderer(stage, device="cpu")
    renderer.sync()
    view = view_from((0, 0, 4), size=(33, 33), up=(0, 1, 0))
    albedo = renderer.labels(view, ["albedo"])["albedo"][16].astype(float)
    column = np.arange(33)
    x = (column + 0.5 - 16.5) / view.fx * 4
    inside = np.abs(x) < 0.95
    share = (x[inside] + 1) / 2
    expected = np.stack([0.8 * (1 - share), 0.8 * share, 0 * share + 0.2], axis=-1)
    np.testing.assert_allclose(albedo[inside], expected, atol=0.02)


def test_opacity_may_vary_too():
    stage = make_stage()
    mesh = add_square(stage)
    mesh.CreateDisplayOpacityPrimvar("uniform").Set([1.0, 0.25])
    scene = extract(stage)
    row = scene.materials[scene.material_slots[0]]
    assert row["opacity_texture"] == row["base_color_texture"] >= 0
    assert row["opacity_channel"] == 3
    np.testing.assert_allclose(scene.prototypes[0].colors[..., 3], [[1] * 3, [0.25] * 3])


def test_points_have_a_color_each():
    stage = make_stage()
    cloud = UsdGeom.Points.Define(stage, "/Cloud")
    cloud.CreatePointsAttr([Gf.Vec3f(0), Gf.Vec3f(3, 0, 0)])
    cloud.CreateWidthsAttr([1.0, 1.0])
    cloud.CreateDisplayColorPrimvar("vertex").Set([Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 0, 1)])
    prototype = extract(stage).prototypes[0]
    for point, color in enumerate([(1, 0, 0), (0, 0, 1)]):
        mine = prototype.colors[prototype.triangle_faces == point]
        assert (mine[..., :3] == color).all()


def test_refined_surfaces_blend_over_the_faces_of_their_control_mesh():
    stage = make_stage()
    mesh = add_square(stage, "vertex", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    mesh.GetFaceVertexCountsAttr().Set([4])
    mesh.GetFaceVertexIndicesAttr().Set([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr("bilinear")
    mesh.GetPrim().CreateAttribute("refinementEnableOverride", Sdf.ValueTypeNames.Bool).Set(True)
    mesh.GetPrim().CreateAttribute("refinementLevel", Sdf.ValueTypeNames.Int).Set(2)
    prototype = extract(stage).prototypes[0]
    at = prototype.points[prototype.triangles]
    np.testing.assert_allclose(prototype.colors[..., :2], (at[..., :2] + 1) / 2, atol=1e-6)


def test_a_material_that_reads_the_color_gets_it_varying():
    stage = make_stage()
    material = add_material(stage, "/Looks/M")
    reader = UsdShade.Shader.Define(stage, "/Looks/M/Reader")
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
    surface = UsdShade.Shader(stage.GetPrimAtPath("/Looks/M/Surface"))
    surface.GetInput("diffuseColor").ConnectToSource(reader.ConnectableAPI(), "result")
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.25)
    bind(add_square(stage, "uniform", [(1, 0, 0), (0, 1, 0)]), material)
    scene = extract(stage)
    row = scene.materials[scene.material_slots[0]]
    assert row["base_color_texture"] >= 0
    assert row["roughness"] == 0.25


def test_a_bound_material_wins_and_edits_are_followed():
    stage = make_stage()
    mesh = add_square(stage, "uniform", [(1, 0, 0), (0, 1, 0)])
    extractor = SceneExtractor(stage)
    extractor.update()
    assert len(extractor.scene.textures) == 1
    mesh.GetDisplayColorAttr().Set([Gf.Vec3f(0, 0, 1), Gf.Vec3f(0, 1, 0)])
    extractor.update()
    scene = extractor.scene
    texture = scene.textures[scene.materials[scene.material_slots[0]]["base_color_texture"]]
    assert texture.texels[0, 0, :3].tolist() == [0, 0, 255]
    bind(mesh, add_material(stage, "/Looks/M", (0.5, 0.5, 0.5)))
    extractor.update()
    assert base_colors(extractor.scene, 0) == [[0.5, 0.5, 0.5]]
    assert extractor.scene.materials[extractor.scene.material_slots[0]]["base_color_texture"] == -1


def test_moving_points_keep_their_colors():
    stage = make_stage()
    mesh = add_square(stage, "uniform", [(1, 0, 0), (0, 1, 0)])
    mesh.GetPointsAttr().Set(SQUARE, 0)
    mesh.GetPointsAttr().Set([2 * p for p in SQUARE], 10)
    extractor = SceneExtractor(stage)
    for code in (0, 5):
        extractor.update(Usd.TimeCode(code))
        scene = extractor.scene
        prototype = scene.prototypes[scene.instances.prototype[0]]
        assert (prototype.colors[0, :, :3] == [1, 0, 0]).all()
        assert scene.materials[scene.material_slots[scene.instances.slot_offset[0]]]["base_color_texture"] >= 0
    assert prototype.points.max() == 1.5


@pytest.mark.parametrize(
    ("interpolation", "values", "indices", "said"),
    [
        ("faceVarying", 2, None, "the 2 values of its faceVarying displayColor are too few for 6, so the means"),
        ("vertex", 3, None, "the 3 values of its vertex displayColor are too few for 4, so the means"),
        ("vertex", 3, [0, 1, 2], "the 3 indices of its vertex displayColor are too few for 4, so the means"),
        (
            "vertex",
            2,
            [0, 1, 7, 1],
            r"1 index of its displayColor is outside its 2 values \(first: 7\), so the means",
        ),
        (
            "vertex",
            2,
            [0, -1, 0, 1],
            r"1 index of its displayColor is outside its 2 values \(first: -1\), so the means",
        ),
        ("vertex", 5, None, "the 5 values of its vertex displayColor are more than 4; those at the end are ignored"),
        ("uniform", 2, [0, 1, 0], "the 3 indices of its uniform displayColor are more than 2; those at the end"),
        ("constant", 3, None, "primvars:displayColor: its interpolation constant takes one value"),
    ],
)
def test_colors_that_do_not_fit_are_named(interpolation, values, indices, said, recwarn):
    stage = make_stage()
    rgb = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 0, 1)][:values]
    add_square(stage, interpolation, rgb, indices)
    scene = extract(stage)
    (message,) = [str(each.message) for each in recwarn if "displayColor" in str(each.message)]
    assert message.startswith("/Mesh")
    assert re.search(said, message)
    # A texture has the colors where only some are ignored.
    shown = {"the means": np.mean(rgb, axis=0), "at the end": (1, 1, 1), "the first": (1, 0, 0)}
    expected = next(color for words, color in shown.items() if words in message)
    np.testing.assert_allclose(base_colors(scene, 0), [expected], atol=1e-6)


def test_too_few_opacities_are_named():
    stage = make_stage()
    opacity = add_square(stage).CreateDisplayOpacityPrimvar("vertex")
    opacity.Set([0.0, 0.0, 1.0])
    with pytest.warns(UserWarning, match="/Mesh: the 3 values of its vertex displayOpacity are too few for 4"):
        assert extract(stage).prototypes[0].colors is None


def test_the_mean_of_indexed_colors_is_that_of_the_elements():
    stage = make_stage()
    cube = UsdGeom.Cube.Define(stage, "/Cube")
    color = cube.CreateDisplayColorPrimvar("vertex")
    color.Set([Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 0, 1)])
    color.SetIndices([0, 0, 0, 1])
    with pytest.warns(UserWarning, match="/Cube: .*its mean is used"):
        scene = extract(stage)
    assert base_colors(scene, 0) == [[0.75, 0, 0.25]]
