"""Normal maps in a white world: what they turn into the surface comes back by the bumps beside it."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade, Vt

from tests.render import scenes
from tests.render.images import EXACT
from tests.render.materials.test_materials import Looks
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.settings import PathSettings

CORNERS = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])


def looks_of(inputs: dict) -> Looks:
    looks = Looks()
    for name, value in inputs.items():
        kind = Sdf.ValueTypeNames.Float if isinstance(value, float) else Sdf.ValueTypeNames.Color3f
        looks.set(name, kind, value)
    return looks


def add_mesh(looks: Looks, points: np.ndarray, faces: np.ndarray) -> UsdGeom.Mesh:
    mesh = UsdGeom.Mesh.Define(looks.stage, "/Square")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(faces), 4))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(faces.ravel().astype(np.int32)))
    mesh.CreateSubdivisionSchemeAttr("none")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(looks.material)
    return mesh


def drawn(looks: Looks, elevation: float, *, samples: int, bounces: int, focal_length: float) -> np.ndarray:
    """(8, 8, 3) radiance in a uniform world of one nit."""
    UsdLux.DomeLight.Define(looks.stage, "/Sky").CreateIntensityAttr(1.0)
    renderer = WarpRenderer(looks.stage, device="cpu")
    renderer.sync()
    film = renderer.new_film(8, 8)
    angle = np.radians(elevation)
    eye = (1e-3, -9 * np.cos(angle), 9 * np.sin(angle))
    view = scenes.view_from(eye, size=(8, 8), focal_length=focal_length)
    settings = PathSettings(bounces=bounces, denoise=False, **EXACT)
    renderer.accumulate(film, view, samples=samples, settings=settings)
    return film.radiance()


def image_of(normals: np.ndarray, tmp_path, elevation: float = 90.0, focal_length=300.0, **inputs) -> np.ndarray:
    """(8, 8, 3) radiance of a square with a normal map, (H, W, 3), that one bounce of light makes."""
    Image.fromarray(np.round((normals + 1) * 127.5).astype(np.uint8)).save(tmp_path / "normals.png")
    looks = looks_of(inputs)
    looks.connect("normal", looks.texture(tmp_path / "normals.png", sourceColorSpace="raw"))
    mesh = add_mesh(looks, 3 * CORNERS, np.arange(4)[None])
    uvs = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
    uvs.Set([(0, 0), (3, 0), (3, 3), (0, 3)])
    return drawn(looks, elevation, samples=512, bounces=1, focal_length=focal_length)


def image_of_bumps(elevation: float, **inputs) -> np.ndarray:
    """(8, 8, 3) radiance of what the map `waves` stands for, as a surface with those bumps in it."""
    count = 144
    x, y = np.meshgrid(*2 * [np.linspace(0, 6 * np.pi, count + 1)])
    height = 0.25 * np.cos(2 * x) - 0.4 / 3 * np.sin(3 * y)
    points = np.stack([x - 3 * np.pi, y - 3 * np.pi, height], -1).reshape(-1, 3) / np.pi
    corner = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).reshape(-1, 1)
    looks = looks_of(inputs)
    mesh = add_mesh(looks, points, corner + np.array([0, 1, count + 2, count + 1]))
    slopes = [0.5 * np.sin(2 * x), 0.4 * np.cos(3 * y), np.ones_like(x)]
    normals = np.stack(slopes, -1).reshape(-1, 3) / np.linalg.norm(slopes, axis=0).reshape(-1, 1)
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(normals.astype(np.float32)))
    return drawn(looks, elevation, samples=256, bounces=16, focal_length=94.0)


def tilted(degrees: float, turn: float = 0.0) -> np.ndarray:
    """(4, 4, 3) one tilt everywhere."""
    sine, cosine = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    turn = np.radians(turn)
    return np.broadcast_to([sine * np.cos(turn), sine * np.sin(turn), cosine], (4, 4, 3))


def waves() -> np.ndarray:
    """(64, 64, 3) bumps as a normal map has them, up to 32 degrees steep."""
    y, x = np.mgrid[0:64, 0:64] / 64 * 2 * np.pi
    normals = np.stack([0.5 * np.sin(2 * x), 0.4 * np.cos(3 * y), np.ones_like(x)], -1)
    return normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def seen_of_the_world(degrees: float, steps: int = 800) -> float:
    """What Chiang's terminator leaves a tilted matte surface of a uniform world, by quadrature."""
    share, turn = np.meshgrid((np.arange(steps) + 0.5) / steps, (np.arange(steps) + 0.5) / steps * 2 * np.pi)
    across, up = np.sqrt(share), np.sqrt(1 - share)
    tilt = np.radians(degrees)
    g = (across * np.cos(turn) * np.sin(tilt) + up * np.cos(tilt)) / (up * np.cos(tilt))
    return np.where(g >= 1, 1.0, np.where(g < 0, 0.0, g * (1 + g - g * g))).mean()


@pytest.mark.parametrize("turn", [0.0, 130.0])
@pytest.mark.parametrize("degrees", [5.0, 20.0, 40.0])
def test_a_tilted_diffuse_surface_gets_what_it_sees_and_its_color_of_the_rest(degrees, turn, tmp_path):
    color = np.array([0.9, 0.5, 0.1])
    seen = seen_of_the_world(degrees)
    expected = color * seen + color**2 * (1 - seen)
    found = image_of(tilted(degrees, turn), tmp_path, diffuseColor=Gf.Vec3f(*color), ior=1.0)
    np.testing.assert_allclose(found.mean((0, 1)), expected, rtol=0.02)


WHITE = Gf.Vec3f(1.0)


@pytest.mark.parametrize("elevation", [90.0, 50.0, 25.0])
@pytest.mark.parametrize(
    ("inputs", "worst"),
    [
        (dict(ior=1.0), 0.015),
        (dict(roughness=0.3), 0.03),
        (dict(metallic=1.0, roughness=0.2), 0.06),
        (dict(metallic=1.0, roughness=0.5), 0.05),
        (dict(metallic=1.0, roughness=0.9), 0.05),
    ],
)
def test_a_bumpy_white_surface_stays_white(inputs, worst, elevation, tmp_path):
    found = image_of(waves(), tmp_path, elevation, diffuseColor=WHITE, **inputs)
    assert found.mean() == pytest.approx(1.0, abs=worst)


@pytest.mark.parametrize("elevation", [90.0, 30.0])
@pytest.mark.parametrize(("inputs", "rtol"), [(dict(ior=1.0), 0.035), (dict(metallic=1.0, roughness=0.6), 0.05)])
def test_a_normal_map_is_as_bright_as_the_bumps_that_it_stands_for(inputs, rtol, elevation, tmp_path):
    color = Gf.Vec3f(0.95, 0.6, 0.3)
    bumps = image_of_bumps(elevation, diffuseColor=color, **inputs).mean((0, 1))
    # Three waves of the map side by side, of which the middle one fills the image, as of the bumps.
    found = image_of(waves(), tmp_path, elevation, 94.0, diffuseColor=color, **inputs).mean((0, 1))
    np.testing.assert_allclose(found, bumps, rtol=rtol)
