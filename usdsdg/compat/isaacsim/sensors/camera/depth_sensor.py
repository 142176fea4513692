"""`SingleViewDepthSensor`: a camera whose render product measures depth as a stereo camera does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pxr import Usd

from usdsdg.compat.isaacsim.sensors.camera.camera import Camera
from usdsdg.errors import warn_once
from usdsdg.session.stage_context import current_stage

SCHEMA = "OmniSensorDepthSensorSingleViewAPI"
PREFIX = "omni:rtx:post:depthSensor:"


def _setting(name: str, default: Any, meaning: str) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return the getter and the setter of an attribute of the render product."""

    def getter(self: SingleViewDepthSensor) -> Any:
        product = self._product_prim()
        return product.GetAttribute(PREFIX + name).Get() if product else None

    def setter(self: SingleViewDepthSensor, value: Any = default) -> None:
        if product := self._product_prim():
            product.GetAttribute(PREFIX + name).Set(type(default)(value))
        else:
            warn_once(f"SingleViewDepthSensor {self.prim_path}: call initialize() before {name} is set")

    getter.__doc__ = f"Return {meaning}; None before `initialize`."
    setter.__doc__ = f"Set {meaning}."
    return getter, setter


class SingleViewDepthSensor(Camera):
    """A camera that measures depth from disparity, with the annotators `DepthSensor...`.

    `initialize` applies `OmniSensorDepthSensorSingleViewAPI` to its render product; the methods below read and set the
    attributes of this schema.
    """

    def initialize(self, physics_sim_view: object = None, attach_rgb_annotator: bool = False) -> None:
        """Make the render product, which measures depth; after a world is reset."""
        made = self._product_prim()
        super().initialize(physics_sim_view, attach_rgb_annotator)
        if not made:
            self.set_enabled(True)

    def _product_prim(self) -> Usd.Prim | None:
        """Return the render product with the schema; None before `initialize`."""
        if not self._ends:
            return None
        product = current_stage().GetPrimAtPath(self._render_product_path)
        if product and SCHEMA not in product.GetAppliedSchemas():
            product.ApplyAPI(SCHEMA)
        return product or None

    get_enabled, set_enabled = _setting("enabled", False, "whether the sensor measures")
    get_baseline_mm, set_baseline_mm = _setting("baselineMM", 55.0, "the distance of the two imagers [mm]")
    get_focal_length_pixel, set_focal_length_pixel = _setting(
        "focalLengthPixel", 897.0, "the focal length [pixels of the sensor]"
    )
    get_sensor_size_pixel, set_sensor_size_pixel = _setting(
        "sensorSizePixel", 1280.0, "the width of the sensor [pixels]"
    )
    get_max_disparity_pixel, set_max_disparity_pixel = _setting(
        "maxDisparityPixel", 110.0, "the greatest disparity that is found [pixels]"
    )
    get_confidence_threshold, set_confidence_threshold = _setting(
        "confidenceThreshold", 0.95, "the threshold below which a pixel counts as measured"
    )
    get_noise_mean, set_noise_mean = _setting("noiseMean", 0.25, "the mean of the noise of disparities [pixels]")
    get_noise_sigma, set_noise_sigma = _setting("noiseSigma", 0.25, "its standard deviation [pixels]")
    get_noise_downscale_factor_pixel, set_noise_downscale_factor_pixel = _setting(
        "noiseDownscaleFactorPixel", 1.0, "the side of the squares that share one draw of noise [pixels]"
    )
    get_outlier_removal_enabled, set_outlier_removal_enabled = _setting(
        "outlierRemovalEnabled", True, "whether outliers are removed"
    )
    get_min_distance, set_min_distance = _setting("minDistance", 0.5, "the least distance that is measured [m]")
    get_max_distance, set_max_distance = _setting("maxDistance", 1e7, "the greatest distance [m]")
    get_rgb_depth_output_mode, set_rgb_depth_output_mode = _setting(
        "rgbDepthOutputMode", 0, "what the debug image shows, 0 to 7"
    )
    get_show_distance, set_show_distance = _setting("showDistance", False, "whether the debug image shows distances")
