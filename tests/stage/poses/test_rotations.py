"""Batched rotation maths against Gf, which is USD's own."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Gf

from tests.stage.poses.euler import compose_euler
from usdsdg.stage.poses import rotations

ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
AXES = {"X": Gf.Vec3d.XAxis(), "Y": Gf.Vec3d.YAxis(), "Z": Gf.Vec3d.ZAxis()}

angles = st.tuples(*[st.floats(-720, 720, allow_nan=False)] * 3)
scales = st.tuples(*[st.floats(0.01, 100)] * 3)
offsets = st.tuples(*[st.floats(-1000, 1000)] * 3)


def gf_matrix(degrees, order="XYZ"):
    """The rotation of a USD rotate op out of Gf's turns about one axis; row vectors, so the first turn is left."""
    first, second, third = (Gf.Matrix3d(Gf.Rotation(AXES[axis], degrees["XYZ".index(axis)])) for axis in order)
    return np.array(first * second * third)


@pytest.mark.parametrize("order", ORDERS)
@given(degrees=angles)
@settings(max_examples=30)
def test_euler_matrices_are_those_of_gf(order, degrees):
    np.testing.assert_allclose(rotations.matrix_from_euler(degrees, order), gf_matrix(degrees, order), atol=1e-9)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("degrees", [90, -90, 180, 270, 45])
def test_turns_about_one_axis_leave_of_zeros_what_usd_leaves(axis, degrees):
    turn = degrees * np.eye(3)[axis]
    assert (rotations.matrix_from_euler(turn) == gf_matrix(turn)).all()


@pytest.mark.parametrize("order", ORDERS)
@given(degrees=angles)
@settings(max_examples=30)
def test_euler_angles_give_their_rotation_back(order, degrees):
    matrix = gf_matrix(degrees, order)
    again = rotations.euler_from_matrix(matrix, order)
    np.testing.assert_allclose(gf_matrix(again, order), matrix, atol=1e-7)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("middle", [90.0, -90.0])
def test_euler_angles_at_the_pole(order, middle):
    degrees = [0.0, 0.0, 0.0]
    for axis, angle in zip(order, (20.0, middle, 35.0)):
        degrees["XYZ".index(axis)] = angle
    matrix = gf_matrix(degrees, order)
    again = rotations.euler_from_matrix(matrix, order)
    assert again["XYZ".index(order[2])] == 0.0
    np.testing.assert_allclose(gf_matrix(again, order), matrix, atol=1e-7)


@given(degrees=angles)
def test_quaternions_are_those_of_gf(degrees):
    matrix = Gf.Matrix3d(*gf_matrix(degrees).ravel())
    expected = matrix.ExtractRotation().GetQuat()
    ours = rotations.quat_from_matrix(np.array(matrix))
    theirs = np.array([*expected.GetImaginary(), expected.GetReal()])
    assert abs(abs(ours @ theirs) - 1.0) < 1e-9
    assert ours[3] >= 0
    np.testing.assert_allclose(rotations.matrix_from_quat(ours), np.array(matrix), atol=1e-9)


@pytest.mark.parametrize("degrees", [(180, 0, 0), (0, 180, 0), (0, 0, 180), (180, 90, 0), (0, 0, 0)])
def test_quaternions_of_half_turns(degrees):
    matrix = gf_matrix(degrees)
    quat = rotations.quat_from_matrix(matrix)
    np.testing.assert_allclose(rotations.matrix_from_quat(quat), matrix, atol=1e-12)


def test_euler_xyz_of_a_known_quaternion():
    # A quarter turn about z.
    half = np.sqrt(0.5)
    np.testing.assert_allclose(rotations.euler_xyz_from_quat([0, 0, half, half]), [0, 0, 90], atol=1e-9)


@given(translate=offsets, degrees=angles, scale=scales, mirror=st.booleans())
def test_decompose_undoes_compose(translate, degrees, scale, mirror):
    scale = np.array(scale) * (-1 if mirror else 1)
    matrix = compose_euler(translate, degrees, scale)
    pose = rotations.decompose(matrix)
    np.testing.assert_allclose(pose.translate, translate)
    np.testing.assert_allclose(pose.scale, scale, rtol=1e-9)
    np.testing.assert_allclose(rotations.compose(*pose), matrix, atol=1e-7)


