"""Light of an environment map matches sums over its directions, for diffuse and glossy surfaces."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.bvh.test_query import random_rotation
from tests.render.images import radiance
from tests.render.materials.test_scattering import hemisphere, scattered
from tests.sampled_cases import crossed
from usdsdg_render.scene.scene import Dome

DIRECTIONS, SOLID_ANGLE = hemisphere(700)
EYE = np.array([0.3, -3.0, 2.0])


def uneven_sky(seed: int) -> Dome:
    """Random texels in a random frame, without any symmetry."""
    rng = np.random.default_rng(seed)
    return Dome((rng.uniform(0, 2, (12, 20, 3)) ** 3).astype(np.float32), random_rotation(rng).astype(np.float32))


def seen_of(dome: Dome, directions: np.ndarray) -> np.ndarray:
    """Bilinear radiance of world directions, (N, 3), as in `scene.Dome`: u wraps around, v ends at the poles."""
    x, y, z = dome.dome_from_world.astype(float) @ directions.T
    height, width = dome.radiance.shape[:2]
    u, v = np.arctan2(y, x) / (2 * np.pi) % 1.0, np.arccos(np.clip(z, -1, 1)) / np.pi
    column, row = u * width - 0.5, v * height - 0.5
    left, top = np.floor(column).astype(int), np.floor(row).astype(int)
    total = np.zeros((len(directions), 3))
    for i in (0, 1):
        for j in (0, 1):
            weight = (1 - np.abs(column - left - i)) * (1 - np.abs(row - top - j))
            total += weight[:, None] * dome.radiance[np.clip(top + j, 0, height - 1), (left + i) % width]
    return total


def floor_seen(material: np.ndarray, dome: Dome, *, bounces: int) -> np.ndarray:
    floor = (scenes.square(), scenes.moved(scale=100.0), 0)
    view = scenes.view_from(EYE, size=(2, 2), focal_length=50000.0)
    scene = scenes.scene_of([floor], materials=[material], dome=dome)
    return radiance(scene, view, samples=4096, bounces=bounces).mean((0, 1))


@pytest.mark.parametrize("seed", range(4))
def test_a_diffuse_floor_receives_the_irradiance_of_the_dome(seed):
    dome = uneven_sky(seed)
    expected = (seen_of(dome, DIRECTIONS) * DIRECTIONS[:, 2:]).sum(0) * SOLID_ANGLE / np.pi
    matt = scenes.material(base_color=1.0, specular=0.0, roughness=1.0)
    np.testing.assert_allclose(floor_seen(matt, dome, bounces=1), expected, rtol=0.01)


@pytest.mark.parametrize(("bounces", "roughness", "metallic"), crossed([1, 2], [0.12, 0.3, 0.6, 1.0], [0.0, 1.0]))
def test_a_glossy_floor_reflects_the_dome_by_its_lobes(metallic, roughness, bounces):
    """Sharp lobes look up the texture and rough ones its grid; both use light sampling and BSDF sampling."""
    dome = uneven_sky(7)
    values = dict(base_color=(0.9, 0.5, 0.2), metallic=metallic, roughness=roughness)
    lobes = scattered(scenes.material(**values), EYE / np.linalg.norm(EYE), DIRECTIONS)
    expected = ((lobes.diffuse + lobes.specular) * seen_of(dome, DIRECTIONS)).sum(0) * SOLID_ANGLE
    np.testing.assert_allclose(floor_seen(scenes.material(**values), dome, bounces=bounces), expected, rtol=0.015)
