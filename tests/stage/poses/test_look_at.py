"""Rotations toward targets: -Z points there and +Y is as far up as can be."""

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from usdsdg.errors import DegenerateFrame
from usdsdg.stage.poses.look_at import look_at_rotations

POINTS = st.tuples(*[st.floats(-100, 100)] * 3).map(np.array)
NEARLY_UP = np.array((5.0, 5.0, 2.0))


@given(eye=POINTS, target=POINTS, up=POINTS, axis=st.sampled_from("YZ"))
@example(eye=np.array((0.0, 1.192092896e-07, 0.0)), target=NEARLY_UP, up=NEARLY_UP, axis="Y")
def test_minus_z_points_at_the_target(eye, target, up, axis):
    assume(np.linalg.norm(target - eye) > 1e-3)
    assume(np.linalg.norm(up) > 1e-3)
    (turn,) = look_at_rotations([eye], [target], up, stage_up_axis=axis)
    toward = (target - eye) / np.linalg.norm(target - eye)
    np.testing.assert_allclose(-turn[2], toward, atol=1e-9)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(turn) == pytest.approx(1)
    upwards = up / np.linalg.norm(up)
    if np.linalg.norm(np.cross(toward, upwards)) > 1e-6:
        assert turn[1] @ upwards > 0
        assert turn[0] @ upwards == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize(
    ("axis", "up", "shown"),
    [("Z", (0, 0, 1), (-1, 0, 0)), ("Y", (0, 1, 0), (0, 0, -1))],
)
def test_straight_down_has_a_fixed_top(axis, up, shown):
    (turn,) = look_at_rotations([np.array(up) * 5.0], [(0, 0, 0)], up, stage_up_axis=axis)
    np.testing.assert_allclose(turn[1], shown, atol=1e-12)


def test_up_along_the_axis_that_breaks_ties():
    turns = look_at_rotations([(1, 0, 0)], [(0, 0, 0)], (1, 0, 0), stage_up_axis="Z")
    np.testing.assert_allclose(turns @ turns.transpose(0, 2, 1), np.eye(3)[None], atol=1e-12)


def test_each_eye_may_have_its_own_up():
    turns = look_at_rotations([(5, 0, 0), (5, 0, 0)], (0, 0, 0), [(0, 0, 1), (0, 1, 0)])
    np.testing.assert_allclose(turns[:, 1], [(0, 0, 1), (0, 1, 0)], atol=1e-12)


def test_frames_that_do_not_exist_are_told():
    with pytest.raises(DegenerateFrame, match="own position"):
        look_at_rotations([(1, 2, 3)], [(1, 2, 3)], (0, 0, 1))
    with pytest.raises(DegenerateFrame, match="zero vector"):
        look_at_rotations([(1, 2, 3)], [(0, 0, 0)], (0, 0, 0))
