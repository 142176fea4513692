"""`isaacsim.core.utils.distance_metrics` against rotations of Gf."""

import numpy as np
import pytest
from pxr import Gf

from usdsdg.compat.isaacsim.core.utils.distance_metrics import (
    rotational_distance_angle,
    rotational_distance_identity_matrix_deviation,
    rotational_distance_single_axis,
    weighted_translational_distance,
)


def rotations(count, seed=0):
    """Return rotations of Gf whose angle is known, and matrices that multiply columns."""
    rng = np.random.default_rng(seed)
    turns = [Gf.Rotation(Gf.Vec3d(*rng.normal(size=3)), rng.uniform(0, 180)) for _ in range(count)]
    return turns, [np.array(Gf.Matrix3d(turn)).T for turn in turns]


def test_angles_are_those_between_rotations_of_gf():
    turns, matrices = rotations(40)
    for first, second in zip(range(0, 40, 2), range(1, 40, 2), strict=True):
        between = (turns[first].GetInverse() * turns[second]).GetAngle()
        expected = np.radians(min(between, 360.0 - between))
        assert rotational_distance_angle(matrices[first], matrices[second]) == pytest.approx(expected, abs=1e-9)
        # |I - R| of a turn by a is 2 √2 sin(a / 2).
        deviation = rotational_distance_identity_matrix_deviation(matrices[first], matrices[second])
        assert deviation == pytest.approx(2 * np.sqrt(2) * np.sin(expected / 2), abs=1e-9)


def test_the_angle_of_an_axis_is_that_between_where_it_is_turned_to():
    turns, matrices = rotations(20, seed=1)
    for turn, matrix in zip(turns, matrices, strict=True):
        axis = Gf.Vec3d(1, -2, 0.5)
        moved = turn.TransformDir(axis)
        expected = np.arccos(Gf.Dot(axis, moved) / axis.GetLength() ** 2)
        assert rotational_distance_single_axis(np.eye(3), matrix, [1, -2, 0.5]) == pytest.approx(expected)


def test_matrices_of_gf_and_poses_count_as_they_do_there():
    turn = Gf.Matrix4d(Gf.Rotation(Gf.Vec3d(0, 0, 1), 30), Gf.Vec3d(1, 2, 3))
    pose = np.array(turn).T  # whose translation is the last column
    assert rotational_distance_angle(turn, pose) == pytest.approx(0, abs=1e-7)
    assert rotational_distance_single_axis(turn, Gf.Matrix3d(1), (2, 0, 0)) == pytest.approx(np.pi / 6)
    assert weighted_translational_distance(turn, pose) == 0
    assert weighted_translational_distance(turn, (1, 2, 0)) == 3
    assert weighted_translational_distance(pose, [1, 0, 3], np.diag([1, 4, 1])) == 4


def test_other_shapes_are_told():
    with pytest.raises(ValueError, match=r"\(2,\).*expected \(3,\)"):
        weighted_translational_distance((1, 2), (1, 2, 3))
    with pytest.raises(ValueError, match=r"\(2, 2\).*expected \(3, 3\)"):
        rotational_distance_angle(np.eye(3), np.eye(2))
    with pytest.raises(ValueError, match="axis is zero"):
        rotational_distance_single_axis(np.eye(3), np.eye(3), (0, 0, 0))
