"""Dome lights: mapping of directions to texels, units, several domes, unreadable textures."""

import math

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from usdsdg.stage.poses.transforms import local_to_world
from usdsdg_render.lights.domes import DomeBuilder, read_dome
from usdsdg_render.lights.light_textures import directions, resample

HEIGHT, WIDTH = 16, 32
ALIVE = []  # a prim does not keep its stage


def make_stage(up="Z"):
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, up)
    ALIVE.append(stage)
    return stage


def write_texture(path, texture):
    """Write a flat Radiance file with values that RGBE represents exactly."""
    mantissa = np.clip(texture * 128, 0, 255).astype(np.uint8)
    rgbe = np.concatenate([mantissa, np.full((*texture.shape[:2], 1), 129, np.uint8)], axis=-1)
    height, width = texture.shape[:2]
    path.write_bytes(b"#?RADIANCE\n\n" + f"-Y {height} +X {width}\n".encode() + rgbe.tobytes())
    return str(path)


def marked(row, column):
    texture = np.zeros((HEIGHT, WIDTH, 3))
    texture[row, column] = 1.0
    return texture


def dome_of(*prims):
    read = [read_dome(prim, np.array(local_to_world(prim))) for prim in prims]
    return DomeBuilder().build([dome for dome in read if dome is not None])


def texel_seen(dome, direction):
    """Row and column that `scene.Dome` looks up for a world direction."""
    d = dome.dome_from_world.astype(float) @ (np.array(direction, float) / np.linalg.norm(direction))
    height, width = dome.radiance.shape[:2]
    row = int(np.clip(math.acos(np.clip(d[2], -1, 1)) / math.pi * height, 0, height - 1))
    column = int(math.atan2(d[1], d[0]) / (2 * math.pi) % 1.0 * width) % width
    return row, column


def openexr_texel(direction, up):
    """The lat-long convention that UsdLux cites: x from longitude +pi to -pi, +Z at 0, +X at +pi/2, +Y up.

    With a Z pole, longitude 0 points to -Y instead.
    """
    x, y, z = np.array(direction, float) / np.linalg.norm(direction)
    if up == "Z":
        x, y, z = x, z, -y
    longitude, latitude = math.atan2(x, z), math.asin(y)
    column = (math.pi - longitude) / (2 * math.pi) * WIDTH
    row = (math.pi / 2 - latitude) / math.pi * HEIGHT
    return int(np.clip(row, 0, HEIGHT - 1)), int(column) % WIDTH


@pytest.mark.parametrize("up", ["Y", "Z"])
@pytest.mark.parametrize("kind", ["DomeLight", "DomeLight_1"])
def test_directions_map_to_the_texels_of_usdlux(kind, up, tmp_path):
    stage = make_stage(up)
    prim = stage.DefinePrim("/Sky", kind)
    prim.GetAttribute("inputs:texture:file").Set(write_texture(tmp_path / "sky.hdr", np.ones((HEIGHT, WIDTH, 3))))
    dome = dome_of(prim)
    for direction in np.random.default_rng(2).normal(size=(200, 3)):
        assert texel_seen(dome, direction) == openexr_texel(direction, up)


def test_pole_axis_is_honored_and_old_domes_can_ask_for_a_y_pole():
    stage = make_stage("Z")
    new = stage.DefinePrim("/New", "DomeLight_1")
    new.GetAttribute("poleAxis").Set("Y")
    old = UsdLux.DomeLight.Define(stage, "/Old")
    assert texel_seen(dome_of(new), (0, 1, 0))[0] == 0
    dome = dome_of(old.GetPrim())
    np.testing.assert_allclose(dome.dome_from_world @ [0, 0, 1], [0, 0, 1], atol=1e-6)
    old.OrientToStageUpAxis()  # authors a rotation of +Y to up: the pole must still be up
    dome = dome_of(old.GetPrim())
    np.testing.assert_allclose(dome.dome_from_world @ [0, 0, 1], [0, 0, 1], atol=1e-6)


def test_rotation_turns_the_dome_and_scale_is_ignored():
    stage = make_stage("Z")
    prim = stage.DefinePrim("/Sky", "DomeLight")
    before = dome_of(prim).dome_from_world
    xform = UsdGeom.Xformable(prim)
    xform.AddTranslateOp().Set(Gf.Vec3d(5, 6, 7))
    xform.AddRotateXYZOp().Set(Gf.Vec3f(20, 30, 40))
    rotation = np.array(local_to_world(prim))[:3, :3]
    xform.AddScaleOp().Set(Gf.Vec3f(3))
    after = dome_of(prim).dome_from_world
    direction = np.array([0.3, -0.5, 0.8])
    np.testing.assert_allclose(after @ (direction @ rotation), before @ direction, atol=1e-6)


def test_radiance_is_texel_times_intensity_exposure_and_color(tmp_path):
    texture = np.full((HEIGHT, WIDTH, 3), 0.5)
    stage = make_stage()
    light = UsdLux.DomeLight.Define(stage, "/Sky")
    light.CreateTextureFileAttr(write_texture(tmp_path / "sky.hdr", texture))
    light.CreateIntensityAttr(100.0)
    light.CreateExposureAttr(1.0)
    light.CreateColorAttr(Gf.Vec3f(1, 0.5, 0.25))
    light.CreateNormalizeAttr(True)  # ignored for domes
    np.testing.assert_allclose(dome_of(light.GetPrim()).radiance[3, 4], [100, 50, 25], rtol=1e-6)


