"""Pictures do not depend on where on the stage their things are, as far as 32-bit coordinates allow."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.render.pictures import radiance
from tests.render.scenes import cube, distant_light, moved, scene_of, sphere, view_from, white_dome


def things_at(place):
    """A ball and a turned box that stand on a slab, seen from near by."""
    place = np.asarray(place, float)

    def at(x, y, z):
        return place + np.array([x, y, z])

    turn = Rotation.from_euler("z", 30, degrees=True).as_matrix()
    placed = [
        (sphere(), moved(at(-1.2, 0, 1)), 0),
        (cube(), moved(at(1.2, 0, 1), rotation=turn), 0),
        (cube(), moved(at(0, 0, -0.5), scale=(5, 5, 0.5)), 0),
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
