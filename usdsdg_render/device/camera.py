"""Camera records for kernels, from `CameraView`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp

from usdsdg.stage.cameras import lens_curves
from usdsdg_render.device.lens_tables import table_address
from usdsdg_render.kernels.cameras import lens as kernel
from usdsdg_render.kernels.cameras.camera import BAND
from usdsdg_render.kernels.labels.views import Views
from usdsdg_render.scene.struct_rows import records, uploaded
from usdsdg_render.scene.structs import Camera

if TYPE_CHECKING:
    from usdsdg.stage.cameras.camera_view import CameraView
    from usdsdg.stage.cameras.lens import Lens

# Focal lengths are in tenths of stage units.
FOCAL_UNIT = 0.1

_CURVES = {
    lens_curves.ODD: (kernel.ODD, kernel.FISHEYE),
    lens_curves.POWER: (kernel.POWER, kernel.F_THETA),
    lens_curves.RATIONAL: (kernel.RATIONAL, kernel.FLAT),
    lens_curves.SINE: (kernel.SINE, kernel.FISHEYE),
    lens_curves.HALF_SINE: (kernel.HALF_SINE, kernel.FISHEYE),
}


def camera_records(views: Sequence[CameraView], device: str) -> np.ndarray:
    """Return (len(views),) camera records, for kernels of a device.

    Raises:
        Unsupported: the projection of a camera is not known, or its calibration gives no image.
        AssetError: a texture that describes a lens is missing or unreadable.
    """
    rows = records(Camera, len(views))
    rows["environment_weight"] = 1.0
    matrices = np.array([view.local_to_world for view in views]).reshape(-1, 4, 4)
    rows["origin"] = matrices[:, 3, :3]
    # The rows of a row-vector matrix are the camera's axes; kernels have them as columns.
    rows["rotation"] = matrices[:, :3, :3].transpose(0, 2, 1)
    for row, view in zip(rows, views, strict=True):
        row["width"], row["height"] = view.width, view.height
        row["near"], row["far"] = view.clipping_range
        row["orthographic"] = view.projection_type == "orthographic"
        if view.f_stop > 0 and view.focus_distance > 0:
            row["lens_radius"] = view.focal_length * FOCAL_UNIT / (2.0 * view.f_stop)
            row["focus_distance"] = view.focus_distance
        if view.lens is None:
            row["fx"], row["fy"], row["cx"], row["cy"] = view.fx, view.fy, view.cx, view.cy
        else:
            (row["fx"], row["fy"]), (row["cx"], row["cy"]) = view.lens.focal, view.lens.center
            _fill_lens(row["lens"], view.lens, device)
            row["lens_kind"] = row["lens"]["kind"]
    return rows


def camera_array(views: Sequence[CameraView], device: str) -> wp.array:
    """Upload `camera_records` to a device."""
    return uploaded(camera_records(views, device), Camera, device)


def views_record(views: Sequence[CameraView], device: str) -> Views:
    """Return the kernel record of views of one size."""
    return views_of(camera_records(views, device), device)


def views_of(rows: np.ndarray, device: str) -> Views:
    """Return the kernel record of views, from `camera_records`."""
    record = Views()
    record.cameras = uploaded(rows, Camera, device)
    record.width, record.height = (int(rows[0][name]) for name in ("width", "height"))
    record.bands = -(-record.height // BAND)
    record.are_pinholes = bool(((rows["lens_kind"] == kernel.NONE) & (rows["orthographic"] == 0)).all())
    return record


def _fill_lens(row: Any, lens: Lens, device: str) -> None:
    if lens.table is not None:
        row["kind"], row["table"] = kernel.TABLE, table_address(lens.table, device)
        row["table_width"], row["table_height"] = lens.table.size
        return
    if lens.curve is None:
        row["kind"], row["eye_offset"] = kernel.PANORAMA, lens.eye_offset
        return
    row["curve"], row["kind"] = _CURVES[lens.curve.kind]
    row["k0"], row["k1"], row["k2"], row["k3"], row["k4"], row["k5"] = lens.curve.k
    row["limit"], row["limit_value"] = lens.curve.limit, lens.curve.limit_value
    row["is_asymmetric"] = lens.is_asymmetric
    row["p1"], row["p2"] = lens.tangential
    row["s1"], row["s2"], row["s3"], row["s4"] = lens.thin_prism
