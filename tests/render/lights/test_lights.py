"""Lights: the radiance of a diffuse surface under each kind matches its closed form."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import radiance
from tests.render.lights import light_oracle
from tests.sampled_cases import crossed
from usdsdg_render.scene.scene import Dome, EmissionProfile
from usdsdg_render.scene.structs import (
    LIGHT_CYLINDER,
    LIGHT_DISK,
    LIGHT_DISTANT,
    LIGHT_ELLIPSOID,
    LIGHT_RECT,
    LIGHT_SPHERE,
)

ALBEDO = 0.5
SAMPLES = 512


def diffuse_floor(**scene) -> scenes.Scene:
    """A large diffuse floor at z = 0."""
    floor = scenes.material(base_color=ALBEDO, specular=0.0, roughness=1.0)
    return scenes.scene_of([(scenes.square(), scenes.moved(scale=1000.0), 0)], materials=[floor], **scene)


def floor_irradiance(light: np.ndarray, *, seed=0, samples=SAMPLES, pattern: EmissionProfile | None = None) -> float:
    """Irradiance at the origin of the floor, seen from obliquely above in one pixel."""
    view = scenes.view_from((0.0, -6.0, 0.3), size=(1, 1), focal_length=50000.0)
    scene = diffuse_floor(lights=[light])
    if pattern is not None:
        scene.emission_profiles, scene.lights["emission_profile"] = [pattern], 0
    picture = radiance(scene, view, samples=samples, bounces=1, seed=seed)
    return float(picture.mean() * np.pi / ALBEDO)


def close(measured: float, expected: float) -> bool:
    # Noise of a few hundred low-discrepancy samples.
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
    """Form factor of a parallel rectangle centered above a point, by four corner rectangles (Howell, B-3)."""
    a, b = width / 2 / distance, height / 2 / distance
    corner = a / np.hypot(1, a) * np.arctan(b / np.hypot(1, a)) + b / np.hypot(1, b) * np.arctan(a / np.hypot(1, b))
    return 4 * corner / (2 * np.pi)


def test_rect_light():
    light = scenes.light(LIGHT_RECT, radiance=100.0, position=(0, 0, 1.5), width=2.0, height=1.0)
    assert close(floor_irradiance(light), np.pi * 100.0 * rectangle_form_factor(2.0, 1.0, 1.5))


def test_flat_lights_emit_from_one_side_only():
    for kind in (LIGHT_RECT, LIGHT_DISK):
        below = scenes.light(kind, radiance=100.0, position=(0, 0, 1.5), z_axis=(0, 0, -1), y_axis=(0, -1, 0))
        assert floor_irradiance(below) == 0.0


SHAPES = {
    "sphere": (LIGHT_SPHERE, dict(axes=(0.7, 0.7, 0.7)), dict(radius=0.7)),
    "ellipsoid": (LIGHT_ELLIPSOID, dict(axes=(0.3, 1.2, 0.6)), dict(radius=0.3, aspect=(4.0, 2.0))),
    "rect": (LIGHT_RECT, dict(width=2.0, height=0.8), dict(width=2.0, height=0.8)),
    "disk": (LIGHT_DISK, dict(axes=(0.5, 1.0)), dict(radius=0.5, aspect=(2.0, 1.0))),
    "cylinder": (LIGHT_CYLINDER, dict(axes=(0.3, 0.3), length=2.0), dict(radius=0.3, height=2.0)),
    "elliptic cylinder": (
        LIGHT_CYLINDER,
        dict(axes=(0.4, 0.1), length=2.0),
        dict(radius=0.4, aspect=(0.25, 1.0), height=2.0),
    ),
}
# (position, rotation about y, rotation about x): overhead, far, tilted, aside, crossing the horizon, below it upwards.
POSES = {
    "overhead": ((0.0, 0.0, 1.5), 0.0, 0.0),
    "far": ((3.0, -4.0, 9.0), 20.0, -30.0),
    "tilted": ((0.5, -0.4, 1.4), 35.0, 50.0),
    "low": ((2.0, 0.0, 0.9), 60.0, 0.0),
    "crossing": ((1.5, 0.6, 0.1), 75.0, 20.0),
    "mostly below": ((1.2, 0.0, -0.2), 90.0, 10.0),
}


def turned(y: float, x: float) -> np.ndarray:
    """Axes (rows) of a frame rotated about y, then about x [degrees]."""
    y, x = np.radians([y, x])
    about_y = np.array([[np.cos(y), 0, -np.sin(y)], [0, 1, 0], [np.sin(y), 0, np.cos(y)]])
    about_x = np.array([[1, 0, 0], [0, np.cos(x), np.sin(x)], [0, -np.sin(x), np.cos(x)]])
    return about_y @ about_x


@pytest.mark.parametrize(("pose", "shape"), crossed(POSES, SHAPES))
def test_every_shape_in_every_pose_matches_its_surface_integral(shape, pose):
    kind, size, values = SHAPES[shape]
    position, *turns = POSES[pose]
    frame = turned(*turns)
    axes = dict(zip(("x_axis", "y_axis", "z_axis"), frame, strict=True))
    light = scenes.light(kind, radiance=100.0, position=position, visible=0, **axes, **values)
    points, areas = light_oracle.patches("ellipsoid" if "here" in shape else shape.split()[-1], **size)
    expected = light_oracle.irradiance(points @ frame + position, areas @ frame, 100.0)
    measured = floor_irradiance(light, samples=8192)
    # With half of the light below the horizon half of the samples are wasted.
    np.testing.assert_allclose(measured, expected, rtol=0.015, atol=0.02)


@pytest.mark.parametrize("pose", POSES)
def test_rect_light_agrees_with_lamberts_polygon(pose):
    position, *turns = POSES[pose]
    frame = turned(*turns)
    corners = np.array([(x, y, 0) for x, y in ((-1, -0.4), (1, -0.4), (1, 0.4), (-1, 0.4))]) @ frame + position
    points, areas = light_oracle.patches("rect", width=2.0, height=0.8)
    by_surface = light_oracle.irradiance(points @ frame + position, areas @ frame, 1.0)
    lit = frame[2] @ position > 0
    np.testing.assert_allclose(by_surface, light_oracle.lambert_polygon(corners) * lit, rtol=3e-3)


@pytest.mark.parametrize(
    ("degrees", "tilt"), crossed([0.0, 0.53, 40.0, 180.0, 270.0, 360.0], [0.0, 60.0, 120.0, 180.0])
)
def test_distant_lights_of_every_angle_light_surfaces_of_every_tilt(degrees, tilt):
    cosine = np.cos(np.radians(degrees / 2))
    tilt = np.radians(tilt)
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    light = scenes.light(LIGHT_DISTANT, radiance=10.0, cos_angle=cosine, z_axis=axis, x_axis=(0, 1, 0), visible=0)
    up, turn = np.meshgrid((np.arange(1000) + 0.5) / 1000, (np.arange(2000) + 0.5) * 2 * np.pi / 2000)
    out = np.sqrt(1 - up**2)
    inside = out * np.cos(turn) * axis[0] + up * axis[2] > np.float32(cosine)
    expected = 10.0 * (inside * up).mean() * 2 * np.pi if degrees > 1 else 0.0
    if degrees <= 1:
        solid = 1.0 if degrees == 0 else 2 * np.pi * (1 - float(np.float32(cosine)))
        expected = 10.0 * max(axis[2], 0.0) * solid
    np.testing.assert_allclose(floor_irradiance(light, samples=4096), expected, rtol=0.02, atol=0.01)


def test_uniform_dome():
    view = scenes.view_from((0.0, -2.0, 2.0), size=(4, 4))
    picture = radiance(diffuse_floor(dome=scenes.white_dome(7.0)), view, samples=64, bounces=1)
    np.testing.assert_allclose(picture.mean(), 7.0 * ALBEDO, rtol=0.01)


def test_several_lights_add_up():
    lights = [
        scenes.sphere_light(80.0, (1, 0, 2), 0.3),
        scenes.distant_light(20.0),
        scenes.light(LIGHT_RECT, radiance=30.0, position=(-1, 0, 2)),
    ]
    view = scenes.view_from((0.0, -2.0, 2.0), size=(4, 4))
    together = radiance(diffuse_floor(lights=lights, dome=scenes.white_dome(2.0)), view, samples=1024, bounces=1)
    alone = [radiance(diffuse_floor(lights=[light]), view, samples=512, bounces=1) for light in lights]
    alone.append(radiance(diffuse_floor(dome=scenes.white_dome(2.0)), view, samples=512, bounces=1))
    np.testing.assert_allclose(together.mean(), sum(each.mean() for each in alone), rtol=0.01)


@pytest.mark.parametrize("roughness", [0.15, 0.3, 0.6])
def test_several_lights_add_up_on_glossy_floors(roughness):
    """BSDF sampling hits rarely selected lights: MIS weights must include the selection probability."""
    floor = scenes.material(base_color=0.3, specular=0.3, roughness=roughness)
    glow = scenes.material(base_color=0.0, specular=0.0, emission=400.0)
    ground = (scenes.square(), scenes.moved(scale=50.0), 0)
    # Aside, where it occludes part of the sky but no other light.
    plate = (scenes.square(), scenes.moved((-2.5, 0.5, 1.0), rotation=turned(70.0, 0.0).T), 1)
    lights = [
        scenes.sphere_light(40.0, (0.2, 2.0, 1.6), 1.0, visible=0),
        scenes.sphere_light(4e4, (3.0, 6.0, 9.0), 0.3, visible=0),
        scenes.light(LIGHT_RECT, radiance=300.0, position=(1.0, 2.0, 2.5), visible=0),
        scenes.light(LIGHT_DISTANT, radiance=300.0, cos_angle=np.cos(0.2), z_axis=(0.0, 0.6, 0.8), visible=0),
    ]
    view = scenes.view_from((0.0, -2.0, 1.5), size=(4, 4), focal_length=100.0)

    sky = scenes.white_dome(10.0)

    def seen(lights=(), dome=None, placed=(), samples=2048, glow=glow) -> float:
        scene = scenes.scene_of([ground, *placed], materials=[floor, glow], lights=lights, dome=dome)
        return float(radiance(scene, view, samples=samples, bounces=2).mean())

    dark = glow.copy()
    dark["emission"] = 0.0
    parts = [seen([light]) for light in lights] + [seen(placed=[plate]), seen(dome=sky, placed=[plate], glow=dark)]
    assert min(parts) > 0.02 * sum(parts)
    np.testing.assert_allclose(seen(lights, sky, [plate], samples=8192), sum(parts), rtol=0.01)


@pytest.mark.parametrize("what", ["sphere", "distant", "sky", "plate"])
def test_rarely_selected_lights_are_unbiased(what):
    """Beside a strong light that the surface does not scatter, BSDF sampling must compensate."""
    glow = scenes.material(base_color=0.0, specular=0.0, emission=40.0)
    plate = (scenes.square(), scenes.moved((0.2, 2.0, 1.6), scale=0.7, rotation=turned(0.0, 110.0).T), 1)
    kinds = {
        "sphere": dict(lights=[scenes.sphere_light(40.0, (0.2, 2.0, 1.6), 1.0, visible=0)]),
        "distant": dict(lights=[scenes.light(LIGHT_DISTANT, cos_angle=0.95, z_axis=(0.0, 0.8, 0.6), visible=0)]),
        "sky": dict(dome=scenes.white_dome(3.0)),
        "plate": dict(placed=[plate]),
    }
    silent = scenes.sphere_light(300.0, (0.0, 0.5, 6.0), 1.0, visible=0, diffuse=0.0, specular=0.0)
    floor = scenes.material(base_color=0.3, specular=0.3, roughness=0.3)
    view = scenes.view_from((0.0, -2.0, 1.5), size=(4, 4), focal_length=100.0)

    def seen(*more, lights=(), dome=None, placed=()) -> float:
        placed = [(scenes.square(), scenes.moved(scale=50.0), 0), *placed]
        scene = scenes.scene_of(placed, materials=[floor, glow], lights=[*lights, *more], dome=dome)
        return float(radiance(scene, view, samples=8192, bounces=2).mean())

    np.testing.assert_allclose(seen(silent, **kinds[what]), seen(**kinds[what]), rtol=0.01)


@pytest.mark.parametrize(("shape", "roughness"), crossed(SHAPES, [0.5, 0.7, 1.0]))
def test_light_sampling_alone_and_mis_agree(shape, roughness):
    """On its last bounce a rough surface uses light sampling only; with one more bounce both, with MIS."""
    kind, _, values = SHAPES[shape]
    frame = dict(zip(("x_axis", "y_axis", "z_axis"), turned(-20.0, 40.0), strict=True))
    light = scenes.light(kind, radiance=100.0, position=(0.2, 1.6, 1.3), visible=0, **frame, **values)
    floor = scenes.material(base_color=0.3, specular=0.3, roughness=roughness)
    scene = scenes.scene_of([(scenes.square(), scenes.moved(scale=50.0), 0)], materials=[floor], lights=[light])
    view = scenes.view_from((0.0, -2.0, 1.5), size=(4, 4), focal_length=100.0)
    alone = radiance(scene, view, samples=2048, bounces=1)
    both = radiance(scene, view, samples=2048, bounces=2)
    np.testing.assert_allclose(both.mean(), alone.mean(), rtol=0.01)


@pytest.mark.parametrize("roughness", [0.1, 0.3, 0.6])
def test_a_sphere_light_equals_an_emissive_ball(roughness):
    """The ball is found by BSDF sampling alone, the light also by light sampling."""
    floor = scenes.material(base_color=0.3, specular=0.3, roughness=roughness)
    glow = scenes.material(base_color=0.0, specular=0.0, emission=40.0)
    ground = (scenes.square(), scenes.moved(scale=50.0), 0)
    ball = (scenes.sphere(rings=96), scenes.moved((0.2, 2.0, 1.6), scale=1.2), 1)
    light = scenes.sphere_light(40.0, (0.2, 2.0, 1.6), 1.2)
    view = scenes.view_from((0.0, -2.0, 1.5), size=(4, 4), focal_length=100.0)
    by_light = radiance(
        scenes.scene_of([ground], materials=[floor], lights=[light]), view, samples=4096, bounces=2
    ).mean()
    by_ball = radiance(scenes.scene_of([ground, ball], materials=[floor, glow]), view, samples=16384, bounces=2).mean()
    np.testing.assert_allclose(by_light, by_ball, rtol=0.01)


def shaped(c: np.ndarray, *, cone=180.0, softness=0.0, focus=0.0, tint=0.0) -> np.ndarray:
    """UsdLuxShapingAPI's formulas, for the cosine of the angle off the light's axis."""
    off = np.degrees(np.arccos(np.clip(c, -1, 1)))
    t = np.clip((off - cone * (1 - softness)) / max(cone * softness, 1e-9), 0, 1)
    factor = np.abs(c) ** focus
    return (1 - t * t * (3 - 2 * t)) * (tint + (1 - tint) * factor)


@pytest.mark.parametrize(
    ("shaping", "shape", "turn"),
    crossed(
        [
            dict(cone=30.0),
            dict(cone=60.0, softness=0.5),
            dict(cone=75.0, softness=1.0),
            dict(focus=2.0),
            dict(focus=8.0, tint=0.3),
            dict(cone=70.0, softness=0.3, focus=1.5, tint=0.5),
        ],
        ["sphere", "rect", "cylinder"],
        [0.0, 40.0, 140.0],
    ),
)
def test_shaping_cuts_focuses_and_tints(shape, shaping, turn):
    kind, size, values = SHAPES[shape]
    position, frame = np.array([0.3, 0.2, 2.0]), turned(turn, 10.0)
    light = scenes.light(
        kind,
        radiance=100.0,
        position=position,
        visible=0,
        shaping_cos=np.cos(np.radians(shaping.get("cone", 180.0))),
        shaping_softness=shaping.get("softness", 0.0),
        shaping_focus=shaping.get("focus", 0.0),
        focus_tint=shaping.get("tint", 0.0),
        **dict(zip(("x_axis", "y_axis", "z_axis"), frame, strict=True)),
        **values,
    )
    points, areas = light_oracle.patches("ellipsoid" if "here" in shape else shape, **size)
    points = points @ frame + position
    cosine = (points @ frame[2]) / np.linalg.norm(points, axis=-1)
    expected = light_oracle.irradiance(points, areas @ frame, 100.0 * shaped(cosine, **shaping))
    np.testing.assert_allclose(floor_irradiance(light, samples=8192), expected, rtol=0.02, atol=0.1)


def test_spots_add_no_noise_outside_of_their_cones():
    """Eight spots light eight points of a floor; each point looks as if its spot were alone."""
    cone = dict(radius=0.05, shaping_cos=np.cos(np.radians(15.0)), visible=0)
    spots = [scenes.sphere_light(5000.0, (2.0 * k, 0.0, 3.0), **cone) for k in range(8)]
    view = scenes.view_from((0.0, -6.0, 0.3), size=(8, 8), focal_length=50000.0)
    alone, together = (radiance(diffuse_floor(lights=lights), view, samples=16) for lights in (spots[:1], spots))
    np.testing.assert_allclose(together.mean(), alone.mean(), rtol=0.01)
    assert together.std() < 1.5 * alone.std() + 1e-3 * alone.mean()


@pytest.mark.parametrize(("radius", "aside"), crossed([0.02, 0.5], [0.0, 0.7, 0.9, 1.2, 1.6]))
def test_spots_emit_up_to_the_edge_of_their_cone(radius, aside):
    """Selected by weight among others, a spot gives the same irradiance as alone, also at the edge of its cone."""
    light = scenes.sphere_light(1000.0, (aside, 0, 2.0), radius, shaping_cos=np.cos(np.radians(25.0)), visible=0)
    other = scenes.sphere_light(300.0, (0, 1.0, 3.0), 0.2, visible=0)
    points, areas = light_oracle.patches("ellipsoid", axes=3 * (radius,))
    points = points + np.array([aside, 0, 2.0])
    cosine = points[:, 2] / np.linalg.norm(points, axis=-1)
    expected = light_oracle.irradiance(points, areas, 1000.0 * (cosine > np.cos(np.radians(25.0))))
    view = scenes.view_from((0.0, -6.0, 0.3), size=(1, 1), focal_length=50000.0)
    both = radiance(diffuse_floor(lights=[light, other]), view, samples=16384, bounces=1).mean() * np.pi / ALBEDO
    np.testing.assert_allclose(both - floor_irradiance(other), expected, rtol=0.03, atol=0.3)


def test_an_ies_profile_follows_the_angles_of_the_scene():
    """Nadir is -z; horizontal angles count from -x toward -y."""
    profile = np.zeros((181, 360), np.float32)
    vertical, horizontal = np.arange(181)[:, None], np.arange(360)[None, :]
    profile[:] = (1 + vertical / 180) * (2 + np.cos(np.radians(horizontal - 50)))
    for off, turn in ((0.0, 0.0), (30.0, 0.0), (30.0, 50.0), (60.0, 140.0), (75.3, 301.7)):
        toward = np.sin(np.radians(off)) * np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn)), 0])
        # From the light to the origin along the direction of the angles: off -z, rotated from -x toward -y.
        leaving = np.array([-toward[0], -toward[1], -np.cos(np.radians(off))])
        light = scenes.sphere_light(1e4, -5 * leaving, 0.01, visible=0)
        plain = floor_irradiance(light)
        expected = (1 + off / 180) * (2 + np.cos(np.radians(turn - 50)) if off else 1)
        measured = floor_irradiance(light, pattern=EmissionProfile(ies=profile)) / plain
        if off:
            np.testing.assert_allclose(measured, expected, rtol=1e-3)
        even = EmissionProfile(ies=profile[:, :1])
        wanted = (1 + off / 180) * (2 + np.cos(np.radians(50)))
        np.testing.assert_allclose(floor_irradiance(light, pattern=even) / plain, wanted, rtol=1e-3)


def test_a_rect_light_texture_is_upright_on_its_emitting_side():
    """Seen from its emitting side with +y up, the first texel is at the top left."""
    picture = np.array([[(1, 0, 0), (0, 1, 0)], [(0, 0, 1), (1, 1, 1)]], np.float32)
    light = scenes.light(LIGHT_RECT, radiance=10.0, width=2.0, height=2.0)
    scene = scenes.scene_of([], lights=[light])
    scene.emission_profiles, scene.lights["emission_profile"] = [EmissionProfile(texture=picture)], 0
    view = scenes.view_from((0, 0, -5), up=(0, 1, 0), size=(41, 41), focal_length=50.0)
    seen = radiance(scene, view, samples=16)
    lit = seen.sum(-1) > 0
    rows, columns = np.flatnonzero(lit.any(1)), np.flatnonzero(lit.any(0))
    top, bottom, left, right = rows[1], rows[-2], columns[1], columns[-2]
    np.testing.assert_allclose(seen[top, left], (10, 0, 0), atol=1e-4)
    np.testing.assert_allclose(seen[top, right], (0, 10, 0), atol=1e-4)
    np.testing.assert_allclose(seen[bottom, left], (0, 0, 10), atol=1e-4)
    np.testing.assert_allclose(seen[bottom, right], (10, 10, 10), atol=1e-4)


def test_a_textured_light_matches_the_integral_of_its_texels():
    rng = np.random.default_rng(3)
    picture = rng.uniform(0, 2, (9, 15, 1)).astype(np.float32) ** 3 * np.ones(3, np.float32)
    light = scenes.light(LIGHT_RECT, radiance=100.0, position=(0.2, 0.1, 0.6), width=2.0, height=0.8, visible=0)
    points, areas = light_oracle.patches("rect", width=2.0, height=0.8)
    x, y = (0.5 - points[:, 0] / 2.0) * 15 - 0.5, (0.5 - points[:, 1] / 0.8) * 9 - 0.5
    x, y = np.clip(x, 0, 14), np.clip(y, 0, 8)
    left, top = np.minimum(x.astype(int), 13), np.minimum(y.astype(int), 7)
    fx, fy, gray = x - left, y - top, picture[..., 0]
    value = (gray[top, left] * (1 - fx) + gray[top, left + 1] * fx) * (1 - fy)
    value += (gray[top + 1, left] * (1 - fx) + gray[top + 1, left + 1] * fx) * fy
    expected = light_oracle.irradiance(points + np.array([0.2, 0.1, 0.6]), areas, 100.0 * value)
    measured = floor_irradiance(light, samples=16384, pattern=EmissionProfile(texture=picture))
    np.testing.assert_allclose(measured, expected, rtol=0.015)


def test_visible_lights_are_seen_and_hidden_ones_are_not():
    view = scenes.view_from((0, -5, 0), size=(9, 9))
    for visible in (0, 1):
        light = scenes.sphere_light(10.0, (0, 0, 0), 0.5, visible=visible)
        picture = radiance(scenes.scene_of([], lights=[light]), view, samples=16)
        np.testing.assert_allclose(picture[4, 4], 10.0 * visible, rtol=1e-5)
        assert picture[0, 0].max() == 0


def test_the_dome_follows_its_frame():
    # One bright texel; the camera looks at its center, and the floor is lit from there.
    height, width = 16, 32
    row, column = 5, 9
    pixels = np.zeros((height, width, 3), np.float32)
    pixels[row, column] = 300.0
    turn = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], np.float32)
    dome = Dome(pixels, turn)
    theta, phi = np.pi * (row + 0.5) / height, 2 * np.pi * (column + 0.5) / width
    in_dome = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    toward = np.linalg.inv(turn) @ in_dome
    scene = scenes.scene_of([], dome=dome)
    view = scenes.view_from((0, 0, 0), toward, size=(1, 1), focal_length=50000.0)
    np.testing.assert_allclose(radiance(scene, view, samples=16)[0, 0], 300.0, rtol=0.01)
    away = scenes.view_from((0, 0, 0), -toward, size=(1, 1), focal_length=50000.0)
    assert radiance(scene, away, samples=4).max() == 0.0
    # Reflection: a mirror ball at the half vector shows it.
    half = toward + np.array([0, 0, 1.0])
    half /= np.linalg.norm(half)
    side = np.cross(half, (1, 0, 0)) / np.linalg.norm(np.cross(half, (1, 0, 0)))
    facing = np.stack([side, np.cross(half, side), half], 1)
    matt = scenes.material(base_color=1.0, specular=0.0)
    lit = scenes.scene_of([(scenes.square(), scenes.moved(scale=9.0, rotation=facing), 0)], materials=[matt], dome=dome)
    above = scenes.view_from(5 * half, (0, 0, 0), size=(1, 1), focal_length=5000.0)
    solid_angle = (np.cos(np.pi * row / height) - np.cos(np.pi * (row + 1) / height)) * 2 * np.pi / width
    # Bilinear look-up spreads the texel over its neighbors but preserves its energy.
    expected = 300.0 * solid_angle * (half @ toward) / np.pi
    np.testing.assert_allclose(radiance(lit, above, samples=256, bounces=1).mean(), expected, rtol=0.06)


def test_background_interpolation_is_smooth_without_overshoot():
    """Linear along a row of linear values; no ringing or overshoot beside a lamp."""
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


def test_lights_scale_diffuse_and_specular_separately():
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


def test_domes_scale_diffuse_and_specular_separately():
    view = scenes.view_from((0.0, -2.0, 2.0), size=(2, 2), focal_length=100.0)

    def seen(**multipliers) -> float:
        floor = scenes.material(base_color=0.5, specular=0.3, roughness=0.4)
        dome = Dome(np.full((4, 8, 3), 5.0, np.float32), np.eye(3, dtype=np.float32), **multipliers)
        scene = scenes.scene_of([(scenes.square(), scenes.moved(scale=50.0), 0)], materials=[floor], dome=dome)
        return radiance(scene, view, samples=1024, bounces=2).mean()

    both, diffuse, specular = seen(), seen(specular=0.0), seen(diffuse=0.0)
    np.testing.assert_allclose(diffuse + specular, both, rtol=0.02)
    assert diffuse > 0.05 * both
    assert specular > 0.05 * both


def test_a_tinted_dome_equals_the_dome_of_the_tinted_texture():
    """Background and irradiance agree within the nine bits of a packed texel's largest channel."""
    rng = np.random.default_rng(2)
    pixels = rng.uniform(0.2, 1.0, (16, 32, 3))
    pixels = (pixels * rng.choice([1.0, 40.0], (16, 32, 1))).astype(np.float32)
    color, frame = (300.0, 20.0, 90.0), np.eye(3, dtype=np.float32)
    floor = [(scenes.square(), scenes.moved(scale=50.0), 0)]
    seen, lit = [], []
    for dome in (Dome(pixels, frame, color=color), Dome((pixels * color).astype(np.float32), frame)):
        up = scenes.view_from((0, 0, 1), (3, 1, 2), size=(24, 16), focal_length=10.0)
        down = scenes.view_from((0, -2, 4), size=(2, 2))
        matt = scenes.material(base_color=1.0, specular=0.0)
        seen.append(radiance(scenes.scene_of([], dome=dome), up, samples=4))
        lit.append(radiance(scenes.scene_of(floor, materials=[matt], dome=dome), down, samples=4096).mean((0, 1)))
    np.testing.assert_allclose(seen[0], seen[1], atol=40.0 * max(color) / 512)
    np.testing.assert_allclose(lit[0], lit[1], rtol=0.02)
