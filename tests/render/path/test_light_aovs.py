"""Light AOVs add up to the image, and each holds the light that its name says."""

from __future__ import annotations

import numpy as np

from tests.render import scenes
from tests.render.images import EXACT, renderer_of
from usdsdg_render.scene.structs import LIGHT_RECT
from usdsdg_render.settings import PathSettings

VIEW = scenes.view_from((0, -4, 2), size=(24, 18))


def light_aovs_of(scene, *, view=VIEW, samples=16, **settings) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Mean radiance and its light AOVs."""
    renderer = renderer_of(scene)
    film = renderer.new_film(view.width, view.height)
    chosen = PathSettings(**{**EXACT, "light_aovs": True, **settings})
    renderer.accumulate(film, view, samples=samples, settings=chosen)
    return film.radiance(), film.light_aovs()


def still_life(*materials, dome=None, lights=()):
    """A floor and a ball on it."""
    placed = [(scenes.square(), scenes.moved(scale=10), 0), (scenes.sphere(), scenes.moved((0, 0, 1)), 1)]
    return scenes.scene_of(placed, materials=list(materials), dome=dome, lights=lights)


def test_light_aovs_and_emission_add_up_to_the_image():
    floor = scenes.material(base_color=0.5, roughness=0.3)
    glass = scenes.material(transmission=1.0, roughness=0.0)
    for ball in (scenes.material(metallic=1.0, roughness=0.05), glass, scenes.material(base_color=0.8)):
        scene = still_life(floor, ball, dome=scenes.white_dome(), lights=[scenes.distant_light(3.0)])
        view = scenes.view_from((0, -4, 3), (0, 0, 0.5), size=(24, 18))  # sees no sky
        picture, light_aovs = light_aovs_of(scene, view=view, bounces=5)
        np.testing.assert_allclose(sum(light_aovs.values()), picture, rtol=1e-3, atol=1e-5)
        assert all((aov >= -1e-6).all() for aov in light_aovs.values())


def test_light_aovs_do_not_change_the_image():
    scene = still_life(scenes.material(), scenes.material(metallic=1.0), dome=scenes.white_dome())
    with_aovs, _ = light_aovs_of(scene)
    without, nothing = light_aovs_of(scene, light_aovs=False)
    np.testing.assert_array_equal(with_aovs, without)
    assert nothing == {}


def test_one_bounce_off_rough_surfaces_is_direct_diffuse_alone():
    scene = still_life(*[scenes.material(specular=0.0)] * 2, lights=[scenes.distant_light(3.0)])
    view = scenes.view_from((0, -4, 3), (0, 0, 0.5), size=(24, 18))
    picture, light_aovs = light_aovs_of(scene, view=view, bounces=1)
    np.testing.assert_allclose(light_aovs["direct_diffuse"], picture, rtol=1e-5)
    assert all(not aov.any() for name, aov in light_aovs.items() if name != "direct_diffuse")


def test_indirect_diffuse_is_what_more_bounces_add():
    scene = still_life(*[scenes.material(specular=0.0, base_color=0.5)] * 2, dome=scenes.white_dome())
    view = scenes.view_from((0, -4, 3), (0, 0, 0.5), size=(24, 18))
    once, first = light_aovs_of(scene, view=view, bounces=1, samples=512)
    more, light_aovs = light_aovs_of(scene, view=view, bounces=4, samples=512)
    np.testing.assert_allclose(light_aovs["direct_diffuse"].mean(), first["direct_diffuse"].mean(), rtol=0.01)
    np.testing.assert_allclose(light_aovs["indirect_diffuse"].mean(), more.mean() - once.mean(), rtol=0.05)


def test_a_mirror_shows_lights_as_direct_and_surfaces_as_reflections():
    mirror = scenes.material(base_color=1.0, metallic=1.0, roughness=0.0)
    lamp = scenes.material(base_color=0.0, specular=0.0, emission=2.0)
    floor = [(scenes.square(), scenes.moved(scale=10), 0)]
    ceiling = (scenes.square(), scenes.moved((0, 0, 3), scale=10), 1)
    # Between both: it lights the ceiling, and its back toward the floor is dark.
    upwards = scenes.light(LIGHT_RECT, radiance=50.0, position=(0, 2, 0.5), z_axis=(0, 0, -1), y_axis=(0, -1, 0))
    view = scenes.view_from((0, -4, 2), size=(8, 6), focal_length=80.0)
    sky, light_aovs = light_aovs_of(scenes.scene_of(floor, materials=[mirror], dome=scenes.white_dome()), view=view)
    np.testing.assert_allclose(light_aovs["direct_specular"], sky, rtol=1e-4)
    shown, light_aovs = light_aovs_of(scenes.scene_of([*floor, ceiling], materials=[mirror, lamp]), view=view)
    np.testing.assert_allclose(light_aovs["direct_specular"], shown, rtol=1e-4)
    np.testing.assert_allclose(shown.mean(), 2.0, rtol=0.02)
    matt = scenes.material(base_color=0.5, specular=0.0)
    lit = scenes.scene_of([*floor, ceiling], materials=[mirror, matt], lights=[upwards])
    shown, light_aovs = light_aovs_of(lit, view=view)
    np.testing.assert_allclose(light_aovs["reflections"], shown, rtol=1e-4)
    assert shown.mean() > 0.1


def test_light_through_glass_is_refractions():
    glass = scenes.material(transmission=1.0, roughness=0.0, thin=1)
    lamp = scenes.material(base_color=0.0, specular=0.0, emission=2.0)
    upright = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    placed = [(scenes.square(), scenes.moved((0, y, 0), scale=10, rotation=upright), k) for k, y in enumerate((0, 3))]
    view = scenes.view_from((0, -4, 0), size=(8, 6), focal_length=80.0)
    picture, light_aovs = light_aovs_of(scenes.scene_of(placed, materials=[glass, lamp]), view=view, samples=64)
    np.testing.assert_allclose(light_aovs["refractions"], picture, rtol=1e-5)
    assert picture.mean() > 1.8
