"""From stage to image: orientation of textures and environments, and photometric units."""

import math

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from usdsdg.errors import RenderError
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.settings import PathSettings, ToneSettings

SIZE = 16
QUARTERS = np.array([[(255, 0, 0), (0, 255, 0)], [(0, 0, 255), (255, 255, 255)]], np.uint8)


def make_stage(up="Z"):
    """A camera at the origin that looks along +Y (Z up) or -Z (Y up), 90 degrees wide."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    camera = UsdGeom.Camera.Define(stage, "/Camera")
    camera.CreateFocalLengthAttr(10.0)
    camera.CreateHorizontalApertureAttr(20.0)
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.01, 1000))
    if up == "Z":
        camera.AddRotateXYZOp().Set(Gf.Vec3f(90, 0, 0))
    return stage


def add_wall(stage, distance=5.0, file=None):
    """A square that fills half of the image's width, facing the camera, white or with a texture; Z up."""
    half = distance / 2
    mesh = UsdGeom.Mesh.Define(stage, "/Wall")
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
    mesh.CreatePointsAttr([Gf.Vec3f(x, distance, z) for x, z in corners])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr("none")
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
    st.Set([Gf.Vec2f(0, 0), Gf.Vec2f(1, 0), Gf.Vec2f(1, 1), Gf.Vec2f(0, 1)])
    material = UsdShade.Material.Define(stage, "/Looks/Wall")
    surface = UsdShade.Shader.Define(stage, "/Looks/Wall/Surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("ior", Sdf.ValueTypeNames.Float).Set(1.0)  # no reflection
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(1.0)
    diffuse = surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    diffuse.Set(Gf.Vec3f(0.5))
    if file is not None:
        texture = UsdShade.Shader.Define(stage, "/Looks/Wall/Tex")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(str(file))
        diffuse.ConnectToSource(texture.ConnectableAPI(), "rgb")
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)


def view_of(stage):
    return read_camera(stage, "/Camera", (SIZE, SIZE))


def labels(stage, *aovs):
    renderer = WarpRenderer(stage, device="cpu")
    renderer.sync()
    return renderer.labels(view_of(stage), aovs)


def rendered(stage, samples):
    """(H, W, 3) linear radiance."""
    renderer = WarpRenderer(stage, device="cpu")
    renderer.sync()
    film = renderer.new_film(SIZE, SIZE)
    renderer.accumulate(film, view_of(stage), samples=samples, settings=PathSettings())
    return renderer.develop(film, ToneSettings())["HdrColor"][..., :3].astype(np.float64)


def quarters(image):
    """Values at the centers of the four quarters of the wall, as rows and columns of the image."""
    near, far = SIZE // 2 - 2, SIZE // 2 + 1
    return image[np.ix_([near, far], [near, far])]


def test_textures_are_upright_and_not_mirrored(tmp_path):
    Image.fromarray(QUARTERS.repeat(32, axis=0).repeat(32, axis=1)).save(tmp_path / "wall.png")
    stage = make_stage()
    add_wall(stage, file=tmp_path / "wall.png")
    np.testing.assert_allclose(quarters(labels(stage, "albedo")["albedo"]), QUARTERS / 255, atol=1e-3)


@pytest.mark.parametrize("up", ["Y", "Z"])
def test_environments_are_upright_and_not_mirrored(up, tmp_path):
    """A camera that looks at the middle of the panorama sees it as the file shows it."""
    # Only the middle of the panorama differs from black: its quarters, as above.
    panorama = np.zeros((32, 64, 3), np.uint8)
    panorama[8:24, 24:40] = QUARTERS.repeat(8, axis=0).repeat(8, axis=1)
    Image.fromarray(panorama).save(tmp_path / "sky.png")
    stage = make_stage(up)
    # The middle lies toward +Z (Y up) or -Y (Z up): behind a camera that looks along -Z or +Y.
    op = UsdGeom.Xformable(stage.GetPrimAtPath("/Camera"))
    op.ClearXformOpOrder()
    turn = Gf.Rotation(Gf.Vec3d(0, 1, 0), 180)
    if up == "Z":
        turn = turn * Gf.Rotation(Gf.Vec3d(1, 0, 0), 90)
    op.AddTransformOp().Set(Gf.Matrix4d(turn, Gf.Vec3d(0)))
    UsdLux.DomeLight.Define(stage, "/Sky").CreateTextureFileAttr(str(tmp_path / "sky.png"))
    np.testing.assert_allclose(quarters(rendered(stage, 1)), QUARTERS / 255, atol=0.01)


def test_a_distant_light_gives_lux_over_pi_times_albedo():
    stage = make_stage()
    add_wall(stage)
    light = UsdLux.DistantLight.Define(stage, "/Sun")
    light.CreateIntensityAttr(400.0)
    light.AddRotateXYZOp().Set(Gf.Vec3f(90 - 60, 0, 0))  # incident at 60 degrees above the wall's normal
    radiance = quarters(rendered(stage, 16))
    np.testing.assert_allclose(radiance, 0.5 * 400.0 * math.cos(math.radians(60)) / math.pi, rtol=0.02)


def test_a_sphere_light_follows_the_inverse_square_law():
    stage = make_stage()
    add_wall(stage)
    light = UsdLux.SphereLight.Define(stage, "/Lamp")
    light.CreateIntensityAttr(1e5)
    light.CreateRadiusAttr(0.01)
    center = rendered(stage, 64)[SIZE // 2 - 1 : SIZE // 2 + 1, SIZE // 2 - 1 : SIZE // 2 + 1]
    # Intensity pi r^2 L [cd] at five units; the pixels around the center see it up to 5 degrees off.
    expected = 0.5 / math.pi * math.pi * 0.01**2 * 1e5 / 25.0
    np.testing.assert_allclose(center, expected, rtol=0.03)


def test_a_uniform_dome_is_a_furnace():
    stage = make_stage()
    add_wall(stage)
    UsdLux.DomeLight.Define(stage, "/Sky").CreateIntensityAttr(4.0)
    image = rendered(stage, 256)
    np.testing.assert_allclose(quarters(image), 2.0, rtol=0.05)  # a wall of albedo 0.5 reflects half of it
    np.testing.assert_allclose(image[0], 4.0, rtol=1e-3)


@pytest.mark.parametrize("given", [None, "scene.usda"])
def test_what_is_no_stage_is_refused(given):
    with pytest.raises(RenderError, match=r"stage is .*; expected a Usd\.Stage, as Usd\.Stage\.Open"):
        WarpRenderer(given)
