"""Scattering: in a uniformly white world nothing may shine brighter than the world, and what is lost is known."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import radiance
from usdsdg_render.scene.scene import WRAP_REPEAT, Texture


def furnace(view_size=(12, 12), samples=256, bounces=2, **values) -> np.ndarray:
    """A convex ball in a white world of one nit: the radiance of each pixel is the ball's directional albedo there."""
    scene = scenes.scene_of(
        [(scenes.sphere(rings=48), scenes.moved(), 0)],
        materials=[scenes.material(**values)],
        dome=scenes.white_dome(),
    )
    # The ball fills the image.
    view = scenes.view_from((0, -6, 0), size=view_size, focal_length=110.0)
    return radiance(scene, view, samples=samples, bounces=bounces)


def test_a_white_diffuse_ball_vanishes_in_a_white_world():
    # The dielectric lobe takes its share from the diffuse one, and what it reflects is white as well.
    image = furnace()
    np.testing.assert_allclose(image.mean(), 1.0, atol=0.01)
    assert image.max() < 1.06


@pytest.mark.parametrize("albedo", [0.2, 0.5, 0.8])
def test_a_gray_ball_without_specular_reflects_its_albedo(albedo):
    image = furnace(base_color=albedo, specular=0.0, roughness=1.0)
    np.testing.assert_allclose(image.mean(), albedo, rtol=0.005)


@pytest.mark.parametrize("roughness", [0.0, 0.15, 0.3, 0.5, 0.75, 1.0])
def test_a_white_metal_keeps_its_energy_at_every_roughness(roughness):
    image = furnace(base_color=1.0, metallic=1.0, roughness=roughness)
    # Compensation for multiple scattering comes from a table that is right to 3 % at its worst.
    np.testing.assert_allclose(image.mean(), 1.0, atol=0.015)
    assert image.max() < 1.05


@pytest.mark.parametrize("roughness", [0.1, 0.5, 1.0])
def test_a_clear_coat_adds_no_energy(roughness):
    white = furnace(clearcoat=1.0, clearcoat_roughness=roughness)
    np.testing.assert_allclose(white.mean(), 1.0, atol=0.03)
    black = furnace(base_color=0.0, specular=0.0, clearcoat=1.0, clearcoat_roughness=roughness)
    # All that is left is the reflection of the coat: 4 % head on, more toward the rim.
    assert black.min() > 0.01
    assert black[5:7, 5:7].mean() < 0.06


