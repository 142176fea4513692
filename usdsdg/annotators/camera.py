"""Camera parameters and time: annotators of numbers instead of pixels."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.stage.cameras import LINEAR_PROJECTIONS, CameraView

# Lens attributes of Omniverse cameras and the values that stand for an absent one.
_FISHEYE = {
    "cameraFisheyeMaxFOV": ("fthetaMaxFov", 200.0),
    "cameraFisheyeNominalHeight": ("fthetaHeight", 1216.0),
    "cameraFisheyeNominalWidth": ("fthetaWidth", 1936.0),
    "cameraOpenCVFx": ("openCVFx", 731.78788),
    "cameraOpenCVFy": ("openCVFy", 731.78789),
}
_CENTRE = {"fthetaCx": 970.94244, "fthetaCy": 600.37482}
_POLYNOMIAL = {
    "fthetaPolyA": 0.0,
    "fthetaPolyB": 0.00245,
    "fthetaPolyC": 0.0,
    "fthetaPolyD": 0.0,
    "fthetaPolyE": 0.0,
    "fthetaPolyF": 0.0,
}
_TANGENTIAL = {"p0": -0.00037, "p1": -0.00074}
_THIN_PRISM = {"s0": -0.00058, "s1": -0.00022, "s2": 0.00019, "s3": -0.0002}


@define("camera_params", "CameraParams")
def camera_params(frame: Frame, params: Mapping[str, Any]) -> Annotation:
    """Everything of the camera as Replicator names it, a dict; matrices are float64 (16,), row by row, for row vectors.

    cameraViewTransform maps from the world to the camera; lengths are in the units of the prim's attributes.

    The projection maps to clip space with reversed Z: depth 1 on the near plane, 0 on the far one. For lenses that no
    matrix describes it is that of the pinhole with the same focal length, as in Replicator.
    """
    return Annotation(None, read_params(frame.camera))


@define("ReferenceTime")
def reference_time(frame: Frame, params: Mapping[str, Any]) -> Annotation:
    """Time of the frame [s] as the integers referenceTimeNumerator and referenceTimeDenominator."""
    numerator, denominator = frame.reference_time
    return Annotation(None, {"referenceTimeNumerator": int(numerator), "referenceTimeDenominator": int(denominator)})


def read_params(view: CameraView) -> dict[str, Any]:
    """The payload of camera_params for `view`."""
    numbers = {
        "cameraAperture": _floats(view.horizontal_aperture, view.vertical_aperture),
        "cameraApertureOffset": _floats(view.horizontal_aperture_offset, view.vertical_aperture_offset),
        "cameraFisheyeLensP": _lens(view, _TANGENTIAL),
        "cameraFisheyeLensS": _lens(view, _THIN_PRISM),
        "cameraFisheyeOpticalCentre": _lens(view, _CENTRE),
        "cameraFisheyePolynomial": _lens(view, _POLYNOMIAL),
        **{key: _attribute(view, name, default) for key, (name, default) in _FISHEYE.items()},
        "cameraFocalLength": float(view.focal_length),
        "cameraFocusDistance": float(view.focus_distance),
        "cameraFStop": float(view.f_stop),
        "cameraModel": view.projection_type,
        "cameraNearFar": _floats(*view.clipping_range),
        "cameraProjection": _pinhole(view).projection_matrix.reshape(16),
        "cameraViewTransform": np.asarray(view.world_to_camera, np.float64).reshape(16),
        "metersPerSceneUnit": float(view.meters_per_unit),
        "renderProductResolution": np.array([view.width, view.height], np.int32),
    }
    return dict(sorted(numbers.items()))


def _pinhole(view: CameraView) -> CameraView:
    if view.projection_type in LINEAR_PROJECTIONS:
        return view
    return dataclasses.replace(view, projection_type="pinhole")


def _attribute(view: CameraView, name: str, default: float) -> float:
    value = view.attributes.get(name)
    return float(default if value is None else value)


def _lens(view: CameraView, defaults: Mapping[str, float]) -> np.ndarray:
    return _floats(*(_attribute(view, name, default) for name, default in defaults.items()))


def _floats(*values: float) -> np.ndarray:
    return np.array(values, np.float32)
