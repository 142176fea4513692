"""`isaacsim.core.utils.numpy.rotations` and `isaacsim.core.utils.random`."""

from __future__ import annotations

import random

import numpy as np
import pytest
from pxr import Gf, UsdGeom
from scipy.spatial.transform import Rotation

from usdsdg.compat.isaacsim.core.utils import random as random_utils
from usdsdg.compat.isaacsim.core.utils import rotations as one
from usdsdg.compat.isaacsim.core.utils.numpy import rotations as many

DEGREES = np.array([(10, 20, 30), (-170, 80, 5), (0, 0, 180), (200, 10, -300), (0, 45, 0)], float)


def test_the_camera_tutorial_turns_its_camera_down():
    quat = many.euler_angles_to_quats(np.array([0, 90, 0]), degrees=True)
    np.testing.assert_allclose(quat, (np.sqrt(0.5), 0, np.sqrt(0.5), 0), atol=1e-12)


@pytest.mark.parametrize("extrinsic", [True, False])
@pytest.mark.parametrize("unit", ["degrees", "radians"])
def test_many_rotations_are_those_of_each(extrinsic, unit):
    angles = DEGREES if unit == "degrees" else np.radians(DEGREES)
    kind = {"degrees": unit == "degrees", "extrinsic": extrinsic}
    quats = many.euler_angles_to_quats(angles, **kind)
    assert quats.shape == (5, 4)
    for angle, quat in zip(angles, quats, strict=True):
        np.testing.assert_allclose(many.euler_angles_to_quats(angle, **kind), quat, atol=1e-12)
        matrix = one.euler_to_rot_matrix(angle, **kind)
        np.testing.assert_allclose(many.quats_to_rot_matrices(quat), matrix, atol=1e-12)
        again = many.euler_angles_to_quats(many.quats_to_euler_angles(quat, **kind), **kind)
        np.testing.assert_allclose(again * np.sign(again @ quat), quat, atol=1e-12)


def test_matrices_and_rotation_vectors_agree_with_scipy_and_undo_each_other():
    expected = Rotation.from_euler("xyz", DEGREES, degrees=True)
    quats = many.xyzw2wxyz(expected.as_quat())
    np.testing.assert_allclose(many.wxyz2xyzw(quats), expected.as_quat())
    np.testing.assert_allclose(many.quats_to_rot_matrices(quats), expected.as_matrix(), atol=1e-12)
    of_matrices = many.xyzw2wxyz(Rotation.from_matrix(expected.as_matrix()).as_quat())
    np.testing.assert_allclose(many.rot_matrices_to_quats(expected.as_matrix()), of_matrices)
    np.testing.assert_allclose(np.abs((of_matrices * quats).sum(1)), 1, atol=1e-12)
    vectors = many.quats_to_rotvecs(quats)
    np.testing.assert_allclose(vectors, expected.as_rotvec(), atol=1e-12)
    for given, degrees in ((vectors, False), (np.degrees(vectors), True)):
        again = many.rotvecs_to_quats(given, degrees=degrees)
        np.testing.assert_allclose(np.abs((again * quats).sum(1)), 1, atol=1e-12)
    np.testing.assert_allclose(many.rad2deg(many.deg2rad(DEGREES)), DEGREES)
    np.testing.assert_allclose(many.gf_quat_to_tensor(Gf.Quatf(0.5, 0.5, -0.5, 0.5)), (0.5, 0.5, -0.5, 0.5))


def test_drawn_poses_are_in_view_and_repeat_with_their_seed(stage):
    camera = UsdGeom.Camera.Define(stage, "/World/camera")
    UsdGeom.XformCommonAPI(camera).SetTranslate((1, 2, 3))
    UsdGeom.XformCommonAPI(camera).SetRotate((90, 0, 40))
    frame = UsdGeom.Xform.Define(stage, "/World/frame")
    UsdGeom.XformCommonAPI(frame).SetRotate((0, 0, 90))
    to_camera = np.linalg.inv(np.array(UsdGeom.XformCache().GetLocalToWorldTransform(camera.GetPrim())))
    fov_x, fov_y, fraction = 1.0, 0.6, 0.8

    def poses():
        random.seed(3)
        return [
            random_utils.get_random_world_pose_in_view(
                camera.GetPrim(), 2.0, 5.0, fov_x, fov_y, fraction, frame.GetPrim(), (-10, 0, 0), (10, 0, 0)
            )
            for _ in range(50)
        ]

    first = poses()
    for (position, quat), (again, quat_again) in zip(first, poses(), strict=True):
        x, y, z, _ = np.append(position, 1) @ to_camera
        assert -5 <= z <= -2
        assert abs(np.arctan2(x, -z)) <= fraction * fov_x / 2 + 1e-9
        assert abs(np.arctan2(y, -z)) <= fraction * fov_y / 2 + 1e-9
        # About the x axis of a frame that is turned by 90° about z, so about the world's y.
        turned = one.quat_to_rot_matrix(quat) @ np.array([1, 0, 0])
        np.testing.assert_allclose(turned, (0, 1, 0), atol=1e-9)
        np.testing.assert_array_equal((*position, *quat), (*again, *quat_again))
    assert len({tuple(position) for position, _ in first}) == 50
