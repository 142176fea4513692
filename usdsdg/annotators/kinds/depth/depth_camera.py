"""Annotators of a stereo depth camera that is simulated from one view, as in Isaac Sim's SingleViewDepthSensor.

The camera is the left imager; distances, points and their colors are in the pixels of the right imager.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds.depth import stereo
from usdsdg.annotators.kinds.depth.depth_images import visualization
from usdsdg.annotators.kinds.depth.depth_sensor import ATTRIBUTES, measurement, parameter, picture
from usdsdg.annotators.kinds.depth.stereo import Measurement
from usdsdg.annotators.pixels.launch import on_host
from usdsdg.errors import warn_once

Params = Mapping[str, Any]

_VISUAL = "DepthSensorOutputVisualization"


@define("DepthSensorDistance", aovs=["distance_to_image_plane"], needs_path_tracing=True, dtype=np.float32)
def depth_sensor_distance(frame: Frame, params: Params) -> Annotation:
    """Measured distance along the optical axis [m], float32 (H, W); 0 where nothing is measured.

    Nothing is measured at points that the left imager does not see, where its image has too little texture
    (`confidenceThreshold`), nearer than `maxDisparityPixel` allows, and outside `minDistance` to `maxDistance`. Noise
    is a function of the seed, the frame and the render product.

    Raises:
        AnnotatorError: a parameter is out of range.
        Unsupported: the camera is orthographic.
    """
    return Annotation(_measurement(frame).distance)


@define(
    "DepthSensorPointCloudPosition",
    aovs=["distance_to_image_plane", "position"],
    needs_path_tracing=True,
    dtype=np.float32,
)
def depth_sensor_points(frame: Frame, params: Params) -> Annotation:
    """Measured points in the camera's frame [m], float32 (H, W, 4): x right, y up, -z ahead, 1; else 0 0 0 0.

    Each lies on the camera's ray, at the measured distance: -z is DepthSensorDistance. Parameters and errors as there.
    """
    depth, position = frame.image("distance_to_image_plane"), frame.image("position")
    return Annotation(stereo.points_of(frame.camera, _measurement(frame), depth, position))


@define("DepthSensorPointCloudColor", aovs=["distance_to_image_plane"], needs_path_tracing=True, dtype=np.uint8)
def depth_sensor_colors(frame: Frame, params: Params) -> Annotation:
    """Color of each point of DepthSensorPointCloudPosition, uint8 (H, W, 4); 0 0 0 0 where there is none."""
    return Annotation(stereo.look_up(frame.image("LdrColor"), _measurement(frame).source))


@define("DepthSensorImager", needs_path_tracing=True, dtype=np.float32)
def depth_sensor_imager(frame: Frame, params: Params) -> Annotation:
    """Image of the left imager: luminance of the tone-mapped color, 0 to 255, float32 (H, W)."""
    return Annotation(picture(frame))


@define(_VISUAL, aovs=["distance_to_image_plane"], needs_path_tracing=True, dtype=np.uint8)
def depth_sensor_visualization(frame: Frame, params: Params) -> Annotation:
    """The visualization of `rgbDepthOutputMode`, uint8 (H, W, 4), black where nothing is measured.

    0: the camera's image. 1: gray that repeats every meter. 2: gray from `minDistance` to `maxDistance`. 3: blue to red
    over that range. 4: as 2, of the exact depth. 5: as 2, before outliers are removed. 6: confidence in red, and the
    disparity as a fraction of `maxDisparityPixel` in green. 7: that fraction in gray. 4, 6 and 7 are in the camera's
    pixels.
    """
    return Annotation(visualization(frame))


def _measurement(frame: Frame) -> Measurement:
    """Return the measurement; warn of or print what other parameters of the sensor ask for."""
    measured = measurement(frame)
    if parameter(frame, "rgbDepthOutputMode") != 0:
        warn_once(
            f"{frame.render_product}: {ATTRIBUTES}rgbDepthOutputMode does not change the image of 'rgb'; attach the "
            f"annotator {_VISUAL!r} to see it."
        )
    if parameter(frame, "showDistance"):
        height, width = frame.shape
        distance = on_host(measured.distance)[height // 2, width // 2]
        frame.derive("shown distance", lambda: print(f"{frame.render_product}: {distance:.3f} m at the center"))
    return measured
