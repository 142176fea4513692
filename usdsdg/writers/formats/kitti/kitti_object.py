"""Objects in KITTI's label format: in meters in its camera frame (x right, y down, z ahead), rotated about y only.

Source: the readme of KITTI's object development kit (cvlibs.net/datasets/kitti).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from usdsdg.writers.formats.shapes.camera_projection import camera_matrix
from usdsdg.writers.formats.shapes.pose import Pose

# From USD's camera frame (x right, y up, looking along -z).
_AXES = np.array([1.0, -1.0, -1.0])


@dataclass(frozen=True)
class KittiBox:
    """A 3D box of KITTI."""

    height: float  # [m]
    width: float
    length: float
    location: tuple[float, float, float]  # center of its bottom face [m]
    rotation_y: float  # [rad] from the camera's x to the box's length, from -pi to pi
    alpha: float  # observation angle: the same relative to the ray to the box

    @classmethod
    def of(cls, pose: Pose, *, meters: float, up: int) -> KittiBox:
        """Return the box of a pose in stage units of `meters`, on a stage whose up axis is `up` (0, 1 or 2).

        Height is along the object's most vertical axis, length along the first other one. For an upright object and a
        level camera the box is exact; otherwise size, center and the heading seen from above the camera are.
        """
        axes = pose.local_to_camera[:3, :3] * _AXES
        sizes = pose.size_local * np.linalg.norm(axes, axis=1) * meters
        center = (pose.center_local @ pose.local_to_camera[:3, :3] + pose.local_to_camera[3, :3]) * _AXES * meters
        upright = int(np.abs(_units(pose.local_to_world[:3, :3])[:, up]).argmax())
        ahead, beside = (axis for axis in range(3) if axis != upright)
        bottom = center + np.array([0.0, sizes[upright] / 2, 0.0])
        rotation_y = math.atan2(-axes[ahead, 2], axes[ahead, 0])
        alpha = _wrapped(rotation_y - math.atan2(bottom[0], bottom[2]))
        x, y, z = bottom.tolist()
        return cls(float(sizes[upright]), float(sizes[beside]), float(sizes[ahead]), (x, y, z), rotation_y, alpha)


def line(name: str, truncated: float, occluded: int, bounds: tuple[int, int, int, int], box: KittiBox) -> str:
    """Format a line of a label file: fifteen fields.

    name: class, without blanks. truncated: from 0 to 1. occluded: 0 fully visible, 1 partly, 2 largely occluded.
    bounds: left, top, right and bottom pixel of the object, inclusive, from 0.
    """
    described = (box.height, box.width, box.length, *box.location, box.rotation_y)
    numbers = " ".join(_number(value) for value in described)
    return f"{name} {_number(truncated)} {occluded} {_number(box.alpha)} {' '.join(map(str, bounds))} {numbers}\n"


def calibration(params: Mapping[str, Any]) -> str:
    """Format a calibration file for a pinhole camera, which stands for all four cameras and the laser scanner.

    Pixel coordinates are 0 at the center of the first pixel, as in KITTI's labels.
    """
    camera = np.column_stack([camera_matrix(params), np.zeros(3)])
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
    """Format with six significant digits, since objects may be small, and at least two decimals."""
    text = np.format_float_positional(value + 0.0, precision=6, unique=False, fractional=False, trim="0")
    whole, _, decimals = text.partition(".")
    return f"{whole}.{decimals.rstrip('0').ljust(2, '0')}"
