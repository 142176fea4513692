"""Emissive instances as area lights: irradiance matches surface integrals with either sampling technique."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import EXACT, radiance, renderer_of
from tests.render.lights import light_oracle
from usdsdg_render.lights.emissive_instances import MAX_EMISSIVE_LIGHTS, find_emissive_instances
from usdsdg_render.scene.scene import WRAP_CLAMP, Texture
from usdsdg_render.settings import PathSettings

ALBEDO = 0.5
FLOOR = scenes.material(base_color=ALBEDO, specular=0.0, roughness=1.0)
GROUND = (scenes.square(), scenes.moved(scale=1000.0), 0)
POSE = np.array([[0.8, 0.0, -0.6], [0.36, 0.8, 0.48], [0.48, -0.6, 0.64]]).T


def emissive(**values) -> np.ndarray:
    return scenes.material(**{"base_color": 0.0, "specular": 0.0, "emission": 40.0, **values})


def floor_irradiance(placed, materials, *, samples=2048, bounces=1, textures=()) -> float:
    view = scenes.view_from((0.0, -6.0, 0.3), size=(1, 1), focal_length=50000.0)
    scene = scenes.scene_of([GROUND, *placed], materials=[FLOOR, *materials], textures=textures)
    return float(radiance(scene, view, samples=samples, bounces=bounces).mean() * np.pi / ALBEDO)


def by_triangles(prototype, matrix, value) -> float:
    """Irradiance at the origin of two-sided emissive triangles, each by Lambert's polygon formula."""
    corners = prototype.points[prototype.triangles] @ matrix[:3, :3] + matrix[3, :3]
    return sum(v * light_oracle.lambert_polygon(each) for each, v in zip(corners, np.broadcast_to(value, len(corners))))


@pytest.mark.parametrize("bounces", [1, 2])
@pytest.mark.parametrize("scale", [0.05, 1.0, (0.3, 2.0, 1.0)])
def test_irradiance_of_an_emissive_plate_matches_lamberts_formula(scale, bounces):
    matrix = scenes.moved((0.4, 0.3, 2.5), scale=scale, rotation=POSE)
    expected = by_triangles(scenes.square(), matrix, 40.0)
    measured = floor_irradiance([(scenes.square(), matrix, 1)], [emissive()], bounces=bounces, samples=4096)
    np.testing.assert_allclose(measured, expected, rtol=0.01)


def test_both_sides_of_a_plate_emit():
    up = scenes.moved((0, 0, 2.0))
    down = scenes.moved((0, 0, 2.0), rotation=np.diag([1.0, -1.0, -1.0]))
    a, b = (floor_irradiance([(scenes.square(), matrix, 1)], [emissive()]) for matrix in (up, down))
    np.testing.assert_allclose(a, b, rtol=0.01)
    assert a > 10


@pytest.mark.parametrize("bounces", [1, 2])
def test_irradiance_of_an_emissive_ball_matches_a_sphere(bounces):
    # The polyhedron of 96 rings lies inside the sphere by less than a thousandth of its area.
    matrix = scenes.moved((0.5, -0.3, 3.0), scale=0.8)
    measured = floor_irradiance([(scenes.sphere(rings=96), matrix, 1)], [emissive()], bounces=bounces, samples=4096)
    distance = np.linalg.norm((0.5, -0.3, 3.0))
    np.testing.assert_allclose(measured, np.pi * 40.0 * (0.8 / distance) ** 2 * 3.0 / distance, rtol=0.01)


def test_subsets_of_a_mesh_emit_by_their_own_materials():
    two = scenes.prototype(
        [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]], slots=[0, 1], name="/two"
    )
    matrix = scenes.moved((0.4, 0.3, 2.5), rotation=POSE)
    expected = by_triangles(two, matrix, [40.0, 7.0])
    measured = floor_irradiance([(two, matrix, 1)], [emissive(), emissive(emission=7.0)], samples=4096)
    np.testing.assert_allclose(measured, expected, rtol=0.01)
    dark = floor_irradiance([(two, matrix, 1)], [emissive(), emissive(emission=0.0)], samples=4096)
    np.testing.assert_allclose(dark, by_triangles(two, matrix, [40.0, 0.0]), rtol=0.01)


def test_textures_and_opacity_scale_emission():
    gray = Texture("gray", np.full((2, 2, 4), 128, np.uint8), False, 0, 0)
    matrix = scenes.moved((0.4, 0.3, 2.5), rotation=POSE)
    whole = by_triangles(scenes.square(), matrix, 40.0)
    for values in (dict(emission_texture=0), dict(opacity=128 / 255)):
        for bounces in (1, 2):
            placed = [(scenes.square(), matrix, 1)]
            measured = floor_irradiance(placed, [emissive(**values)], bounces=bounces, samples=8192, textures=[gray])
            np.testing.assert_allclose(measured, whole * 128 / 255, rtol=0.015)


