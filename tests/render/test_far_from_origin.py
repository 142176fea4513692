"""Images do not depend on the distance from the stage origin, as far as 32-bit coordinates allow."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.render.images import radiance
from tests.render.scenes import cube, distant_light, material, moved, scene_of, sphere, square, view_from, white_dome


def objects_at(position, size=1.0):
    """A sphere and a rotated box on a slab, scaled by `size`, and a camera near them."""
    position = np.asarray(position, float)

    def at(x, y, z):
        return position + np.array([x, y, z]) * size

    turn = Rotation.from_euler("z", 30, degrees=True).as_matrix()
    placed = [
        (sphere(), moved(at(-1.2, 0, 1), scale=size), 0),
        (cube(), moved(at(1.2, 0, 1), scale=size, rotation=turn), 0),
        (cube(), moved(at(0, 0, -0.5), scale=np.array([5, 5, 0.5]) * size), 0),
    ]
    scene = scene_of(placed, dome=white_dome(), lights=[distant_light(3.0, (0.5, 0.4, -1.0))])
    view = view_from(at(0, -7, 4), at(0, 0, 0.7), size=(96, 64), clipping_range=(0.01, 1000.0))
    return scene, view


@pytest.mark.parametrize("position", [(1e4, -7e3, 2e3), (1e5, 7e4, 3e4)])
def test_nothing_darkens_far_from_the_origin(position):
    """Too large a ray epsilon would start rays inside the adjacent object, which gives black pixels."""
    near, far = (radiance(*objects_at(where), samples=64).mean(-1) for where in ((0, 0, 0), position))
    assert near.min() > 0.02 * near.max(), "the scene itself has no black part"
    # A pixel at 1e5 units is off by up to 0.01 units, so edges may differ, but not areas.
    wrong = np.abs(far - near) > 0.15 * near.max()
    assert wrong.mean() < 0.005
    assert far.mean() == pytest.approx(near.mean(), rel=0.01)


def test_contacts_of_small_objects_stay_lit():
    """Rounding along a surface moves no ray through it: a sphere of 0.6 units on a slab has no black spot."""
    position = (1e5, 7e4, 3e4)
    near, far = (radiance(*objects_at(where, 0.3), samples=64).mean(-1) for where in ((0, 0, 0), position))
    assert far.min() > 0.02 * near.max()
    assert (np.abs(far - near) > 0.15 * near.max()).mean() < 0.002


@pytest.mark.parametrize("elevation", [3.0, 40.0])
@pytest.mark.parametrize("position", [(0, 0, 0), (300, -200, 50), (1e4, -7e3, 2e3), (1e5, 9e4, 8e4), (-1e5, 3, -0.1)])
def test_surfaces_do_not_shadow_themselves(position, elevation):
    """A single square is lit evenly by Lambert's cosine at any rotation, scale and distance."""
    rng = np.random.default_rng(0)
    for turn in Rotation.random(24, random_state=0).as_matrix():
        across, up = turn[:, 0], turn[:, 2]
        height = np.radians(elevation)
        light = distant_light(np.pi, -(np.cos(height) * across + np.sin(height) * up))
        scale = (*rng.uniform(3, 40, 2), 1)
        placed = [(square(), moved(position, scale=scale, rotation=turn), 0)]
        scene = scene_of(placed, lights=[light], materials=[material(specular=0.0)])
        eye = np.asarray(position) + 4 * up + rng.uniform(-1, 1) * across
        view = view_from(eye, np.asarray(position), size=(32, 32), up=turn[:, 1], focal_length=35.0)
        np.testing.assert_allclose(radiance(scene, view, samples=4, bounces=1), np.sin(height), rtol=2e-4)
