"""Visualizations of a depth sensor: the modes of `rgbDepthOutputMode`."""

from __future__ import annotations

import numpy as np

from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds.depth import stereo
from usdsdg.annotators.kinds.depth.depth_sensor import measurement, parameter, picture, read_depth_sensor
from usdsdg.annotators.kinds.depth.stereo import DepthSensor
from usdsdg.annotators.pixels.launch import Pixels, on_host

# From near to far: blue, cyan, green, yellow, red.
_RAINBOW = np.array([[0, 0, 255], [0, 255, 255], [0, 255, 0], [255, 255, 0], [255, 0, 0]], np.float64)


def visualization(frame: Frame) -> Pixels:
    """Return the visualization, uint8 (H, W, 4); see `depth_sensor_visualization` for the modes."""
    mode = int(parameter(frame, "rgbDepthOutputMode"))
    sensor, measured = read_depth_sensor(frame), measurement(frame)
    if mode == 0:
        return frame.image("LdrColor")
    exact = frame.aov("distance_to_image_plane")
    if mode == 1:
        return _gray(on_host(measured.distance) % 1, measured.measured)
    if mode == 2:
        return _gray(_fraction(sensor, on_host(measured.distance)), measured.measured)
    if mode == 3:
        return _rainbow(_fraction(sensor, on_host(measured.distance)), measured.measured)
    if mode == 4:
        return _gray(_fraction(sensor, exact), np.isfinite(exact))
    if mode == 5:
        raw = measurement(frame, outliers=True)
        return _gray(_fraction(sensor, on_host(raw.distance)), raw.measured)
    fraction = on_host(measured.disparity) * sensor.sensor_size_pixel / exact.shape[1] / sensor.max_disparity_pixel
    if mode == 7:
        return _gray(fraction, np.isfinite(exact))
    confidence = stereo.confidence(sensor, picture(frame))
    return _opaque(np.stack([confidence, np.where(np.isfinite(exact), fraction, 0), np.zeros_like(fraction)], -1))


def _fraction(sensor: DepthSensor, distance: np.ndarray) -> np.ndarray:
    """Map distances linearly: 0 at `min_distance`, 1 at `max_distance`."""
    return (distance - sensor.min_distance) / max(sensor.max_distance - sensor.min_distance, 1e-9)


def _gray(values: np.ndarray, shown: np.ndarray) -> np.ndarray:
    return _opaque(np.repeat(np.where(shown, values, 0)[..., None], 3, axis=2))


def _rainbow(values: np.ndarray, shown: np.ndarray) -> np.ndarray:
    stops = np.linspace(0, 1, len(_RAINBOW))
    colors = np.stack([np.interp(values, stops, _RAINBOW[:, channel]) for channel in range(3)], -1) / 255
    return _opaque(np.where(shown[..., None], colors, 0))


def _opaque(colors: np.ndarray) -> np.ndarray:
    """Convert (H, W, 3) from 0 to 1 to uint8 RGBA with alpha 255."""
    out = np.full((*colors.shape[:2], 4), 255, np.uint8)
    out[..., :3] = np.clip(colors, 0, 1) * 255 + 0.5
    return out