@pytest.mark.parametrize("bounces", [1, 2])
@pytest.mark.parametrize("what", ["emission", "opacity"])
def test_emission_textures_and_holes_follow_texture_coordinates(what, bounces):
    rng = np.random.default_rng(4)
    texels = np.full((5, 7, 4), 255, np.uint8)
    texels[..., :3] = texels[..., 3:] = rng.uniform(0, 1, (5, 7, 1)) ** 3 * 255
    texture = Texture("uneven", texels, False, WRAP_CLAMP, WRAP_CLAMP)
    values = dict(opacity_texture=0, opacity_channel=3) if what == "opacity" else dict(emission_texture=0)
    # Close, so that it matters which corner is bright.
    matrix = scenes.moved((0.3, 0.2, 0.8), scale=(1.0, 0.8, 1.0), rotation=POSE)
    points, areas = light_oracle.patches("rect", width=2.0, height=2.0)
    column = np.clip((points[:, 0] + 1) / 2 * 7 - 0.5, 0, 6)
    row = np.clip((1 - points[:, 1]) / 2 * 5 - 0.5, 0, 4)
    left, top = np.minimum(column.astype(int), 5), np.minimum(row.astype(int), 3)
    fx, fy, gray = column - left, row - top, texels[..., 0] / 255
    value = (gray[top, left] * (1 - fx) + gray[top, left + 1] * fx) * (1 - fy)
    value += (gray[top + 1, left] * (1 - fx) + gray[top + 1, left + 1] * fx) * fy
    points = points @ matrix[:3, :3] + matrix[3, :3]
    across = 0.8 * areas @ (POSE.T)
    expected = max(light_oracle.irradiance(points, side * across, 40.0 * value) for side in (1, -1))
    placed = [(scenes.square(), matrix, 1)]
    measured = floor_irradiance(placed, [emissive(**values)], bounces=bounces, samples=16384, textures=[texture])
    np.testing.assert_allclose(measured, expected, rtol=0.015)


@pytest.mark.parametrize("roughness", [0.05, 0.3, 0.7])
def test_glossy_reflections_do_not_depend_on_the_sampling_technique(roughness):
    """Instances beyond the maximum number of sampled lights contribute through BSDF sampling alone."""
    floor = scenes.material(base_color=0.3, specular=0.3, roughness=roughness)
    plate = (scenes.square(), scenes.moved((0.0, 2.0, 1.6), scale=1.2, rotation=POSE), 1)
    view = scenes.view_from((0.0, -2.0, 1.5), size=(4, 4), focal_length=100.0)
    # Far below the floor, not visible.
    crowd = [(scenes.square(), scenes.moved((k, 0, -900.0), scale=40.0), 1) for k in range(MAX_EMISSIVE_LIGHTS)]

    def seen(placed, samples):
        scene = scenes.scene_of(
            [(scenes.square(), scenes.moved(scale=50.0), 0), *placed], materials=[floor, emissive()]
        )
        picture = radiance(scene, view, samples=samples, bounces=2).mean()
        return picture, any(each.instance == 1 for each in find_emissive_instances(scene))

    sampled, known = seen([plate], 4096)
    followed, unknown = seen([plate, *crowd], 16384)
    assert known
    assert not unknown
    np.testing.assert_allclose(sampled, followed, rtol=0.015)


def test_only_bright_instances_are_sampled_as_lights():
    lamps = [(scenes.square(), scenes.moved((k, 0, 3.0), scale=size), 1) for k, size in enumerate((1.0, 0.01, 2.0))]
    scene = scenes.scene_of([GROUND, *lamps], materials=[FLOOR, emissive()])
    found = find_emissive_instances(scene)
    assert [each.instance for each in found] == [3, 1]
    # A square of side 2 and of side 4, of 40 nits.
    np.testing.assert_allclose([each.luminance_area for each in found], [40 * 16.0, 40 * 4.0])
    np.testing.assert_allclose(found[1].center, (0, 0, 3.0))
    assert found[1].radius == pytest.approx(np.sqrt(2))


def test_a_small_emissive_lamp_has_little_noise():
    """With BSDF sampling alone a lamp of 5 cm at 2 m would leave nearly all of 16 samples dark."""
    matrix = scenes.moved((0, 0, 2.0), scale=0.05)
    scene = scenes.scene_of([GROUND, (scenes.sphere(rings=16), matrix, 1)], materials=[FLOOR, emissive(emission=4e4)])
    view = scenes.view_from((0.0, -6.0, 0.3), size=(16, 16), focal_length=50000.0)
    picture = radiance(scene, view, samples=16, bounces=2)[..., 0]
    assert picture.std() < 0.25 * picture.mean()


def test_emissive_instances_follow_changes():
    plate = scenes.square()
    scene = scenes.scene_of([GROUND, (plate, scenes.moved((0, 0, 2.0)), 1)], materials=[FLOOR, emissive()])
    renderer = renderer_of(scene)
    view = scenes.view_from((0.0, -6.0, 0.3), size=(1, 1), focal_length=50000.0)

    def measured() -> float:
        renderer.sync()
        film = renderer.new_film(1, 1)
        renderer.accumulate(film, view, samples=2048, settings=PathSettings(bounces=1, **EXACT))
        return float(film.radiance().mean() * np.pi / ALBEDO)

    np.testing.assert_allclose(measured(), by_triangles(plate, scenes.moved((0, 0, 2.0)), 40.0), rtol=0.01)
    scene.instances.local_to_world[1] = scenes.moved((0, 0.5, 4.0), scale=2.0)
    scene.touch("transforms")
    expected = by_triangles(plate, scenes.moved((0, 0.5, 4.0), scale=2.0), 40.0)
    np.testing.assert_allclose(measured(), expected, rtol=0.01)
    scene.materials["emission"][1] = 10.0
    scene.touch("materials")
    np.testing.assert_allclose(measured(), expected / 4, rtol=0.01)
    scene.materials["emission"][1] = 0.0
    scene.touch("materials")
    with pytest.warns(UserWarning, match="no light"):
        assert measured() == 0.0
