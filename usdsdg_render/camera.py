"""`CameraView` to the record that kernels read."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import warp as wp

from usdsdg.errors import Unsupported
from usdsdg_render.kernels.types import Camera

if TYPE_CHECKING:
    from usdsdg.stage.cameras import CameraView

# Focal lengths are in tenths of stage units.
FOCAL_UNIT = 0.1


def camera_record(view: CameraView) -> Camera:
    """The kernels' camera.

    Raises:
        Unsupported: the projection is neither pinhole nor orthographic.
    """
    if view.projection_type not in ("pinhole", "orthographic"):
        raise Unsupported(
            f"{view.prim_path} has projection {view.projection_type!r}; the renderer has pinhole and orthographic. "
            "Remove cameraProjectionType from the camera."
        )
    camera = Camera()
    camera.origin = wp.vec3(*view.local_to_world[3, :3].tolist())
    # Rows of the row-vector matrix are the camera's axes; the kernel wants them as columns.
    camera.rotation = wp.mat33(np.ascontiguousarray(view.local_to_world[:3, :3].T, np.float32))
    camera.fx, camera.fy, camera.cx, camera.cy = view.fx, view.fy, view.cx, view.cy
    camera.width, camera.height = view.width, view.height
    camera.near, camera.far = view.clipping_range
    camera.orthographic = int(view.projection_type == "orthographic")
    if view.f_stop > 0 and view.focus_distance > 0:
        camera.lens_radius = view.focal_length * FOCAL_UNIT / (2.0 * view.f_stop)
        camera.focus_distance = view.focus_distance
    return camera
