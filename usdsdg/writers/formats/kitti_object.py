"""Objects as KITTI tells them: in metres in its camera's frame (x right, y down, z ahead), turned about y only.

Source: the readme of KITTI's object development kit (cvlibs.net/datasets/kitti).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from usdsdg.writers.formats.pose import Pose

# From USD's camera frame (x right, y up, looking along -z).
_AXES = np.array([1.0, -1.0, -1.0])


@dataclass(frozen=True)
class KittiBox:
    """A 3D box of KITTI."""

    height: float  # [m]
    width: float
    length: float
    location: tuple[float, float, float]  # the middle of its bottom [m]
    rotation_y: float  # [rad] from the camera's x to the box's length, from -pi to pi
    alpha: float  # the same as seen along the ray to the box

    @classmethod
    def of(cls, pose: Pose, *, metres: float, up: int) -> KittiBox:
        """The box of a pose in stage units of `metres`, on a stage whose axis `up` points upwards.

        Height is along the object's axis that stands most upright, length along the first other one. An object that
        stands upright before a level camera has exactly this box; otherwise it has its size, its middle, and the
        direction of its length as seen from above the camera.
        """
        axes = pose.local_to_camera[:3, :3] * _AXES
        sizes = pose.size_local * np.linalg.norm(axes, axis=1) * metres
        middle = (pose.center_local @ pose.local_to_camera[:3, :3] + pose.local_to_camera[3, :3]) * _AXES * metres
        upright = int(np.abs(_units(pose.local_to_world[:3, :3])[:, up]).argmax())
        ahead, beside = (axis for axis in range(3) if axis != upright)
        bottom = middle + np.array([0.0, sizes[upright] / 2, 0.0])
        turn = math.atan2(-axes[ahead, 2], axes[ahead, 0])
        alpha = _wrapped(turn - math.atan2(bottom[0], bottom[2]))
        x, y, z = bottom.tolist()
        return cls(float(sizes[upright]), float(sizes[beside]), float(sizes[ahead]), (x, y, z), turn, alpha)


def line(kind: str, truncated: float, occluded: int, bounds: tuple[int, int, int, int], box: KittiBox) -> str:
    """A line of a label file: fifteen fields.

    kind: without blanks. truncated: from 0 to 1. occluded: 0 fully visible, 1 partly, 2 largely hidden.
    bounds: left, top, right and bottom pixel that belong to the object, counted from 0.
    """
    described = (box.height, box.width, box.length, *box.location, box.rotation_y)
    numbers = " ".join(_number(value) for value in described)
    return f"{kind} {_number(truncated)} {occluded} {_number(box.alpha)} {' '.join(map(str, bounds))} {numbers}\n"


def calibration(params: Mapping[str, Any]) -> str:
    """A calibration file for a pinhole: the four cameras are this one, and the laser scanner stands in it.

    Pixels are counted from the middle of the first, as in KITTI's labels.
    """
    width, height = (float(size) for size in params["renderProductResolution"])
    projection = np.asarray(params["cameraProjection"], np.float64).reshape(4, 4)
    camera = np.array(
        [
            [projection[0, 0] * width / 2, 0, (1 - projection[2, 0]) * width / 2 - 0.5, 0],
            [0, projection[1, 1] * height / 2, (1 + projection[2, 1]) * height / 2 - 0.5, 0],
            [0, 0, 1, 0],
        ]
    )
    # The scanner's frame: x ahead, y left, z up.
    scanner = np.array([[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0]])
    matrices = {
        **{f"P{index}": camera for index in range(4)},
        "R0_rect": np.eye(3),
        "Tr_velo_to_cam": scanner,
        "Tr_imu_to_velo": np.eye(3, 4),
    }
    return "".join(f"{name}: {' '.join(f'{value:.12e}' for value in m.ravel())}\n" for name, m in matrices.items())


def _units(axes: np.ndarray) -> np.ndarray:
    return axes / np.maximum(np.linalg.norm(axes, axis=1, keepdims=True), 1e-12)


def _wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)


def _number(value: float) -> str:
    """Two decimals, without a negative zero."""
    return f"{round(value, 2) + 0.0:.2f}"
