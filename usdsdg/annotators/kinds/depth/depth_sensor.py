"""The depth sensor of a frame: its parameters and its measurement.

The parameters are the attributes `omni:rtx:post:depthSensor:...` of the render product (schema
`OmniSensorDepthSensorSingleViewAPI`); one that is not authored is the setting `/rtx/post/depthSensor/...`.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds.depth import stereo
from usdsdg.annotators.kinds.depth.stereo import DepthSensor, Measurement
from usdsdg.annotators.pixels.launch import Pixels
from usdsdg.errors import AnnotatorError, Unsupported, warn_once
from usdsdg.graph.sampling import generator, get_global_seed
from usdsdg.session.settings.store import DEFAULTS, get_settings
from usdsdg.session.stage_context import current_stage

ATTRIBUTES, SETTINGS = "omni:rtx:post:depthSensor:", "/rtx/post/depthSensor/"
MODES = range(8)


def measurement(frame: Frame, *, outliers: bool | None = None) -> Measurement:
    """Return the sensor's measurement, computed once per frame. outliers: whether to keep them; None: as authored."""
    return frame.derive(("depth sensor", outliers), lambda: _measure(frame, outliers))


def picture(frame: Frame) -> Pixels:
    """Return the luminance of the frame's color, float32 (H, W) from 0 to 255."""
    return frame.derive("luminance", lambda: stereo.luminance(frame.image("LdrColor")))


def _measure(frame: Frame, outliers: bool | None) -> Measurement:
    sensor = read_depth_sensor(frame)
    if outliers is not None:
        sensor = dataclasses.replace(sensor, outlier_removal_enabled=not outliers)
    if frame.camera.projection_type == "orthographic":
        raise Unsupported(
            f"{frame.camera.prim_path} is orthographic: parallel rays have no disparity. Use a perspective camera."
        )
    # No texture reaches what an infinitely low threshold asks for.
    seeing = sensor if _is_enabled(frame) else dataclasses.replace(sensor, confidence_threshold=-math.inf)
    confident = stereo.is_confident(seeing, picture(frame))
    rng = generator(get_global_seed(), "depth_sensor_noise", frame.index, frame.render_product)
    return stereo.measure(sensor, frame.image("distance_to_image_plane"), confident, rng)


def read_depth_sensor(frame: Frame) -> DepthSensor:
    """Read the parameters of the frame's render product.

    Raises:
        AnnotatorError: one is out of range.
    """
    sensor = DepthSensor(
        baseline_mm=parameter(frame, "baselineMM"),
        focal_length_pixel=parameter(frame, "focalLengthPixel"),
        sensor_size_pixel=parameter(frame, "sensorSizePixel"),
        max_disparity_pixel=parameter(frame, "maxDisparityPixel"),
        confidence_threshold=parameter(frame, "confidenceThreshold"),
        noise_mean=parameter(frame, "noiseMean"),
        noise_sigma=parameter(frame, "noiseSigma"),
        noise_downscale_factor_pixel=parameter(frame, "noiseDownscaleFactorPixel"),
        outlier_removal_enabled=bool(parameter(frame, "outlierRemovalEnabled")),
        min_distance=parameter(frame, "minDistance"),
        max_distance=parameter(frame, "maxDistance"),
    )
    faults = {
        "baselineMM": (sensor.baseline_mm == 0, "other than 0: two imagers in one place see no depth"),
        "focalLengthPixel": (not sensor.focal_length_pixel > 0, "above 0"),
        "sensorSizePixel": (not sensor.sensor_size_pixel > 0, "above 0"),
        "noiseDownscaleFactorPixel": (not sensor.noise_downscale_factor_pixel >= 1, "of at least 1"),
        "rgbDepthOutputMode": (parameter(frame, "rgbDepthOutputMode") not in MODES, "from 0 to 7"),
    }
    for name, (wrong, expected) in faults.items():
        if wrong:
            value = parameter(frame, name)
            raise AnnotatorError(
                f"{frame.render_product}: {ATTRIBUTES}{name} is {value:g}; expected a number {expected}."
            )
    return sensor


def parameter(frame: Frame, name: str) -> float:
    """Return the authored attribute, or else the setting, or else its default."""
    authored = _authored(frame, name)
    if authored is None:
        authored = get_settings().get(SETTINGS + name)
    return float(DEFAULTS[SETTINGS + name] if authored is None else authored)


def _authored(frame: Frame, name: str) -> Any:
    stage = current_stage()
    product = stage.GetPrimAtPath(frame.render_product)
    attribute = product.GetAttribute(ATTRIBUTES + name) if product else None
    if not attribute or not attribute.HasAuthoredValue():
        return None
    return attribute.Get(frame.queries.time)


def _is_enabled(frame: Frame) -> bool:
    """Return whether the sensor measures: it does unless the attribute is authored as false."""
    enabled = _authored(frame, "enabled") is not False
    if not enabled:
        warn_once(
            f"{frame.render_product}: the depth sensor measures nothing, as {ATTRIBUTES}enabled is false. Set it to "
            "true."
        )
    return enabled
