"""Images and light profiles that a script writes again under the same name: the next picture shows them."""

from collections.abc import Callable

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade

import usdsdg as rep
from usdsdg.session import engines
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage

CAMERA = "/World/Camera"


def paint(file, color) -> None:
    Image.fromarray(np.full((4, 4, 3), color, np.uint8)).save(file)


def textured_quad(file) -> None:
    stage = current_stage()
    mesh = UsdGeom.Mesh.Define(stage, "/World/Quad")
    mesh.CreatePointsAttr([Gf.Vec3f(*p) for p in ((-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0))])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
    st.Set([Gf.Vec2f(0, 0), Gf.Vec2f(1, 0), Gf.Vec2f(1, 1), Gf.Vec2f(0, 1)])
    material = UsdShade.Material.Define(stage, "/World/Look")
    surface, texture = (UsdShade.Shader.Define(stage, f"/World/Look/{name}") for name in ("Surface", "Texture"))
    surface.CreateIdAttr("UsdPreviewSurface")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(str(file))
    color = surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    color.ConnectToSource(texture.ConnectableAPI(), "rgb")
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)


def textured_dome(file) -> None:
    dome = UsdLux.DomeLight.Define(current_stage(), "/World/Sky")
    dome.CreateTextureFileAttr(str(file))
    dome.CreateIntensityAttr(1000)


def textured_light(file) -> None:
    light = UsdLux.RectLight.Define(current_stage(), "/World/Rect")
    light.CreateTextureFileAttr(str(file))
    light.CreateIntensityAttr(1000)
    light.CreateWidthAttr(4)
    light.CreateHeightAttr(4)
    light.AddRotateXOp().Set(180.0)


def picture_of(build: Callable, file) -> rep.annotators.Annotator:
    UsdGeom.SetStageUpAxis(current_stage(), "Z")
    build(file)
    if build is not textured_dome:
        UsdLux.DomeLight.Define(current_stage(), "/World/Light").CreateIntensityAttr(1000)
    camera = UsdGeom.Camera.Define(current_stage(), CAMERA)
    camera.AddTranslateOp().Set(Gf.Vec3d(0, 0, 5))
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.01, 100))
    rep.settings.set_render_pathtraced(samples_per_pixel=4)
    rgb = rep.annotators.get("rgb")
    rgb.attach(rep.create.render_product(CAMERA, (16, 12)))
    return rgb


def stepped(rgb, *, frame: int) -> np.ndarray:
    current().orchestrator.captures = frame  # which seeds the noise
    rep.orchestrator.step(delta_time=0.0)
    return rgb.get_data()


@pytest.mark.parametrize("build", [textured_quad, textured_dome, textured_light])
def test_a_file_that_is_written_again_shows_as_on_a_new_stage(build, tmp_path, stage):
    file = tmp_path / "image.png"
    paint(file, (200, 20, 20))
    rep.set_global_seed(1)
    rgb = picture_of(build, file)
    red, again = stepped(rgb, frame=0), stepped(rgb, frame=0)
    assert (red == again).all()
    paint(file, (20, 20, 200))
    blue = stepped(rgb, frame=0)
    assert (blue != red).any()
    rep.new_stage()
    rep.set_global_seed(1)
    assert (stepped(picture_of(build, file), frame=0) == blue).all()


def test_a_udim_tile_that_is_added_shows_as_on_a_new_stage(tmp_path, stage):
    def build(file):
        textured_quad(file)
        coordinates = UsdGeom.PrimvarsAPI(current_stage().GetPrimAtPath("/World/Quad")).GetPrimvar("st")
        coordinates.Set([Gf.Vec2f(2 * u, v) for u, v in coordinates.Get()])

    paint(tmp_path / "a.1001.png", (200, 20, 20))
    rep.set_global_seed(1)
    rgb = picture_of(build, tmp_path / "a.<UDIM>.png")
    one = stepped(rgb, frame=0)
    (tmp_path / "notes.txt").write_text("no tile")
    assert (stepped(rgb, frame=0) == one).all()
    paint(tmp_path / "a.1002.png", (20, 20, 200))
    two = stepped(rgb, frame=0)
    assert (two != one).any()
    rep.new_stage()
    rep.set_global_seed(1)
    assert (stepped(picture_of(build, tmp_path / "a.<UDIM>.png"), frame=0) == two).all()


def test_textures_of_earlier_contents_are_not_kept(tmp_path, stage):
    file = tmp_path / "image.png"
    paint(file, (0, 0, 0))
    rgb = picture_of(textured_quad, file)
    for frame in range(5):
        paint(file, (40 * frame, 0, 10))
        stepped(rgb, frame=frame)
    renderer = engines.renderer()
    assert len(renderer._extractor.scene.textures) == 1