# Inputs, reflectance head on, and how much of that there is.
SMOOTH = {
    "plastic": (dict(base_color=0.0, specular=0.06), 0.06, 1.0),
    "metal": (dict(base_color=(0.9, 0.5, 0.1), metallic=1.0, metal_f90=1.0), (0.9, 0.5, 0.1), 1.0),
    "half a metal": (dict(base_color=0.0, specular=0.08, metallic=0.5), 0.08, 0.5),
    "coat": (dict(base_color=0.0, specular=0.0, clearcoat=1.0, clearcoat_roughness=0.05), 0.04, 1.0),
    "half a coat": (dict(base_color=0.0, specular=0.0, clearcoat=0.5, clearcoat_roughness=0.05), 0.04, 0.5),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_balls_mirror_what_schlick_says(name):
    values, f0, share = SMOOTH[name]
    ball = [(scenes.sphere(rings=96), scenes.moved(), 0)]
    view = scenes.view_from((0, -6, 0), size=(24, 24), focal_length=62.0)
    made = scenes.material(**{"roughness": 0.05, **values})
    image = radiance(scenes.scene_of(ball, materials=[made], dome=scenes.white_dome()), view, samples=512, bounces=2)
    # The cosine at which the ray of each pixel meets the ball.
    across = (np.mgrid[:24, :24] + 0.5 - 12) * 20.0 / 24 / 62.0
    off2 = (across**2).sum(0)
    off2 = 36 * off2 / (1 + off2)
    cosine = np.sqrt(np.maximum(1 - off2, 0.0))[..., None]
    expected = share * (np.array(f0) + (1 - np.array(f0)) * (1 - cosine) ** 5) * np.ones(3)
    seen = np.broadcast_to(cosine > 0.5, image.shape)  # nearer to the rim a pixel holds much
    np.testing.assert_allclose(image[seen], expected[seen], rtol=0.04, atol=0.003)
    assert image[10:14, 10:14].mean((0, 1)) == pytest.approx(expected[10:14, 10:14].mean((0, 1)), rel=0.02)


def test_a_coat_hides_from_the_layers_below_what_it_reflects():
    """White lamp light on metal under a coat: the metal gets, and gives, what the coat lets through."""
    coat = furnace(base_color=0.0, specular=0.0, clearcoat=1.0, clearcoat_roughness=0.4)
    metal = furnace(base_color=0.5, metallic=1.0, roughness=0.4)
    both = furnace(base_color=0.5, metallic=1.0, roughness=0.4, clearcoat=1.0, clearcoat_roughness=0.4)
    np.testing.assert_allclose(both, coat + (1 - coat) * metal, rtol=0.03)


# Near the edges of a box, light that is drawn from its walls is noisier.
@pytest.mark.parametrize(("shape", "tolerance"), [(scenes.cube, 0.02), (scenes.sphere, 0.002)])
@pytest.mark.parametrize(("albedo", "bounces"), [(0.5, 6), (0.8, 1), (0.8, 3)])
def test_a_closed_room_has_the_brightness_of_its_series(albedo, bounces, shape, tolerance):
    # Between emitting gray walls, radiance is E * (1 + a + a^2 ...): one term per surface met, and one more for the
    # light that the last one gets straight from the walls.
    scene = scenes.scene_of(
        [(shape(), scenes.moved(scale=3.0), 0)],
        materials=[scenes.material(base_color=albedo, specular=0.0, roughness=1.0, emission=1.0)],
    )
    view = scenes.view_from((0.5, -1, 0.2), size=(8, 8))
    image = radiance(scene, view, samples=2048, bounces=bounces)
    expected = sum(albedo**k for k in range(bounces + 1))
    np.testing.assert_allclose(image.mean(), expected, rtol=tolerance)


@pytest.mark.parametrize("bounces", [1, 3])
def test_an_emissive_room_of_white_metal_adds_up_its_bounces(bounces):
    # Shiny surfaces look for light by their lobe on the last bounce as well, and then end.
    walls = scenes.material(base_color=1.0, metallic=1.0, roughness=0.25, emission=1.0)
    scene = scenes.scene_of([(scenes.sphere(), scenes.moved(scale=3.0), 0)], materials=[walls])
    image = radiance(scene, scenes.view_from((0.5, -1, 0.2), size=(8, 8)), samples=512, bounces=bounces)
    np.testing.assert_allclose(image.mean(), bounces + 1.0, rtol=0.01)


@pytest.mark.parametrize(("albedo", "bounces"), [(0.5, 1), (0.9, 2), (0.9, 5)])
def test_an_integrating_sphere_has_the_brightness_of_its_series(albedo, bounces):
    # A lamp in the middle of a hollow ball gives every place the same, and so does every further bounce: lamps hide
    # nothing.
    lamp, size = scenes.sphere_light(500.0, (0, 0, 0), 0.05, visible=0), 2.0
    scene = scenes.scene_of(
        [(scenes.sphere(rings=96), scenes.moved(scale=size), 0)],
        materials=[scenes.material(base_color=albedo, specular=0.0, roughness=1.0)],
        lights=[lamp],
    )
    image = radiance(scene, scenes.view_from((0.7, -1.1, 0.4), (2, 1, 0), size=(8, 8)), samples=256, bounces=bounces)
    expected = 500.0 * (0.05 / size) ** 2 * sum(albedo**k for k in range(1, bounces + 1))
    np.testing.assert_allclose(image.mean(), expected, rtol=0.005)


def test_metals_tint_reflections_and_plastics_do_not():
    red = (1.0, 0.1, 0.1)
    metal = furnace(base_color=red, metallic=1.0, roughness=0.2).mean((0, 1))
    plastic = furnace(base_color=0.0, metallic=0.0, roughness=0.2).mean((0, 1))
    np.testing.assert_allclose(metal[1] / metal[0], 0.1, atol=0.08)
    np.testing.assert_allclose(plastic, plastic.mean(), rtol=0.02)


def test_a_mirror_shows_what_lies_behind_the_camera():
    ahead = scenes.sphere_light(50.0, (0.0, -9.0, 0.0), 1.0)
    mirror = scenes.material(base_color=1.0, metallic=1.0, roughness=0.0)
    wall = scenes.moved(scale=5.0, rotation=np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]))
    scene = scenes.scene_of([(scenes.square(), wall, 0)], materials=[mirror], lights=[ahead])
    image = radiance(scene, scenes.view_from((0, -4, 0), size=(9, 9)), samples=32)
    np.testing.assert_allclose(image[4, 4], 50.0, rtol=0.05)
    assert image[0, 0].max() < 1.0


@pytest.mark.parametrize("values", [dict(specular=0.0), dict(), dict(metallic=1.0, roughness=0.3), dict(clearcoat=1.0)])
def test_bumps_add_no_energy(values):
    """Normals that lean away from the surface may lose light below it, but make none."""
    lean = np.random.default_rng(0).normal(size=(16, 16, 2)) * 0.5
    normals = np.concatenate([lean, np.ones((16, 16, 1))], -1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    rgba = np.full((16, 16, 4), 255, np.uint8)
    rgba[..., :3] = (normals + 1) / 2 * 255
    ball = scenes.sphere(rings=48)
    x, y, z = ball.points.T
    uvs = np.stack([np.arctan2(y, x) / np.pi, np.arccos(np.clip(z, -1, 1))], -1)[ball.triangles]
    ball = scenes.prototype(ball.points, ball.triangles, normals=ball.normals, uvs=uvs)
    scene = scenes.scene_of(
        [(ball, scenes.moved(), 0)],
        materials=[scenes.material(normal_texture=0, **values)],
        textures=[Texture("bumps", rgba, False, WRAP_REPEAT, WRAP_REPEAT)],
        dome=scenes.white_dome(),
    )
    view = scenes.view_from((0, -6, 0), size=(12, 12), focal_length=110.0)
    image = radiance(scene, view, samples=512, bounces=3)
    assert 0.85 < image.mean() < 1.0
    assert image.max() < 1.02
