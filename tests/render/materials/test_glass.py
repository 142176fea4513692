"""Glass: what it mirrors and lets through, where light goes that it bends, and what lies behind it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import radiance


def glass(**values) -> np.ndarray:
    return scenes.material(**{"roughness": 0.0, "transmission": 1.0, "specular": 0.04, **values})


def facing(y: float, scale: float = 5.0) -> np.ndarray:
    """Where a square stands at y and faces -y."""
    return scenes.moved((0, y, 0), scale=scale, rotation=np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]))


@pytest.mark.parametrize("roughness", [0.0, 0.1])
@pytest.mark.parametrize("thin", [0, 1])
def test_a_clear_ball_vanishes_in_a_white_world(roughness, thin):
    # It absorbs nothing, so whatever it does with light, it shows a white that is as bright as the world.
    scene = scenes.scene_of(
        [(scenes.sphere(rings=48), scenes.moved(), 0)],
        materials=[glass(roughness=roughness, thin=thin)],
        dome=scenes.white_dome(),
    )
    image = radiance(scene, scenes.view_from((0, -6, 0), size=(12, 12)), samples=256, glass_bounces=24)
    np.testing.assert_allclose(image[3:9, 3:9].mean(), 1.0, atol=0.01)
    assert image.max() < 1.001


def test_a_pane_mirrors_at_both_of_its_faces():
    # Head on each face of glass of index 1.5 mirrors 4 %; to and fro between both that makes 2 * 0.04 / 1.04.
    scene = scenes.scene_of(
        [(scenes.square(), facing(0), 0), (scenes.square(), facing(3), 1)],
        materials=[glass(thin=1), scenes.material(base_color=0.0, specular=0.0, emission=10.0)],
    )
    view = scenes.view_from((0, -4, 0), size=(5, 5), focal_length=400.0)
    image = radiance(scene, view, samples=4096, bounces=2)
    np.testing.assert_allclose(image.mean(), 10.0 * (1 - 0.08 / 1.04), rtol=0.005)


def test_tinted_glass_colors_what_lies_behind_it():
    behind = scenes.material(base_color=0.0, specular=0.0, emission=1.0)
    scene = scenes.scene_of(
        [(scenes.square(), facing(0), 0), (scenes.square(), facing(3), 1)],
        materials=[glass(thin=1, base_color=(1.0, 0.5, 0.25)), behind],
    )
    view = scenes.view_from((0, -4, 0), size=(5, 5), focal_length=400.0)
    color = radiance(scene, view, samples=256, bounces=2).mean((0, 1))
    np.testing.assert_allclose(color / color[0], (1.0, 0.5, 0.25), rtol=1e-4)


def test_solid_glass_is_tinted_once():
    # Where light enters, however thick it is.
    behind = scenes.material(base_color=0.0, specular=0.0, emission=1.0)
    slab = scenes.moved((0, 1, 0), scale=(5, 0.5, 5))
    scene = scenes.scene_of(
        [(scenes.cube(), slab, 0), (scenes.square(), facing(3), 1)],
        materials=[glass(base_color=(1.0, 0.5, 0.25)), behind],
    )
    view = scenes.view_from((0, -4, 0), size=(5, 5), focal_length=400.0)
    color = radiance(scene, view, samples=4096, bounces=2).mean((0, 1))
    # 0.96 of the light crosses each face; what is mirrored at both inner ones and comes after all is a tint more.
    np.testing.assert_allclose(color, 0.96**2 * np.array([1.0, 0.5, 0.25]), rtol=0.01)


@pytest.mark.parametrize("ior", [1.2, 1.5, 2.0])
def test_a_slab_bends_rays_by_snells_law(ior):
    # A ray that comes down at 45 degrees through (0, 0, 1) leaves a slab of thickness 1 at x = tan(asin(sin 45 / n)).
    leaves = np.tan(np.arcsin(np.sin(np.pi / 4) / ior))
    floor = scenes.material(base_color=0.0, specular=0.0, emission=1.0)
    slab = scenes.moved((0, 0, 0.5005), scale=(20, 20, 0.4995))
    view = scenes.view_from((-5, 0, 6), (0, 0, 1), size=(1, 1), focal_length=20000.0)
    seen = []
    for edge in (leaves - 0.02, leaves + 0.02):
        lit = scenes.moved((edge - 10, 0, 0), scale=(10, 10, 1))  # covers x < edge
        scene = scenes.scene_of(
            [(scenes.cube(), slab, 0), (scenes.square(), lit, 1)], materials=[glass(ior=ior), floor]
        )
        seen.append(radiance(scene, view, samples=256).mean())
    assert seen[0] < 0.05
    assert seen[1] > 0.7


def test_total_reflection_beyond_the_critical_angle():
    # Seen from inside, under 60 degrees, the face of a block of index 1.5 is a perfect mirror.
    lamp = scenes.material(base_color=0.0, specular=0.0, emission=3.0)
    block = scenes.moved((0, 0, -5), scale=(50, 50, 5))  # its upper face lies in z = 0
    wall = scenes.moved((5, 0, -2), scale=5.0, rotation=np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]]))
    scene = scenes.scene_of([(scenes.cube(), block, 0), (scenes.square(), wall, 1)], materials=[glass(), lamp])
    view = scenes.view_from((-2 * np.sqrt(3), 0, -2), (0, 0, 0), size=(3, 3), focal_length=4000.0)
    np.testing.assert_allclose(radiance(scene, view, samples=64, bounces=3), 3.0, rtol=1e-4)


def test_glass_lets_light_through_to_what_stands_behind_it():
    # Shadows of glass are light: from rough surfaces light goes straight through it, once at each face.
    floor, pane = scenes.material(specular=0.0, base_color=0.5), glass(thin=1)
    placed = [(scenes.square(), scenes.moved(scale=3), 0), (scenes.square(), scenes.moved((0, 0, 1), scale=30), 1)]
    view = scenes.view_from((0, -3, 0.5), (0, 0, 0), size=(9, 9), focal_length=60.0)
    lit = [
        radiance(
            scenes.scene_of(some, materials=[floor, pane], lights=[scenes.distant_light(10.0)]),
            view, samples=64, bounces=1,
        ).mean()
        for some in (placed[:1], placed)
    ]  # fmt: skip
    np.testing.assert_allclose(lit[1] / lit[0], 0.96, rtol=0.01)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("thin", [0, 1, 2])
def test_partly_clear_things_neither_gain_nor_lose_energy(share, thin):
    # White, so that what does not go through is scattered: nothing is absorbed.
    scene = scenes.scene_of(
        [(scenes.sphere(rings=48), scenes.moved(), 0)],
        materials=[glass(roughness=0.0, transmission=share, thin=thin)],
        dome=scenes.white_dome(),
    )
    image = radiance(scene, scenes.view_from((0, -6, 0), size=(12, 12)), samples=256, bounces=16, glass_bounces=24)
    np.testing.assert_allclose(image[3:9, 3:9].mean(), 1.0, atol=0.01)


@pytest.mark.parametrize("roughness", [0.0, 0.5])
@pytest.mark.parametrize("opacity", [0.25, 0.75])
def test_a_clear_pane_neither_blurs_nor_tints(opacity, roughness):
    # What is left of the light behind: the share that is not opaque, without what both faces mirror head on.
    pane = glass(roughness=roughness, base_color=0.0, transmission=1.0 - opacity, thin=2)
    behind = scenes.material(base_color=0.0, specular=0.0, emission=(10.0, 5.0, 1.0))
    placed = [(scenes.square(), facing(0), 0), (scenes.square(), facing(3, 0.3), 1)]
    scene = scenes.scene_of(placed, materials=[pane, behind])
    view = scenes.view_from((0, -4, 0), size=(5, 5), focal_length=400.0)
    image = radiance(scene, view, samples=4096, bounces=2)
    mirrored = 0.08 / 1.04  # hardly less where facets are tilted
    expected = (1.0 - opacity) * (1 - mirrored) * np.array([10.0, 5.0, 1.0])
    np.testing.assert_allclose(image.mean((0, 1)), expected, rtol=0.03)
