"""Interpolated normals: they shade as if the surface were round, show no facets, and lose light to true shade only."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import radiance
from usdsdg_render.scene.scene import Texture

E = 3.0  # lux across the rays of the delta light


def leaning_square(degrees: float):
    """The flat square with normals that lean outward, along x at its left and right edge."""
    flat = scenes.square()
    lean = np.radians(degrees) * flat.points[flat.triangles][..., :1]
    normals = np.concatenate([np.sin(lean), 0 * lean, np.cos(lean)], -1)
    return scenes.prototype(flat.points, flat.triangles, normals=normals, uvs=flat.uvs)


def lit_from_the_right(mesh, elevation: float, textures=(), **values) -> np.ndarray:
    """(64, 64) radiance of a white diffuse mesh in the square [-0.9, 0.9]^2, seen from far above; rows are y."""
    light = np.array([np.cos(np.radians(elevation)), 0, np.sin(np.radians(elevation))])
    scene = scenes.scene_of(
        [(mesh, scenes.moved(), 0)],
        materials=[scenes.material(specular=0.0, **values)],
        lights=[scenes.distant_light(E, -light)],
        textures=textures,
    )
    view = scenes.view_from((0, 0, 100), size=(64, 64), projection_type="orthographic", horizontal_aperture=18.0)
    return radiance(scene, view, samples=64, bounces=1)[..., 0]


@pytest.mark.parametrize("degrees", [5, 20, 35])
@pytest.mark.parametrize("elevation", [15, 40, 75])
def test_irradiance_follows_the_interpolated_normal_however_far_it_leans(degrees, elevation):
    """Lambert's cosine with normals interpolated here; nothing hides the light, so nothing may fade it."""
    image = lit_from_the_right(leaning_square(degrees), elevation)
    x = (np.arange(64) + 0.5) / 32 - 1
    x = 0.9 * x[None, :]
    y = -x.T
    # Corners at x = -1 and 1 lean by -degrees and degrees; in each triangle normals are linear in x alone.
    lean = np.radians(degrees)
    normals = np.stack([x * np.sin(lean) + 0 * y, 0 * x + 0 * y, np.cos(lean) + 0 * (x + y)], -1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    toward = (np.cos(np.radians(elevation)), 0, np.sin(np.radians(elevation)))
    expected = E / np.pi * np.maximum(normals @ toward, 0)
    # A pixel is as wide as 1 degree of lean at most, and its mean over that is linear but at the terminator.
    np.testing.assert_allclose(image, expected, atol=0.004 * E)


def wavy(columns: int = 24, rows: int = 20):
    """A ball with ridges of three or four triangles each, smooth by area-weighted normals."""
    u, v = np.meshgrid(np.arange(columns) / columns * 2 * np.pi, np.linspace(0.02, np.pi - 0.02, rows), indexing="ij")
    radius = 1 + 0.08 * np.sin(11 * v) + 0.03 * np.sin(5 * u)
    points = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], -1) * radius[..., None]
    i, j = np.meshgrid(np.arange(columns), np.arange(rows - 1), indexing="ij")
    a, b = (i * rows + j).ravel(), ((i + 1) % columns * rows + j).ravel()
    triangles = np.concatenate([np.stack([a, a + 1, b + 1], -1), np.stack([a, b + 1, b], -1)])
    points = points.reshape(-1, 3)
    facing = np.cross(
        points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]]
    )
    normals = np.zeros_like(points)
    for k in range(3):
        np.add.at(normals, triangles[:, k], facing)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return scenes.prototype(points, triangles, normals=normals[triangles]), facing


def test_a_wavy_smooth_mesh_keeps_its_energy_in_a_white_world():
    """White paint that many bounces light is as bright as the world; only directions into the surface are lost."""
    mesh, facing = wavy()
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    assert (mesh.normals * facing[:, None]).sum(-1).min(1).mean() < 0.93, "normals stray from their triangles"
    scene = scenes.scene_of(
        [(mesh, scenes.moved(), 0)], materials=[scenes.material(specular=0.0)], dome=scenes.white_dome()
    )
    # The ball fills the image.
    view = scenes.view_from((0, -6, 0), size=(24, 24), focal_length=70.0)
    image = radiance(scene, view, samples=256, bounces=32)
    assert 0.995 < image.mean() < 1.002


@pytest.mark.parametrize("elevation", [10, 30, 60])
def test_a_normal_map_fades_what_the_surface_is_about_to_hide(elevation):
    """Chiang, Li and Burley, "Taming the Shadow Terminator" (2019): G + G^2 - G^3 of the cosines' ratio."""
    tilt = np.radians(35)
    texel = np.array([np.sin(tilt), 0, np.cos(tilt), 1]) * 0.5 + 0.5
    texels = np.tile((texel * 65535).round().astype(np.uint16), (2, 2, 1))
    dark = 1e-3  # nothing comes back from the bumps beside it
    image = lit_from_the_right(
        scenes.square(),
        elevation,
        [Texture("tilted", texels, False, 0, 0)],
        normal_texture=0,
        normal_scale=1.0,
        base_color=dark,
    )
    height = np.radians(elevation)
    cosine = np.cos(np.pi / 2 - height - tilt)
    ratio = min(1.0, np.sin(height) / (cosine * np.cos(tilt)))
    expected = dark * E / np.pi * cosine * (ratio + ratio**2 - ratio**3)
    np.testing.assert_allclose(image.mean(), expected, rtol=1e-3)
