"""Annotators of a stereo depth camera that is simulated from one view, as in Isaac Sim's SingleViewDepthSensor.

The camera is the left imager; distances, points and their colours are in the pixels of the right one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds import stereo
from usdsdg.annotators.kinds.depth_images import picture
from usdsdg.annotators.kinds.depth_sensor import ATTRIBUTES, measurement, parameter
from usdsdg.annotators.kinds.stereo import Measurement
from usdsdg.errors import warn_once

Params = Mapping[str, Any]

_VISUAL = "DepthSensorOutputVisualization"


@define("DepthSensorDistance", aovs=["distance_to_image_plane"], needs_path_tracing=True, dtype=np.float32)
def depth_sensor_distance(frame: Frame, params: Params) -> Annotation:
    """Measured distance along the optical axis [m], float32 (H, W); 0 where nothing is measured.

    Nothing is measured where the left imager does not see what the right one would, where its picture is too smooth
    (`confidenceThreshold`), nearer than `maxDisparityPixel` allows, and outside `minDistance` to `maxDistance`. Noise
    is a function of the seed, the frame and the render product.

    Raises:
        AnnotatorError: a parameter has a value that no sensor has.
        Unsupported: the camera is orthographic.
    """
    return Annotation(_announced(frame).distance)


@define(
    "DepthSensorPointCloudPosition",
    aovs=["distance_to_image_plane", "position"],
    needs_path_tracing=True,
    dtype=np.float32,
)
def depth_sensor_points(frame: Frame, params: Params) -> Annotation:
    """Measured points in the camera's frame [m], float32 (H, W, 4): x right, y up, -z ahead, 1; else 0 0 0 0.

    Each lies on the camera's ray to what is seen, at the measured distance: -z is DepthSensorDistance. Parameters and
    errors as there.
    """
    measured = _announced(frame)
    view = frame.camera
    points = frame.aov("position") @ view.world_to_camera[:3, :3] + view.world_to_camera[3, :3]
    points = stereo.look_up(points * view.meters_per_unit, measured.source)
    exact = stereo.look_up(frame.aov("distance_to_image_plane"), measured.source)
    scale = np.divide(measured.distance, exact, out=np.zeros_like(exact), where=exact > 0)
    out = np.zeros((*exact.shape, 4), np.float32)
    out[..., :3] = points * scale[..., None]
    out[..., 3] = measured.measured
    return Annotation(out)


@define("DepthSensorPointCloudColor", aovs=["distance_to_image_plane"], needs_path_tracing=True, dtype=np.uint8)
def depth_sensor_colors(frame: Frame, params: Params) -> Annotation:
    """Colour of each point of DepthSensorPointCloudPosition, uint8 (H, W, 4); 0 0 0 0 where there is none."""
    return Annotation(stereo.look_up(frame.aov("LdrColor"), _announced(frame).source))


@define("DepthSensorImager", needs_path_tracing=True, dtype=np.float32)
def depth_sensor_imager(frame: Frame, params: Params) -> Annotation:
    """What the left imager sees: luminance of the tone-mapped picture, 0 to 255, float32 (H, W)."""
    return Annotation(stereo.luminance(frame.aov("LdrColor")))


@define(_VISUAL, aovs=["distance_to_image_plane"], needs_path_tracing=True, dtype=np.uint8)
def depth_sensor_visualization(frame: Frame, params: Params) -> Annotation:
    """The picture that `rgbDepthOutputMode` asks for, uint8 (H, W, 4), black where nothing is measured.

    0: the camera's picture. 1: grey that repeats every metre. 2: grey from `minDistance` to `maxDistance`. 3: blue to
    red over that range. 4: as 2, of the exact depth. 5: as 2, before outliers are removed. 6: confidence in red, and
    the disparity as share of `maxDisparityPixel` in green. 7: that share in grey. 4, 6 and 7 are in the camera's
    pixels.
    """
    return Annotation(picture(frame))


def _announced(frame: Frame) -> Measurement:
    """The measurement, with what its parameters say besides."""
    measured = measurement(frame)
    if parameter(frame, "rgbDepthOutputMode") != 0:
        warn_once(
            f"{frame.render_product}: {ATTRIBUTES}rgbDepthOutputMode does not change the picture of 'rgb'; attach the "
            f"annotator {_VISUAL!r} to see it."
        )
    if parameter(frame, "showDistance"):
        height, width = frame.shape
        distance = measured.distance[height // 2, width // 2]
        frame.derive("shown distance", lambda: print(f"{frame.render_product}: {distance:.3f} m at the centre"))
    return measured