def test_decompose_of_one_mirrored_axis_composes_to_the_same_matrix():
    matrix = compose_euler((1, 2, 3), (10, 20, 30), (2, -3, 4))
    np.testing.assert_allclose(rotations.compose(*rotations.decompose(matrix)), matrix, atol=1e-12)


def test_decompose_of_a_sheared_matrix_is_the_nearest_rotation():
    sheared = np.eye(4)
    sheared[0, 1] = 0.3
    pose = rotations.decompose(sheared)
    # x and y each rotate by half of the shear angle toward each other.
    angle = np.degrees(np.arctan(0.3)) / 2
    np.testing.assert_allclose(rotations.euler_xyz_from_quat(pose.rotation), [0, 0, angle], atol=1e-9)


@pytest.mark.parametrize("scale", [(0, 1, 1), (1, 0, 2), (0, 0, 1), (0, 0, 0)])
def test_decompose_of_flattened_axes_is_still_a_rotation(scale):
    matrix = compose_euler((0, 0, 0), (10, 20, 30), scale)
    pose = rotations.decompose(matrix)
    np.testing.assert_allclose(np.abs(pose.scale), scale, atol=1e-12)
    axes = rotations.matrix_from_quat(pose.rotation)
    np.testing.assert_allclose(np.linalg.det(axes), 1.0)
    np.testing.assert_allclose(rotations.compose(*pose), matrix, atol=1e-12)


def test_batches_equal_one_at_a_time():
    generator = np.random.default_rng(7)
    translate, degrees = generator.normal(size=(5, 4, 3)), generator.uniform(-180, 180, (5, 4, 3))
    scale = generator.uniform(0.1, 3, (5, 4, 3))
    matrices = compose_euler(translate, degrees, scale)
    poses = rotations.decompose(matrices)
    assert matrices.shape == (5, 4, 4, 4)
    for index in np.ndindex(5, 4):
        one = compose_euler(translate[index], degrees[index], scale[index])
        np.testing.assert_array_equal(matrices[index], one)
        np.testing.assert_allclose(poses.rotation[index], rotations.decompose(one).rotation, atol=1e-12)


def test_compose_broadcasts():
    assert rotations.compose(np.zeros((6, 3))).shape == (6, 4, 4)
    assert compose_euler(degrees=np.zeros((2, 3))).shape == (2, 4, 4)


def test_one_quaternion_has_the_bits_of_one_of_many():
    rng = np.random.default_rng(3)
    matrices = rotations.matrix_from_quat(rng.normal(size=(500, 4)))
    matrices = np.concatenate([matrices, np.round(matrices)])
    many = rotations.quat_from_matrix(matrices)
    one = np.array([rotations.quat_from_matrix(matrix) for matrix in matrices])
    assert (one.view(np.int64) == many.view(np.int64)).all()


def test_one_matrix_has_the_bits_of_one_of_many():
    rng = np.random.default_rng(4)
    quats = rng.normal(size=(500, 4)) * 10.0 ** rng.uniform(-6, 6, size=(500, 1))
    quats = np.concatenate([quats, quats.astype(np.float32), np.eye(4)])
    one = np.array([rotations.matrix_from_quat(quat) for quat in quats])
    assert (one.view(np.int64) == rotations.matrix_from_quat(quats).view(np.int64)).all()


@given(degrees=angles, vector=offsets)
@settings(max_examples=30)
def test_vectors_are_rotated_as_gf_rotates_them(degrees, vector):
    turn = Gf.Rotation(AXES["Z"], degrees[2]) * Gf.Rotation(AXES["X"], degrees[0])
    quat = turn.GetQuat()
    found = rotations.rotated([[*quat.GetImaginary(), quat.GetReal()]] * 2, [vector] * 2)
    np.testing.assert_allclose(found, [turn.TransformDir(Gf.Vec3d(*vector))] * 2, atol=1e-9)
