"""The records of BOP's tables: cameras, poses, and what is visible of objects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from usdsdg.writers.formats.bop.bop_files import MILLIMETERS
from usdsdg.writers.formats.bop.bop_models import Placed
from usdsdg.writers.formats.shapes.camera_projection import camera_matrix
from usdsdg.writers.formats.shapes.masks import extent
from usdsdg.writers.formats.shapes.opencv_frame import opencv_position, opencv_rotation


class View:
    """The camera of one picture."""

    def __init__(self, params: Mapping[str, Any], depth_scale: float) -> None:
        """params: of camera_params. depth_scale: millimeters of a step."""
        self._params, self.depth_scale = params, depth_scale
        self.millimeters = float(params["metersPerSceneUnit"]) * MILLIMETERS  # per stage unit
        self._to_camera = np.asarray(params["cameraViewTransform"], np.float64).reshape(4, 4)

    def sensor(self) -> dict[str, Any]:
        """Return the content of camera.json."""
        matrix = camera_matrix(self._params)
        width, height = (int(size) for size in self._params["renderProductResolution"])
        values = {"cx": matrix[0, 2], "cy": matrix[1, 2], "fx": matrix[0, 0], "fy": matrix[1, 1]}
        return {**values, "depth_scale": self.depth_scale, "width": width, "height": height}

    def record(self) -> dict[str, Any]:
        """Return the record of scene_camera."""
        return {
            "cam_K": camera_matrix(self._params).ravel().tolist(),
            "depth_scale": self.depth_scale,
            "cam_R_w2c": opencv_rotation(np.eye(3), self._to_camera).ravel().tolist(),
            "cam_t_w2c": (opencv_position(np.zeros(3), self._to_camera) * self.millimeters).tolist(),
        }

    def pose(self, placed: Placed) -> dict[str, Any]:
        """Return the record of scene_gt."""
        return {
            "cam_R_m2c": opencv_rotation(placed.rotation, self._to_camera).ravel().tolist(),
            "cam_t_m2c": (opencv_position(placed.position, self._to_camera) * self.millimeters).tolist(),
            "obj_id": placed.obj_id,
        }


def info(modal: np.ndarray, amodal: np.ndarray, whole: Any, depth: np.ndarray) -> dict[str, Any]:
    """Return the record of scene_gt_info: boxes, and numbers of pixels.

    modal, amodal: masks (H, W). whole: row of bounding_box_2d_amodal. depth: (H, W) as it is written, 0 where it is not
    known. px_count_all counts pixels around the picture too, as the box of the whole object contains them. What is not
    visible has no boxes.
    """
    everywhere = round(int(amodal.sum()) / max(1.0 - float(whole["truncationRatio"]), 1e-6))
    visible, seen = int(modal.sum()), extent(modal)
    return {
        "bbox_obj": box_of(seen and [int(whole[name]) for name in ("x_min", "y_min", "x_max", "y_max")]),
        "bbox_visib": box_of(seen),
        "px_count_all": everywhere,
        "px_count_valid": int((amodal & (depth > 0)).sum()),
        "px_count_visib": visible,
        "visib_fract": visible / everywhere if everywhere else 0.0,
    }


def box_of(ends: Sequence[int] | None) -> list[int]:
    """Return a box of BOP of first and last pixels (x_min, y_min, x_max, y_max); -1 four times for none.

    Width and height are differences of pixels, as in bop_toolkit: those of one pixel are 0.
    """
    if ends is None:
        return [-1, -1, -1, -1]
    return [ends[0], ends[1], ends[2] - ends[0], ends[3] - ends[1]]
