"""Annotators of camera parameters and of the reference time."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.lens_attributes import EYE_DISTANCE, LEFT_EYE, TEXTURES, reported_lens
from usdsdg.stage.cameras.lenses import LINEAR_PROJECTIONS

# What is known before the first frame: nothing, in the types of later frames.
_NO_CAMERA: Mapping[str, Any] = {
    **dict.fromkeys(("cameraAperture", "cameraApertureOffset", "cameraNearFar"), np.zeros(2, np.float32)),
    **dict.fromkeys(("cameraFisheyeLensP", "cameraFisheyeLensS"), np.zeros(0, np.float32)),
    **dict.fromkeys(("cameraFisheyeNominalHeight", "cameraFisheyeNominalWidth"), 0),
    **dict.fromkeys(("cameraFisheyeMaxFOV", "cameraFocalLength", "cameraFocusDistance", "cameraFStop"), 0.0),
    **dict.fromkeys(("cameraOpenCVFx", "cameraOpenCVFy", "metersPerSceneUnit"), 0.0),
    **dict.fromkeys(("cameraProjection", "cameraViewTransform"), np.zeros(16)),
    "cameraFisheyeOpticalCentre": np.zeros(2, np.float32),
    "cameraFisheyePolynomial": np.zeros(6, np.float32),
    "cameraModel": "",
    "renderProductResolution": np.zeros(2, np.int32),
}


@define("camera_params", "CameraParams", info=_NO_CAMERA)
def camera_params(frame: Frame, params: Mapping[str, Any]) -> Annotation:
    """Camera parameters under Replicator's names, a dict; matrices are float64 (16,), row-major, for row vectors.

    cameraViewTransform maps from the world to the camera; lengths are in the units of the prim's attributes.

    The projection maps to clip space with reversed Z: depth 1 on the near plane, 0 on the far one. For nonlinear lenses
    it is that of the pinhole with the same focal length, as in Replicator. Lens distortion schemas are reported under
    the names of the older attributes; of a pinhole without calibration these are 0, LensP and LensS empty.
    interpupillaryDistance [cm] and isLeftEye exist for omniDirectionalStereo, the paths of the two textures for
    generalizedProjection.
    """
    return Annotation(None, read_params(frame.camera))


@define("ReferenceTime", info={"referenceTimeNumerator": 0, "referenceTimeDenominator": 0})
def reference_time(frame: Frame, params: Mapping[str, Any]) -> Annotation:
    """Time of the frame [s] as the integers referenceTimeNumerator and referenceTimeDenominator."""
    numerator, denominator = frame.reference_time
    return Annotation(None, {"referenceTimeNumerator": int(numerator), "referenceTimeDenominator": int(denominator)})


def read_params(view: CameraView) -> dict[str, Any]:
    """Return the payload of camera_params for `view`."""
    lens = reported_lens(view.projection_type, view.lens_parameters)
    numbers = {
        "cameraAperture": _floats(view.horizontal_aperture, view.vertical_aperture),
        "cameraApertureOffset": _floats(view.horizontal_aperture_offset, view.vertical_aperture_offset),
        "cameraFisheyeLensP": _floats(*lens.tangential),
        "cameraFisheyeLensS": _floats(*lens.thin_prism),
        "cameraFisheyeMaxFOV": float(lens.max_fov),
        "cameraFisheyeNominalHeight": int(lens.nominal_size[1]),
        "cameraFisheyeNominalWidth": int(lens.nominal_size[0]),
        "cameraFisheyeOpticalCentre": _floats(*lens.center),
        "cameraFisheyePolynomial": _floats(*lens.polynomial),
        "cameraFocalLength": float(view.focal_length),
        "cameraFocusDistance": float(view.focus_distance),
        "cameraFStop": float(view.f_stop),
        "cameraModel": view.projection_type,
        "cameraNearFar": _floats(*view.clipping_range),
        "cameraOpenCVFx": float(lens.focal[0]),
        "cameraOpenCVFy": float(lens.focal[1]),
        "cameraProjection": _pinhole(view).projection_matrix.reshape(16),
        "cameraViewTransform": np.asarray(view.world_to_camera, np.float64).reshape(16),
        "metersPerSceneUnit": float(view.meters_per_unit),
        "renderProductResolution": np.array([view.width, view.height], np.int32),
    }
    return dict(sorted((numbers | _projection_params(view)).items()))


def _projection_params(view: CameraView) -> dict[str, Any]:
    """Return the parameters that only this projection has, under the names of the attributes."""
    lens = view.lens_parameters
    if view.projection_type == "omniDirectionalStereo":
        return {EYE_DISTANCE: lens.eye_distance * 100, LEFT_EYE: lens.left_eye}
    if view.projection_type == "generalizedProjection":
        return dict(zip(TEXTURES, (lens.direction_texture, lens.position_texture), strict=True))
    return {}


def _pinhole(view: CameraView) -> CameraView:
    if view.projection_type in LINEAR_PROJECTIONS:
        return view
    return dataclasses.replace(view, projection_type="pinhole")


def _floats(*values: float) -> np.ndarray:
    return np.array(values, np.float32)
