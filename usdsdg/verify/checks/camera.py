"""Cameras: the one that saw the image, with its lens, in meters."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats import basic
from usdsdg.datasets.seen import Camera, Seen
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.lens_attributes import reported_lens
from usdsdg.verify.checks.compare import beyond, differs, text

# float32 of the file's numbers.
_RELATIVE = 1e-6
# What camera_params has had in every version.
_ALWAYS = (
    "cameraAperture", "cameraApertureOffset", "cameraFocalLength", "cameraNearFar", "cameraFStop",
    "cameraFocusDistance", "metersPerSceneUnit",
)  # fmt: skip


def check(seen: Seen) -> Faults:
    """Compare cameras with the recorded one, and with themselves."""
    for camera in seen.cameras:
        yield from _is_rigid(seen, camera)
        view = seen.truth.camera if seen.truth else None
        if view is not None:
            yield from _recorded(seen, camera, view)
    for array in seen.arrays.values():
        for camera in seen.cameras:
            if camera.size and camera.size != (array[1].shape[1], array[1].shape[0]):
                yield Fault(
                    camera.file,
                    seen.name,
                    f"the size is not that of {array[0]}",
                    str(array[1].shape[1::-1]),
                    str(camera.size),
                )
                return


def _is_rigid(seen: Seen, camera: Camera) -> Faults:
    """A camera turns and moves, and nothing else."""
    view = camera.view
    if view is None:
        return
    off = max(camera.digits * 10, 1e-6)
    turn = view[:3, :3] @ view[:3, :3].T
    if differs(turn, np.eye(3), relative=0.0, absolute=off) or beyond(np.abs(view[:, 3] - (0, 0, 0, 1)), off).any():
        yield Fault(
            camera.file,
            seen.name,
            "the camera's matrix is no rotation with a translation in the last row",
            "",
            text(view),
        )


def _recorded(seen: Seen, camera: Camera, view: CameraView) -> Faults:
    if camera.view is not None and differs(camera.view, view.world_to_camera, relative=1e-9, absolute=camera.digits):
        yield Fault(camera.file, seen.name, "the camera's matrix", text(view.world_to_camera), text(camera.view))
    if camera.size is not None and camera.size != (view.width, view.height):
        yield Fault(
            camera.file, seen.name, "the image's size", f"{view.width} x {view.height}", "{} x {}".format(*camera.size)
        )
    if view.projection_type == "pinhole":
        expected = (view.fx, view.fy, view.cx, view.cy)
        focal_down = camera.focal if camera.focal_down is None else camera.focal_down
        found = (camera.focal, focal_down, *(camera.center or ()))
        if camera.focal is not None and differs(found, expected, relative=max(_RELATIVE, camera.digits)):
            yield Fault(camera.file, seen.name, "focal lengths and center [pixels]", text(expected), text(found))
    for name in ("cameraProjection", "camera_projection_matrix"):
        if name in camera.values and view.projection_type == "pinhole" and math.isfinite(view.clipping_range[1]):
            found = np.reshape(camera.values[name], (4, 4))
            if differs(found, view.projection_matrix, relative=_RELATIVE, absolute=camera.digits):
                yield Fault(camera.file, seen.name, name, text(view.projection_matrix), text(found))
    for name, expected in _values(view).items():
        if name in camera.values:
            found = camera.values[name]
            if isinstance(expected, str):
                wrong = found != expected
            else:
                wrong = differs(found, expected, relative=_RELATIVE)
            if wrong:
                yield Fault(camera.file, seen.name, name, str(expected), str(found))
    for name in _ALWAYS if seen.format == basic.NAME else ():
        if name not in camera.values:
            yield Fault(camera.file, seen.name, f"{name} is missing")


def _values(view: CameraView) -> dict[str, Any]:
    """Return what files have of a camera, by their names."""
    values: dict[str, Any] = {
        "cameraModel": view.projection_type,
        "cameraFocalLength": view.focal_length,
        "cameraAperture": [view.horizontal_aperture, view.vertical_aperture],
        "cameraApertureOffset": [view.horizontal_aperture_offset, view.vertical_aperture_offset],
        "metersPerSceneUnit": view.meters_per_unit,
        "cameraFStop": view.f_stop,
        "cameraFocusDistance": view.focus_distance,
        "aperture": [view.horizontal_aperture, view.vertical_aperture],
        "aperture_offset": [view.horizontal_aperture_offset, view.vertical_aperture_offset],
        "focal_length": view.focal_length,
        "meters_per_scene_unit": view.meters_per_unit,
    }
    lens = view.lens_parameters
    # Files of earlier versions have other values for a pinhole without calibration, where they mean nothing.
    if reported_lens(view.projection_type, lens) is lens:
        values |= {
            "cameraFisheyeLensP": list(lens.tangential),
            "cameraFisheyeLensS": list(lens.thin_prism),
            "cameraFisheyeMaxFOV": lens.max_fov,
            "cameraFisheyeNominalWidth": int(lens.nominal_size[0]),
            "cameraFisheyeNominalHeight": int(lens.nominal_size[1]),
            "cameraFisheyeOpticalCentre": list(lens.center),
            "cameraFisheyePolynomial": list(lens.polynomial),
            "cameraOpenCVFx": lens.focal[0],
            "cameraOpenCVFy": lens.focal[1],
        }
    if math.isfinite(view.clipping_range[1]):
        values["cameraNearFar"] = list(view.clipping_range)
    return values
