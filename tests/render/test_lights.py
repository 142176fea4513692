"""Lights: the radiance of a matt surface under each kind is what its closed form says."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.pictures import radiance
from usdsdg_render.scene import LIGHT_CYLINDER, LIGHT_DISK, LIGHT_DISTANT, LIGHT_RECT, LIGHT_SPHERE, Dome

ALBEDO = 0.5
SAMPLES = 512


def matt_floor(**scene) -> scenes.Scene:
    """A large matt floor at z = 0."""
    floor = scenes.material(base_color=ALBEDO, specular=0.0, roughness=1.0)
    return scenes.scene_of([(scenes.square(), scenes.moved(scale=1000.0), 0)], materials=[floor], **scene)


def floor_irradiance(light: np.ndarray, *, seed=0) -> float:
    """Irradiance at the origin of the floor, seen from obliquely above in one pixel."""
    view = scenes.view_from((0.0, -6.0, 0.3), size=(1, 1), focal_length=50000.0)
    picture = radiance(matt_floor(lights=[light]), view, samples=SAMPLES, bounces=1, seed=seed)
    return float(picture.mean() * np.pi / ALBEDO)


def close(measured: float, expected: float) -> bool:
    # Noise of a few hundred well-spread samples.
    return abs(measured / expected - 1) < 0.01


def test_delta_distant_light():
    tilted = scenes.distant_light(100.0, direction=(0.0, 0.6, -0.8))
    assert close(floor_irradiance(tilted), 100.0 * 0.8)


def test_distant_light_with_a_cone():
    half = np.radians(10.0)
    light = scenes.light(LIGHT_DISTANT, radiance=1000.0, cos_angle=np.cos(half))
    assert close(floor_irradiance(light), 1000.0 * np.pi * np.sin(half) ** 2)


@pytest.mark.parametrize(("height", "radius"), [(3.0, 0.01), (3.0, 0.5), (3.0, 2.5)])
def test_sphere_light(height, radius):
    light = scenes.sphere_light(100.0, (0, 0, height), radius)
    assert close(floor_irradiance(light), np.pi * 100.0 * (radius / height) ** 2)


def test_disk_light():
    height, radius = 2.0, 1.0
    light = scenes.light(LIGHT_DISK, radiance=100.0, position=(0, 0, height), radius=radius)
    assert close(floor_irradiance(light), np.pi * 100.0 * radius**2 / (radius**2 + height**2))


def rectangle_form_factor(width: float, height: float, distance: float) -> float:
    """Of a parallel rectangle centred above a point: four corner rectangles (Howell, configuration B-3)."""
    a, b = width / 2 / distance, height / 2 / distance
    corner = a / np.hypot(1, a) * np.arctan(b / np.hypot(1, a)) + b / np.hypot(1, b) * np.arctan(a / np.hypot(1, b))
    return 4 * corner / (2 * np.pi)


def test_rect_light():
    light = scenes.light(LIGHT_RECT, radiance=100.0, position=(0, 0, 1.5), width=2.0, height=1.0)
    assert close(floor_irradiance(light), np.pi * 100.0 * rectangle_form_factor(2.0, 1.0, 1.5))


def test_flat_lights_shine_from_one_side_only():
    for kind in (LIGHT_RECT, LIGHT_DISK):
        below = scenes.light(kind, radiance=100.0, position=(0, 0, 1.5), z_axis=(0, 0, -1), y_axis=(0, -1, 0))
        assert floor_irradiance(below) == 0.0


def test_cylinder_light():
    # Reference by quadrature over the tube's surface that faces the point.
    height, radius, length = 1.5, 0.2, 2.0
    light = scenes.light(LIGHT_CYLINDER, radiance=100.0, position=(0, 0, height), radius=radius, height=length)
    x = (np.arange(400) + 0.5) / 400 * length - length / 2
    angle = (np.arange(800) + 0.5) / 800 * 2 * np.pi
    x, angle = np.meshgrid(x, angle)
    outward = np.stack([0 * x, np.cos(angle), np.sin(angle)], -1)
    at = np.stack([x, radius * np.cos(angle), height + radius * np.sin(angle)], -1)
    d2 = (at**2).sum(-1)
    cos_light = np.maximum(-(at * outward).sum(-1), 0) / np.sqrt(d2)
    patch = (length / 400) * (radius * 2 * np.pi / 800)
    expected = (100.0 * cos_light * at[..., 2] / np.sqrt(d2) / d2).sum() * patch
    assert close(floor_irradiance(light), expected)


def test_uniform_dome():
    view = scenes.view_from((0.0, -2.0, 2.0), size=(4, 4))
    picture = radiance(matt_floor(dome=scenes.white_dome(7.0)), view, samples=64, bounces=1)
    np.testing.assert_allclose(picture.mean(), 7.0 * ALBEDO, rtol=0.01)


def test_several_lights_add_up():
    lights = [
        scenes.sphere_light(80.0, (1, 0, 2), 0.3),
        scenes.distant_light(20.0),
        scenes.light(LIGHT_RECT, radiance=30.0, position=(-1, 0, 2)),
    ]
    view = scenes.view_from((0.0, -2.0, 2.0), size=(4, 4))
    together = radiance(matt_floor(lights=lights, dome=scenes.white_dome(2.0)), view, samples=1024, bounces=1)
    alone = [radiance(matt_floor(lights=[light]), view, samples=512, bounces=1) for light in lights]
    alone.append(radiance(matt_floor(dome=scenes.white_dome(2.0)), view, samples=512, bounces=1))
    np.testing.assert_allclose(together.mean(), sum(each.mean() for each in alone), rtol=0.01)


def test_glossy_surfaces_see_lights_the_same_by_either_way_of_sampling():
    # bounces=1 has only light sampling; one more surface-free segment adds the other half of MIS.
    floor = scenes.material(base_color=0.0, metallic=0.0, specular=0.5, roughness=0.3)
    light = scenes.sphere_light(100.0, (0, 2, 2), 0.7)
    scene = scenes.scene_of([(scenes.square(), scenes.moved(scale=50.0), 0)], materials=[floor], lights=[light])
    view = scenes.view_from((0.0, -2.0, 2.0), size=(4, 4), focal_length=100.0)
    few = radiance(scene, view, samples=2048, bounces=2)
    again = radiance(scene, view, samples=2048, bounces=2, seed=5)
    np.testing.assert_allclose(few.mean(), again.mean(), rtol=0.01)
    assert few.mean() > 1.0


@pytest.mark.parametrize(
    ("shaping", "seen"),
    [
        (dict(shaping_cos=np.cos(np.radians(20.0))), 0.0),
        (dict(shaping_cos=np.cos(np.radians(60.0))), 1.0),
        (dict(shaping_focus=2.0), 0.5),
    ],
)
def test_shaping_cuts_and_focuses(shaping, seen):
    # The light hangs so that the origin lies 45 degrees off its axis.
    light = scenes.sphere_light(100.0, (0, 3, 3), 0.1)
    shaped = scenes.sphere_light(100.0, (0, 3, 3), 0.1, **shaping)
    measured, plain = floor_irradiance(shaped), floor_irradiance(light)
    np.testing.assert_allclose(measured / plain, seen, atol=0.04)


def test_visible_lights_are_seen_and_hidden_ones_are_not():
    view = scenes.view_from((0, -5, 0), size=(9, 9))
    for visible in (0, 1):
        light = scenes.sphere_light(10.0, (0, 0, 0), 0.5, visible=visible)
        picture = radiance(scenes.scene_of([], lights=[light]), view, samples=16)
        np.testing.assert_allclose(picture[4, 4], 10.0 * visible, rtol=1e-5)
        assert picture[0, 0].max() == 0


def test_the_dome_is_where_its_frame_says():
    # One bright texel; the camera looks at its centre, and the floor is lit from there.
    height, width = 16, 32
    row, column = 5, 9
    pixels = np.zeros((height, width, 3), np.float32)
    pixels[row, column] = 300.0
    turn = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], np.float32)
    dome = Dome(pixels, turn)
    theta, phi = np.pi * (row + 0.5) / height, 2 * np.pi * (column + 0.5) / width
    in_dome = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    towards = np.linalg.inv(turn) @ in_dome
    scene = scenes.scene_of([], dome=dome)
    view = scenes.view_from((0, 0, 0), towards, size=(1, 1), focal_length=50000.0)
    np.testing.assert_allclose(radiance(scene, view, samples=16)[0, 0], 300.0, rtol=0.01)
    away = scenes.view_from((0, 0, 0), -towards, size=(1, 1), focal_length=50000.0)
    assert radiance(scene, away, samples=4).max() == 0.0
    # Light from it: a mirror ball facing halfway shows it.
    half = towards + np.array([0, 0, 1.0])
    half /= np.linalg.norm(half)
    side = np.cross(half, (1, 0, 0)) / np.linalg.norm(np.cross(half, (1, 0, 0)))
    facing = np.stack([side, np.cross(half, side), half], 1)
    matt = scenes.material(base_color=1.0, specular=0.0)
    lit = scenes.scene_of([(scenes.square(), scenes.moved(scale=9.0, rotation=facing), 0)], materials=[matt], dome=dome)
    above = scenes.view_from(5 * half, (0, 0, 0), size=(1, 1), focal_length=5000.0)
    solid_angle = (np.cos(np.pi * row / height) - np.cos(np.pi * (row + 1) / height)) * 2 * np.pi / width
    # Bilinear look-up spreads the texel over its neighbours but keeps its energy.
    expected = 300.0 * solid_angle * (half @ towards) / np.pi
    np.testing.assert_allclose(radiance(lit, above, samples=256, bounces=1).mean(), expected, rtol=0.06)


def test_the_sky_between_texels_is_smooth_and_stays_between_them():
    """Along a row that rises evenly it is the straight line; beside a lamp it neither rings nor overshoots."""
    height, width = 16, 32
    pixels = np.zeros((height, width, 3), np.float32)
    pixels[:, :, 0] = np.arange(width)
    pixels[:, 20, 1] = 900.0
    scene = scenes.scene_of([], dome=Dome(pixels, np.eye(3, dtype=np.float32)))

    def at(column: float) -> np.ndarray:
        phi = 2 * np.pi * (column + 0.5) / width
        view = scenes.view_from((0, 0, 0), (np.cos(phi), np.sin(phi), 0.0), size=(1, 1), focal_length=500000.0)
        return radiance(scene, view, samples=4)[0, 0]

    line = np.linspace(8.0, 12.0, 17)
    np.testing.assert_allclose([at(column)[0] for column in line], line, rtol=5e-3)
    beside = np.array([at(column)[1] for column in np.linspace(17.0, 23.0, 25)])
    assert beside.min() >= 0.0
    assert beside.max() == pytest.approx(900.0, rel=5e-3)
    rising = beside[:13]
    assert (np.diff(rising) >= -1e-3).all()


def test_lights_dim_their_diffuse_and_specular_parts():
    base = dict(radiance=100.0, position=(0, 2, 2), radius=0.7)
    view = scenes.view_from((0.0, -2.0, 2.0), size=(2, 2), focal_length=100.0)

    def seen(**multipliers) -> float:
        floor = scenes.material(base_color=0.5, specular=0.3, roughness=0.4)
        light = scenes.light(LIGHT_SPHERE, **base, **multipliers)
        scene = scenes.scene_of([(scenes.square(), scenes.moved(scale=50.0), 0)], materials=[floor], lights=[light])
        return radiance(scene, view, samples=2048, bounces=2).mean()

    both, diffuse, specular = seen(), seen(specular=0.0), seen(diffuse=0.0)
    np.testing.assert_allclose(diffuse + specular, both, rtol=0.02)
    assert diffuse > 0.05 * both
    assert specular > 0.05 * both
