"""Calibrations in the forms of OpenCV, ROS and Kalibr against OpenCV's formulas; rigs against chains by hand."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from pxr import UsdGeom

import usdsdg as rep
from tests.calibration.opencv_twin import projected
from usdsdg.calibration.files import read_calibration, read_rig
from usdsdg.errors import ArgumentError, ConfigError
from usdsdg.session.stage_context import current_stage, new_stage
from usdsdg.stage.cameras.camera_view import read_camera

MATRIX = [[612.5, 0.0, 330.25], [0.0, 608.75, 231.5], [0.0, 0.0, 1.0]]
RADTAN = [-0.21, 0.06, 0.0011, -0.0007]
RATIONAL = [0.3, -0.05, 0.0004, 0.0002, 0.01, 0.45, -0.02, 0.004]
PRISM = [*RATIONAL, 0.001, -0.0004, 0.0007, 0.0002]
FISHEYE = [-0.02, 0.011, -0.004, 0.0009]


def opencv(distortion, *, fisheye=False, name=("camera_matrix", "distortion_coefficients")) -> str:
    def matrix(rows):
        data = ", ".join(f"{each:.16e}" for row in rows for each in row)
        return f"!!opencv-matrix\n   rows: {len(rows)}\n   cols: {len(rows[0])}\n   dt: d\n   data: [ {data} ]"

    flag = "fisheye_model: 1\n" if fisheye else ""
    return (
        f'%YAML:1.0\n---\ncalibration_time: "Tue 03 Feb 2026"\nimage_width: 640\nimage_height: 480\n{flag}'
        f"{name[0]}: {matrix(MATRIX)}\n{name[1]}: {matrix([[each] for each in distortion])}\n"
        "avg_reprojection_error: 2.1e-01\n"
    )


def ros(distortion, model="plumb_bob") -> str:
    rows = {"rows": 3, "cols": 3, "data": [each for row in MATRIX for each in row]}
    values = {
        "image_width": 640, "image_height": 480, "camera_name": "narrow_stereo", "camera_matrix": rows,
        "distortion_model": model, "distortion_coefficients": {"rows": 1, "cols": len(distortion), "data": distortion},
        "rectification_matrix": {"rows": 3, "cols": 3, "data": [1, 0, 0, 0, 1, 0, 0, 0, 1]},
    }  # fmt: skip
    return yaml.safe_dump(values)


def camera_info(distortion, model="rational_polynomial") -> str:
    """A message as `ros2 topic echo --once` prints it."""
    matrix = [each for row in MATRIX for each in row]
    return (
        yaml.safe_dump({"height": 480, "width": 640, "distortion_model": model, "d": distortion, "k": matrix}) + "---\n"
    )


def kalibr(distortion, model="radtan", **more) -> str:
    camera = {
        "camera_model": "pinhole", "intrinsics": [612.5, 608.75, 330.25, 231.5], "distortion_model": model,
        "distortion_coeffs": distortion, "resolution": [640, 480], "rostopic": "/cam0/image_raw",
    }  # fmt: skip
    return yaml.safe_dump({"cam0": {**camera, **more}})


CASES = {
    "OpenCV, 4": (opencv(RADTAN), RADTAN, False),
    "OpenCV, 5": (opencv([*RADTAN, 0.02]), [*RADTAN, 0.02], False),
    "OpenCV, 8": (opencv(RATIONAL), RATIONAL, False),
    "OpenCV, 12": (opencv(PRISM), PRISM, False),
    "OpenCV, 14 without tilt": (opencv([*PRISM, 0.0, 0.0]), PRISM, False),
    "OpenCV fisheye": (opencv(FISHEYE, fisheye=True), FISHEYE, True),
    "OpenCV's names in Python": (opencv(RADTAN, name=("cameraMatrix", "distCoeffs")), RADTAN, False),
    "ROS plumb_bob": (ros([*RADTAN, 0.0]), RADTAN, False),
    "ROS equidistant": (ros(FISHEYE, "equidistant"), FISHEYE, True),
    "ROS message": (camera_info(RATIONAL), RATIONAL, False),
    "Kalibr radtan": (kalibr(RADTAN), RADTAN, False),
    "Kalibr equidistant": (kalibr(FISHEYE, "equidistant"), FISHEYE, True),
    "no distortion": (ros([0.0] * 5), [], False),
}


@pytest.mark.parametrize("case", CASES)
def test_pixels_are_those_of_opencv(stage, tmp_path, case):
    text, distortion, fisheye = CASES[case]
    file = tmp_path / "camera.yaml"
    file.write_text(text)
    item = rep.create.camera(calibration=file)
    prim = item.get_output_prims()["prims"][0].GetChildren()[0]
    view = read_camera(stage, prim.GetPath(), (640, 480))
    random = np.random.default_rng(1)
    points = random.uniform((-1.2, -0.9, 2.4), (1.2, 0.9, 6.0), (500, 3))  # x right, y down, z ahead
    expected = projected(points, MATRIX, distortion, fisheye=fisheye)
    in_world = points * (1, -1, -1) @ view.local_to_world[:3, :3] + view.local_to_world[3, :3]
    found, _ = view.project(in_world)
    seen = ((expected > 0) & (expected < (640, 480))).all(axis=1)
    assert seen.sum() > 100
    # The attributes are float32; ours count from the corner of the first pixel, OpenCV's from its center.
    np.testing.assert_allclose(found[seen] - 0.5, expected[seen], atol=2e-3)
    _, directions = view.rays(expected[seen] + 0.5)
    truth = points[seen] * (1, -1, -1)
    np.testing.assert_allclose(directions, truth / np.linalg.norm(truth, axis=1, keepdims=True), atol=2e-5)


def test_a_camera_with_square_pixels_and_no_distortion_is_a_plain_pinhole(stage, tmp_path):
    file = tmp_path / "camera.yaml"
    file.write_text(ros([0.0] * 5).replace("608.75", "612.5"))
    path = rep.create.camera(calibration=file).get_output_prims()["prims"][0].GetChildren()[0].GetPath()
    view = read_camera(stage, path, (640, 480))
    assert view.projection_type == "pinhole"
    assert (view.fx, view.cx, view.cy) == pytest.approx((612.5, 330.75, 232.0), abs=1e-3)


def test_a_picture_of_half_the_size_has_half_the_pixels(stage, tmp_path):
    file = tmp_path / "camera.yaml"
    file.write_text(CASES["Kalibr radtan"][0])
    path = rep.create.camera(calibration=file).get_output_prims()["prims"][0].GetChildren()[0].GetPath()
    whole, half = (read_camera(stage, path, size) for size in ((640, 480), (320, 240)))
    points = np.random.default_rng(2).uniform((2, -0.5, -0.5), (5, 0.5, 0.5), (50, 3))
    np.testing.assert_allclose(half.project(points)[0] * 2, whole.project(points)[0], atol=1e-6)


MISTAKES = {
    "tilted sensors": (opencv([*PRISM, 0.01, 0.0]), "tilted sensors"),
    "omni": (kalibr(RADTAN, camera_model="omni", intrinsics=[0.8, 600, 600, 320, 240]), "unified omnidirectional"),
    "double sphere": (kalibr(RADTAN, camera_model="ds"), "double sphere"),
    "fov": (kalibr([0.9], "fov"), "distortion_model is 'fov'.*plumb_bob.*equidistant"),
    "no size": (kalibr(RADTAN).replace("resolution", "resolutoin"), "image_width is missing"),
    "focal": (kalibr(RADTAN, intrinsics=[-612.5, 608.75, 330, 231]), "focal lengths.*above 0"),
    "three numbers": (kalibr(RADTAN, intrinsics=[612.5, 330, 231]), r"expected \[fu, fv, pu, pv\]"),
    "skew": (ros(RADTAN).replace("- 0.0\n  - 330.25", "- 0.5\n  - 330.25"), r"expected \[fx, 0, cx"),
    "words": (kalibr("many"), "not a list of numbers"),
    "another file": ("num_frames: 3\n", "no calibration of a camera: it has num_frames; expected OpenCV"),
    "XML": ('<?xml version="1.0"?>\n<opencv_storage/>', "is XML"),
    "no YAML": ("a: [1, 2", "not valid YAML"),
    "nothing": ("", "no calibration"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_mistakes_are_named_with_what_is_expected(tmp_path, case):
    text, message = MISTAKES[case]
    file = tmp_path / "camera.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=message):
        read_calibration(file)


def test_arguments_of_the_lens_cannot_be_given_with_a_calibration(stage, tmp_path):
    file = tmp_path / "camera.yaml"
    file.write_text(ros(RADTAN))
    with pytest.raises(ArgumentError, match="focal_length, projection_type cannot be given with a calibration"):
        rep.create.camera(calibration=file, focal_length=30.0, projection_type="fisheyeOpenCV")
    for name in ("none.yaml", "n\0ne.yaml"):
        with pytest.raises(ConfigError, match=r"ne\.yaml: the calibration cannot be read"):
            rep.create.camera(calibration=str(tmp_path / name))


def turned(axis: int, degrees: float, shift) -> np.ndarray:
    pose, angle = np.eye(4), np.radians(degrees)
    a, b = [each for each in range(3) if each != axis]
    pose[a, a] = pose[b, b] = np.cos(angle)
    pose[a, b], pose[b, a] = -np.sin(angle), np.sin(angle)
    pose[:3, 3] = shift
    return pose


def chain_file(tmp_path, **poses):
    """A camchain of len(poses) cameras, each with the transforms that are given."""
    camera = yaml.safe_load(kalibr(RADTAN))["cam0"]
    values = {name: {**camera, **{key: each.tolist() for key, each in more.items()}} for name, more in poses.items()}
    file = tmp_path / "camchain.yaml"
    file.write_text(yaml.safe_dump(values))
    return file


def test_the_chain_of_kalibr_places_cameras_relative_to_the_first(tmp_path):
    first, second = turned(1, 8, (-0.11, 0.002, 0.001)), turned(0, -5, (0.02, 0.1, 0.0))
    mounts = read_rig(chain_file(tmp_path, cam0={}, cam1={"T_cn_cnm1": first}, cam2={"T_cn_cnm1": second})).mounts
    assert [mount.name for mount in mounts] == ["cam0", "cam1", "cam2"]
    np.testing.assert_allclose(mounts[0].pose, np.eye(4))
    np.testing.assert_allclose(mounts[1].pose, np.linalg.inv(first), atol=1e-12)
    np.testing.assert_allclose(mounts[2].pose, np.linalg.inv(second @ first), atol=1e-12)


def test_the_imu_of_kalibr_places_cameras_too(tmp_path):
    a, b = turned(2, 90, (0.07, -0.02, 0.004)), turned(2, 88, (-0.04, -0.02, 0.003))
    mounts = read_rig(chain_file(tmp_path, cam0={"T_cam_imu": a}, cam1={"T_cam_imu": b})).mounts
    np.testing.assert_allclose(mounts[1].pose, a @ np.linalg.inv(b), atol=1e-12)
    with pytest.raises(ConfigError, match="cam1 has no place: expected T_cn_cnm1"):
        read_rig(chain_file(tmp_path, cam0={}, cam1={}))
    with pytest.raises(ConfigError, match="no rigid pose"):
        read_rig(chain_file(tmp_path, cam0={}, cam1={"T_cn_cnm1": a * 1.1}))


def test_one_camera_of_a_chain_is_named(tmp_path):
    file = chain_file(tmp_path, cam0={}, cam1={"T_cn_cnm1": np.eye(4)})
    assert read_calibration(f"{file}#cam1").focal == (612.5, 608.75)
    with pytest.raises(ConfigError, match=r"2 cameras; choose one: .*#cam0, .*#cam1"):
        read_calibration(file)
    with pytest.raises(ConfigError, match="no camera 'cam3'; it has cam0, cam1"):
        read_calibration(f"{file}#cam3")


@pytest.fixture(params=["Z", "Y"])
def up(request):
    new_stage()
    UsdGeom.SetStageUpAxis(current_stage(), request.param)
    UsdGeom.SetStageMetersPerUnit(current_stage(), 0.01)
    yield request.param
    new_stage()


def test_the_cameras_of_a_rig_move_as_one(up, tmp_path):
    (tmp_path / "lens.yaml").write_text(ros(RADTAN))
    pose = turned(1, 10, (0.12, 0.0, 0.01))
    half = np.radians(10) / 2
    quaternion = {"translation": [-0.12, 0.0, 0.01], "quaternion": [np.cos(half), 0.0, -np.sin(half), 0.0]}
    rig = [
        {"name": "left", "calibration": "lens.yaml", **{k: [float(each) for each in v] for k, v in quaternion.items()}},
        {"name": "right", "calibration": yaml.safe_load(ros(RADTAN)), "matrix": pose.tolist()},
    ]
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump({"rig": rig}))
    item = rep.create.camera_rig(tmp_path / "rig.yaml", position=(100, 20, 30), rotation=(5, -20, 40))
    body = item.get_output_prims()["prims"][0]
    alone = rep.create.camera(position=(100, 20, 30), rotation=(5, -20, 40)).get_output_prims()["prims"][0]
    stage = current_stage()
    assert [child.GetName() for child in body.GetChildren()] == ["left", "right"]
    middle = read_camera(stage, alone.GetChildren()[0].GetPath(), (640, 480))
    to_prim = np.diag((1.0, -1.0, -1.0, 1.0))
    for child, mount in zip(body.GetChildren(), read_rig(tmp_path / "rig.yaml").mounts):
        place = to_prim @ mount.pose @ to_prim  # of the camera prim in that of a camera that stands for the rig
        place[:3, 3] *= 100  # centimeters
        expected = place.T @ middle.local_to_world
        found = read_camera(stage, child.GetPath(), (640, 480)).local_to_world
        np.testing.assert_allclose(found, expected, atol=1e-5)
    # look_at turns the rig so that its first camera looks in that direction.
    aimed = rep.create.camera_rig(tmp_path / "rig.yaml", position=(100, 20, 30), look_at=(400, 60, 80))
    first = aimed.get_output_prims()["prims"][0].GetChildren()[0].GetPath()
    ahead = np.array((300, 40, 50)) / np.linalg.norm((300, 40, 50))
    np.testing.assert_allclose(-read_camera(stage, first, (640, 480)).local_to_world[2, :3], ahead, atol=1e-6)
    # A rig that is moved takes its cameras along.
    before = read_camera(stage, body.GetChildren()[1].GetPath(), (640, 480)).local_to_world[3, :3]
    with item:
        rep.modify.pose(position=(110, 20, 30))
    rep.orchestrator.step()
    after = read_camera(stage, body.GetChildren()[1].GetPath(), (640, 480)).local_to_world[3, :3]
    np.testing.assert_allclose(after - before, (10, 0, 0), atol=1e-6)


RIG_MISTAKES = {
    "no list": ({"rig": 3}, "expected a list"),
    "key": ({"rig": [{"calibration": "a.yaml", "tranlsation": [0, 0, 0]}]}, "unknown key tranlsation; expected name"),
    "no calibration": ({"rig": [{"translation": [0, 0, 0]}]}, "calibration is None; expected the path"),
    "two names": ({"rig": [{"name": "a", "calibration": {}}, {"name": "a", "calibration": {}}]}, "calibration is {}"),
}


@pytest.mark.parametrize("case", RIG_MISTAKES)
def test_mistakes_of_a_rig_are_named(tmp_path, case):
    values, message = RIG_MISTAKES[case]
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(values))
    with pytest.raises(ConfigError, match=message):
        read_rig(tmp_path / "rig.yaml")