def test_low_dynamic_range_textures_are_decoded_from_srgb(tmp_path):
    Image.fromarray(np.full((4, 8, 3), 188, np.uint8)).save(tmp_path / "sky.png")
    light = UsdLux.DomeLight.Define(make_stage(), "/Sky")
    light.CreateTextureFileAttr(str(tmp_path / "sky.png"))
    # sRGB 188 is half of white within one code value.
    np.testing.assert_allclose(dome_of(light.GetPrim()).radiance, 0.5, atol=0.005)


def test_the_brightest_texels_of_a_file_stay_finite(tmp_path):
    (tmp_path / "sky.hdr").write_bytes(b"#?RADIANCE\n\n-Y 1 +X 2\n" + bytes([255] * 8))
    light = UsdLux.DomeLight.Define(make_stage(), "/Sky")
    light.CreateTextureFileAttr(str(tmp_path / "sky.hdr"))
    light.CreateIntensityAttr(1e4)
    np.testing.assert_allclose(dome_of(light.GetPrim()).radiance, 1e16)


def test_domes_that_overflow_warn_and_are_off():
    light = UsdLux.DomeLight.Define(make_stage(), "/Sky")
    light.CreateExposureAttr(500.0)
    with pytest.warns(UserWarning, match="/Sky: intensity, exposure and color give .* Author values from 0 to 1e.20"):
        assert read_dome(light.GetPrim(), np.eye(4)) is None


def test_a_dome_without_texture_is_uniform_and_tiny():
    light = UsdLux.DomeLight.Define(make_stage(), "/Sky")
    light.CreateIntensityAttr(30.0)
    dome = dome_of(light.GetPrim())
    assert dome.radiance.shape == (1, 2, 3)
    assert (dome.radiance == 30.0).all()


def test_several_domes_are_summed_in_their_own_orientation(tmp_path):
    stage = make_stage("Z")
    first = UsdLux.DomeLight.Define(stage, "/A")
    first.CreateTextureFileAttr(write_texture(tmp_path / "a.hdr", np.full((HEIGHT, WIDTH, 3), 0.25)))
    second = UsdLux.DomeLight.Define(stage, "/B")
    second.CreateTextureFileAttr(write_texture(tmp_path / "b.hdr", marked(6, 9)))
    second.AddRotateZOp().Set(90.0)
    third = UsdLux.DomeLight.Define(stage, "/C")
    third.CreateIntensityAttr(2.0)
    dome = dome_of(*(light.GetPrim() for light in (first, second, third)))
    assert dome.radiance.shape == (HEIGHT, WIDTH, 3)
    # The direction in which the second dome alone has its bright texel:
    alone = dome_of(second.GetPrim())
    toward = alone.dome_from_world.T @ directions(HEIGHT, WIDTH)[6, 9]
    assert texel_seen(alone, toward) == (6, 9)
    row, column = texel_seen(dome, toward)
    assert dome.radiance[row, column, 0] == pytest.approx(3.25, abs=1e-3)
    elsewhere = np.ones((HEIGHT, WIDTH), bool)
    elsewhere[row - 1 : row + 2, column - 1 : column + 2] = False
    np.testing.assert_allclose(dome.radiance[elsewhere], 2.25, atol=1e-6)


def test_resampling_preserves_smooth_textures():
    d = directions(64, 128)
    smooth = (1.0 + d @ np.array([0.3, 0.2, 0.5]))[..., None] * np.ones(3)
    turn = np.array(Gf.Matrix3d(Gf.Rotation(Gf.Vec3d(1, 2, 3), 50)))
    turned = resample(smooth.astype(np.float32), np.eye(3), turn, (64, 128))
    expected = 1.0 + (d @ turn.T) @ np.array([0.3, 0.2, 0.5])
    np.testing.assert_allclose(turned[..., 0], expected, atol=0.01)


@pytest.mark.parametrize("name", ["missing.hdr", "broken.hdr"])
def test_unreadable_textures_warn_and_become_uniform(name, tmp_path):
    (tmp_path / "broken.hdr").write_bytes(b"#?RADIANCE\n\n-Y 4 +X 8\nshort")
    light = UsdLux.DomeLight.Define(make_stage(), "/Sky")
    light.CreateTextureFileAttr(str(tmp_path / name))
    with pytest.warns(UserWarning, match=f"/Sky.*{name}"):
        assert (dome_of(light.GetPrim()).radiance == 1.0).all()


def test_unsupported_formats_warn_and_hidden_domes_stay_hidden(tmp_path):
    light = UsdLux.DomeLight.Define(make_stage(), "/Sky")
    light.CreateTextureFormatAttr("octahedron")
    light.GetPrim().CreateAttribute("visibleInPrimaryRay", Sdf.ValueTypeNames.Bool).Set(False)
    with pytest.warns(UserWarning, match="octahedron"):
        assert dome_of(light.GetPrim()).visible is False


