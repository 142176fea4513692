"""Pictures do not depend on where on the stage their things are, as far as 32-bit coordinates allow."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.render.images import radiance
from tests.render.scenes import cube, distant_light, material, moved, scene_of, sphere, square, view_from, white_dome


def things_at(place, size=1.0):
    """A ball and a turned box that stand on a slab, seen from near by; a unit of theirs is `size` units."""
    place = np.asarray(place, float)

    def at(x, y, z):
        return place + np.array([x, y, z]) * size

    turn = Rotation.from_euler("z", 30, degrees=True).as_matrix()
    placed = [
        (sphere(), moved(at(-1.2, 0, 1), scale=size), 0),
        (cube(), moved(at(1.2, 0, 1), scale=size, rotation=turn), 0),
        (cube(), moved(at(0, 0, -0.5), scale=np.array([5, 5, 0.5]) * size), 0),
    ]
    scene = scene_of(placed, dome=white_dome(), lights=[distant_light(3.0, (0.5, 0.4, -1.0))])
    view = view_from(at(0, -7, 4), at(0, 0, 0.7), size=(96, 64), clipping_range=(0.01, 1000.0))
    return scene, view


@pytest.mark.parametrize("place", [(1e4, -7e3, 2e3), (1e5, 7e4, 3e4)])
def test_nothing_darkens_far_from_the_origin(place):
    """Rays that started too far off one thing would begin inside the next one, where all is black."""
    near, far = (radiance(*things_at(where), samples=64).mean(-1) for where in ((0, 0, 0), place))
    assert near.min() > 0.02 * near.max(), "the scene itself has no black part"
    # A pixel at 1e5 units is drawn up to 0.01 units beside its place, so edges may differ, but not areas.
    wrong = np.abs(far - near) > 0.15 * near.max()
    assert wrong.mean() < 0.005
    assert far.mean() == pytest.approx(near.mean(), rel=0.01)


def test_small_things_keep_the_light_between_them():
    """Rounding along a surface moves no ray through it: a ball of 0.6 units stands on its slab without a black spot."""
    place = (1e5, 7e4, 3e4)
    near, far = (radiance(*things_at(where, 0.3), samples=64).mean(-1) for where in ((0, 0, 0), place))
    assert far.min() > 0.02 * near.max()
    assert (np.abs(far - near) > 0.15 * near.max()).mean() < 0.002


@pytest.mark.parametrize("elevation", [3.0, 40.0])
@pytest.mark.parametrize("place", [(0, 0, 0), (300, -200, 50), (1e4, -7e3, 2e3), (1e5, 9e4, 8e4), (-1e5, 3, -0.1)])
def test_nothing_shades_itself(place, elevation):
    """A lone square is lit all over by Lambert's cosine, however it is turned, stretched and far away."""
    rng = np.random.default_rng(0)
    for turn in Rotation.random(24, random_state=0).as_matrix():
        across, up = turn[:, 0], turn[:, 2]
        height = np.radians(elevation)
        light = distant_light(np.pi, -(np.cos(height) * across + np.sin(height) * up))
        scale = (*rng.uniform(3, 40, 2), 1)
        placed = [(square(), moved(place, scale=scale, rotation=turn), 0)]
        scene = scene_of(placed, lights=[light], materials=[material(specular=0.0)])
        eye = np.asarray(place) + 4 * up + rng.uniform(-1, 1) * across
        view = view_from(eye, np.asarray(place), size=(32, 32), up=turn[:, 1], focal_length=35.0)
        np.testing.assert_allclose(radiance(scene, view, samples=4, bounces=1), np.sin(height), rtol=2e-4)
