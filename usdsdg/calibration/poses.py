"""Where the cameras of a rig are: poses as users write them, and Kalibr's chain of transforms."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.errors import ConfigError

# Calibrated rotations are written with few digits; what is further from a rotation is a mistake.
_TOLERANCE = 1e-3


def placed(values: Mapping[str, Any], name: str) -> np.ndarray:
    """Return the pose (4, 4), column vectors, of a camera in its rig; the identity where nothing is written.

    Args:
        values: `matrix`, 4 x 4 or 3 x 4, or `translation` [meters] and `quaternion` (w, x, y, z): from the camera to
            the rig, both with x right, y down and z ahead.

    Raises:
        ConfigError: they are not a rigid pose.
    """
    if values.get("matrix") is not None:
        if values.get("translation") is not None or values.get("quaternion") is not None:
            raise ConfigError(f"{name}: has a matrix and a translation or quaternion; expected one of the two forms")
        return _rigid(values["matrix"], f"{name}: matrix")
    pose = np.eye(4)
    pose[:3, 3] = _vector(values.get("translation", (0, 0, 0)), 3, f"{name}: translation", "x, y, z in meters")
    w, x, y, z = _vector(values.get("quaternion", (1, 0, 0, 0)), 4, f"{name}: quaternion", "w, x, y, z")
    length = float(np.linalg.norm((w, x, y, z)))
    if abs(length - 1.0) > _TOLERANCE:
        raise ConfigError(
            f"{name}: quaternion has the length {length:.4g}; expected w, x, y, z of a rotation, length 1"
        )
    w, x, y, z = (each / length for each in (w, x, y, z))
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return pose


def chained(cameras: Mapping[str, Mapping[str, Any]], file: str) -> list[np.ndarray]:
    """Return the pose (4, 4), column vectors, of each camera of Kalibr's chain in the frame of the first one.

    `T_cn_cnm1` takes points from the camera before to this one, `T_cam_imu` from the IMU to this one.

    Raises:
        ConfigError: a camera after the first has neither.
    """
    to_camera, first_from_imu = [np.eye(4)], None  # from the first camera's frame
    for index, (name, values) in enumerate(cameras.items()):
        imu = values.get("T_cam_imu")
        if index == 0:
            first_from_imu = None if imu is None else _rigid(imu, f"{file}: {name}: T_cam_imu")
            continue
        if values.get("T_cn_cnm1") is not None:
            to_camera.append(_rigid(values["T_cn_cnm1"], f"{file}: {name}: T_cn_cnm1") @ to_camera[-1])
        elif imu is not None and first_from_imu is not None:
            to_camera.append(_rigid(imu, f"{file}: {name}: T_cam_imu") @ np.linalg.inv(first_from_imu))
        else:
            raise ConfigError(
                f"{file}: {name} has no place: expected T_cn_cnm1, from the camera before it, or T_cam_imu of it and "
                "of the first camera"
            )
    return [np.linalg.inv(each) for each in to_camera]


def _vector(given: Any, count: int, what: str, expected: str) -> list[float]:
    try:
        numbers = np.asarray(given, np.float64)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise ConfigError(f"{what} is {given!r}; expected {expected}")
    return numbers.tolist()


def _rigid(given: Any, what: str) -> np.ndarray:
    data = given.get("data", ()) if isinstance(given, Mapping) else given
    try:
        numbers = np.asarray(data, np.float64)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.size not in (12, 16) or not np.isfinite(numbers).all():
        raise ConfigError(f"{what} is {given!r}; expected 4 x 4 or 3 x 4 numbers")
    pose = np.eye(4)
    pose[: numbers.size // 4] = numbers.reshape(-1, 4)
    rotation = pose[:3, :3]
    off = max(float(np.abs(rotation @ rotation.T - np.eye(3)).max()), abs(float(np.linalg.det(rotation)) - 1.0))
    if off > _TOLERANCE or not np.array_equal(pose[3], (0, 0, 0, 1)):
        raise ConfigError(
            f"{what} is no rigid pose: its rotation is off by {off:.2g}; expected rotation and translation"
        )
    u, _, v = np.linalg.svd(rotation)  # the nearest rotation to rounded digits
    pose[:3, :3] = u @ v
    return pose
