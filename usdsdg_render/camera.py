"""`CameraView` to the record that kernels read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import warp as wp

from usdsdg.stage import lens_curves
from usdsdg_render.kernels import lens as kernel
from usdsdg_render.kernels.camera import BAND
from usdsdg_render.kernels.types import Camera
from usdsdg_render.kernels.views import Views

if TYPE_CHECKING:
    from usdsdg.stage.cameras import CameraView
    from usdsdg.stage.lenses import Lens

# Focal lengths are in tenths of stage units.
FOCAL_UNIT = 0.1

_CURVES = {
    lens_curves.ODD: (kernel.ODD, kernel.FISHEYE),
    lens_curves.POWER: (kernel.POWER, kernel.F_THETA),
    lens_curves.RATIONAL: (kernel.RATIONAL, kernel.FLAT),
    lens_curves.SINE: (kernel.SINE, kernel.FISHEYE),
    lens_curves.HALF_SINE: (kernel.HALF_SINE, kernel.FISHEYE),
}


def camera_record(view: CameraView) -> Camera:
    """The kernels' camera.

    Raises:
        Unsupported: there is no formula for the lens, or its calibration gives no picture.
    """
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
    if view.lens is not None:
        camera.lens = _lens_record(view.lens)
        camera.lens_kind = camera.lens.kind
        (camera.fx, camera.fy), (camera.cx, camera.cy) = view.lens.focal, view.lens.centre
    return camera


def views_record(views: Sequence[CameraView], device: str) -> Views:
    """Views of one size as kernels read them."""
    record = Views()
    record.cameras = camera_array(views, device)
    record.width, record.height = views[0].width, views[0].height
    record.bands = -(-record.height // BAND)
    return record


def camera_array(views: Sequence[CameraView], device: str) -> wp.array:
    """(len(views),) records of the kernels' cameras."""
    return wp.array([camera_record(view) for view in views], dtype=Camera, device=device)


def _lens_record(lens: Lens) -> kernel.Lens:
    record = kernel.Lens()
    if lens.curve is None:
        record.kind = kernel.PANORAMA
        return record
    record.curve, record.kind = _CURVES[lens.curve.kind]
    record.k0, record.k1, record.k2, record.k3, record.k4, record.k5 = lens.curve.k
    record.limit, record.last = lens.curve.limit, lens.curve.last
    record.bends = int(lens.bends)
    record.p1, record.p2 = lens.tangential
    record.s1, record.s2, record.s3, record.s4 = lens.thin_prism
    return record