def sky(direction):
    """A smooth sky in the space of a dome with a Y pole: ahead is +Z, the center of lat-long textures."""
    x, y, z = np.moveaxis(direction, -1, 0)
    return np.stack([1.5 + x + 0.3 * y, 1.5 + y - 0.2 * z, 1.5 + z + 0.4 * x], -1) / 3


def drawn(layout, size):
    """The smooth sky in one of UsdLux's formats, by its definition from texel to direction."""
    if layout == "cubeMapVerticalCross":
        texture = np.zeros((4 * size, 3 * size, 3))
        a = (np.arange(size) + 0.5) / size * 2 - 1
        u, v = np.meshgrid(a, -a)  # right and up on the face
        one = np.ones_like(u)
        faces = {  # (row, column): direction by right, up of the face; the right hand of +Z ahead is -X
            (1, 1): (-u, v, one),
            (1, 0): (one, v, u),
            (1, 2): (-one, v, -u),
            (0, 1): (-u, one, -v),
            (2, 1): (-u, -one, v),
            (3, 1): (-u, -v, -one),
        }
        for (row, column), face in faces.items():
            d = np.stack(face, -1)
            d /= np.linalg.norm(d, axis=-1, keepdims=True)
            texture[row * size : (row + 1) * size, column * size : (column + 1) * size] = sky(d)
        return texture
    a = (np.arange(size) + 0.5) / size * 2 - 1
    u, v = np.meshgrid(a, -a)
    radius = np.minimum(np.hypot(u, v), 1.0)
    turn = np.arctan2(v, u)
    if layout == "mirroredBall":
        # Reflect the view direction -Z at the normal of the ball. +X is at the right of the image.
        normal = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1 - radius**2)], -1)
        view = np.array([0.0, 0.0, -1.0])
        return sky(view - 2 * (normal @ view)[..., None] * normal)
    angle = np.pi * radius
    return sky(np.stack([-np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], -1))


@pytest.mark.parametrize("layout", ["mirroredBall", "angular", "cubeMapVerticalCross"])
def test_other_layouts_give_the_same_environment(layout, tmp_path):
    texture = drawn(layout, 128)
    Image.fromarray((texture * 65535)[..., 0].astype(np.uint16)).save(tmp_path / "sky.png")
    dome = UsdLux.DomeLight.Define(make_stage("Y"), "/Sky")
    dome.CreateTextureFileAttr(str(tmp_path / "sky.png"))
    dome.CreateTextureFormatAttr("automatic" if layout == "cubeMapVerticalCross" else layout)
    read = dome_of(dome.GetPrim())
    height, width = read.radiance.shape[:2]
    assert width == 2 * height
    world = directions(height, width) @ read.dome_from_world.astype(float)
    expected = sky(world)[..., 0]
    # Directly behind a ball one texel covers a wide angle.
    clear = world[..., 2] > -0.95
    np.testing.assert_allclose(read.radiance[..., 0][clear], expected[clear], atol=0.02)


def test_unsupported_dome_inputs_warn():
    light = UsdLux.DomeLight.Define(make_stage(), "/Sky")
    light.CreateDiffuseAttr(0.25)
    light.CreateSpecularAttr(2.0)
    UsdLux.ShadowAPI.Apply(light.GetPrim()).CreateShadowEnableAttr(False)
    with pytest.warns(UserWarning, match="/Sky.*shadow:enable"):
        dome = dome_of(light.GetPrim())
    assert (dome.diffuse, dome.specular) == (0.25, 2.0)
    UsdLux.LightAPI(light).GetLightLinkCollectionAPI().ExcludePath("/Other")
    with pytest.warns(UserWarning, match="/Sky.*links"):
        dome_of(light.GetPrim())


@pytest.mark.parametrize(
    ("name", "neutral", "value"),
    [
        ("shaping:cone:angle", 180.0, 30.0),
        ("shaping:focus", 0.0, 2.0),
        ("shaping:ies:file", Sdf.AssetPath(), Sdf.AssetPath("lamp.ies")),
        ("shadow:color", Gf.Vec3f(0), Gf.Vec3f(1, 0, 0)),
        ("shadow:distance", -1.0, 3.0),
    ],
)
def test_what_a_dome_light_does_not_have_is_named(name, neutral, value, recwarn):
    prim = UsdLux.DomeLight.Define(make_stage(), "/Sky").GetPrim()
    UsdLux.ShapingAPI.Apply(prim)
    UsdLux.ShadowAPI.Apply(prim)
    prim.GetAttribute(f"inputs:{name}").Set(neutral)
    dome_of(prim)
    assert not recwarn
    prim.GetAttribute(f"inputs:{name}").Set(value)
    with pytest.warns(UserWarning, match=f"/Sky: inputs:{name} have no effect on a dome light"):
        dome_of(prim)


def test_dark_domes_are_skipped():
    light = UsdLux.DomeLight.Define(make_stage(), "/Sky")
    light.CreateIntensityAttr(0.0)
    assert dome_of(light.GetPrim()) is None
