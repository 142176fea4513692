"""The camera that orbits: it looks at its target, whatever is done to it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from usdsdg.view.orbit import Orbit

Z_UP = np.array([[1.0, 0, 0], [0, -1.0, 0], [0, 0, 1.0]])
Y_UP = np.eye(3)[[0, 2, 1]]
numbers = st.floats(-3, 3)
moves = st.lists(
    st.one_of(
        st.tuples(st.just("turned"), numbers, numbers),
        st.tuples(st.just("moved"), numbers, numbers),
        st.tuples(st.just("zoomed"), st.floats(0.2, 5)),
    ),
    max_size=8,
)


@pytest.mark.parametrize("axes", [Z_UP, Y_UP])
@given(moves=moves)
def test_the_target_stays_in_the_middle_and_the_horizon_level(axes, moves):
    orbit = Orbit.looking(np.array([3.0, -4, 2]), np.array([1.0, 0, 0.5]), axes, size=4.0)
    for name, *values in moves:
        orbit = getattr(orbit, name)(*values)
    view = orbit.view(64, 48, 1.0)
    pixels, depth = view.project(np.array([orbit.target]))
    assert pixels[0] == pytest.approx([32, 24], abs=1e-6)
    assert depth[0] == pytest.approx(orbit.distance)
    right, up = view.local_to_world[0, :3], view.local_to_world[1, :3]
    assert right @ axes[2] == pytest.approx(0, abs=1e-9)
    assert up @ axes[2] > 0
    assert np.linalg.det(view.local_to_world[:3, :3]) == pytest.approx(1)


@pytest.mark.parametrize("axes", [Z_UP, Y_UP])
def test_it_passes_through_the_eye_that_it_is_made_from(axes):
    eye = np.array([3.0, -4.0, 2.0])
    orbit = Orbit.looking(eye, np.array([1.0, 0, 0.5]), axes, size=4.0)
    assert orbit.view(64, 48, 1.0).local_to_world[3, :3] == pytest.approx(eye)


def test_what_is_dragged_follows_the_pointer():
    orbit = Orbit.looking(np.array([0.0, -5.0, 0.0]), np.zeros(3), Z_UP, size=4.0)
    front = np.array([[0.0, -1.0, 0.0]])  # nearer than the target
    before = orbit.view(64, 48, 1.0).project(front)[0][0]
    # The page sends the pointer's way to the right as a turn to the left.
    after = orbit.turned(-0.05, 0.05).view(64, 48, 1.0).project(front)[0][0]
    assert after[0] > before[0]
    assert after[1] > before[1]
    moved = orbit.moved(0.25, 0.0).view(64, 48, 1.0).project(np.zeros((1, 3)))[0][0]
    assert moved[0] - 32 == pytest.approx(0.25 * 48, rel=0.01)


def test_poles_and_distances_have_limits():
    orbit = Orbit.looking(np.array([0.0, -5.0, 0.0]), np.zeros(3), Z_UP, size=4.0)
    assert abs(orbit.turned(0, 100).elevation) < math.pi / 2
    assert orbit.zoomed(1e-12).distance > 0
    assert math.isfinite(orbit.zoomed(1e12).view(64, 48, 1.0).clipping_range[1])


@pytest.mark.parametrize("size", [(64, 48), (48, 64), (160, 40)])
def test_four_by_three_of_the_scene_are_seen_in_every_shape(size):
    orbit = Orbit.looking(np.array([0.0, -5.0, 0.0]), np.zeros(3), Z_UP, size=4.0)
    half = orbit.distance * 36 / 50 / 2
    pixels, _ = orbit.view(*size, 1.0).project(np.array([[half * 0.99, 0, 0], [0, 0, half * 0.74]]))
    assert (pixels[0] < size[0]).all()
    assert pixels[0][0] > 0
    assert pixels[1][1] >= 0
