"""A stereo depth camera computed from one view: disparity, noise, reprojection to the second imager, confidence.

Follows the documentation of the single-view depth camera of Omniverse's camera extension; where that leaves a choice
open, the docstring of the function says so. Depths are in meters.
"""

from dataclasses import dataclass

import numpy as np

from usdsdg.annotators.pixels import look_ups
from usdsdg.annotators.pixels.launch import band_of, run
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.colors import LUMINANCE

_LUMINANCE = LUMINANCE.astype(np.float32)


@dataclass(frozen=True)
class DepthSensor:
    """A pair of imagers, of which the first is the camera; names and units are those of the schema."""

    baseline_mm: float  # from the first imager to the second; positive is to the right
    focal_length_pixel: float  # of a sensor with
    sensor_size_pixel: float  # this width
    max_disparity_pixel: float  # of that sensor; nearer points, with a larger disparity, are not measured
    confidence_threshold: float  # 1 measures any surface; lower values require more texture
    noise_mean: float  # quantization step of the disparity [pixels of the image]; 0: neither steps nor noise
    noise_sigma: float  # standard deviation of the disparity [pixels of the image]
    noise_downscale_factor_pixel: float  # side of the blocks that share a deviation [pixels of the image]
    outlier_removal_enabled: bool
    min_distance: float  # distances outside of the range are not measured
    max_distance: float

    def disparity_times_depth(self, width: int) -> float:
        """Return disparity times depth [pixels of an image of `width` columns, meters]."""
        return abs(self.focal_length_pixel * self.baseline_mm * 1e-3) * width / self.sensor_size_pixel


@dataclass(frozen=True)
class Measurement:
    """The measurement of each pixel of the second imager."""

    source: np.ndarray  # (H, W) int32: flat index of the camera's pixel that it shows; -1 not measured
    disparity: np.ndarray  # (H, W) float64 [pixels of the image] of each of the camera's pixels, with noise
    distance: np.ndarray  # (H, W) float32 [meters] along the optical axis; 0 not measured

    @property
    def measured(self) -> np.ndarray:
        """(H, W) bool."""
        return self.source >= 0


def measure(sensor: DepthSensor, depth: np.ndarray, confident: np.ndarray, rng: np.random.Generator) -> Measurement:
    """Simulate the measurement of the stereo pair.

    Args:
        depth: (H, W) along the optical axis [meters]; +inf where nothing is hit, negative behind a very wide lens.
        confident: (H, W) bool, from `is_confident`.
        rng: source of the noise.
    """
    from usdsdg.annotators.pixels import stereo_kernels as kernels  # imports Warp

    pair = kernels.Pair()
    pair.disparity_times_depth, pair.baseline = sensor.disparity_times_depth(depth.shape[1]), sensor.baseline_mm
    pair.step, pair.sigma, pair.block = abs(sensor.noise_mean), sensor.noise_sigma, sensor.noise_downscale_factor_pixel
    pair.least, pair.most = sensor.min_distance, sensor.max_distance
    pair.sensor_size, pair.most_disparity = sensor.sensor_size_pixel, sensor.max_disparity_pixel
    disparity, distance = (np.empty(depth.shape) for _ in range(2))
    nearest, source = np.empty(depth.shape, np.float32), np.empty(depth.shape, np.int32)
    inputs = [pair, depth.astype(np.float32, copy=False), confident, _deviations(sensor, depth.shape, rng)]
    outputs = [disparity, distance, nearest, source]
    height, width = depth.shape
    run(kernels.match_rows, (height,), inputs, outputs, band=band_of(height, width))
    if sensor.outlier_removal_enabled:
        source = without_outliers(source, distance)
    return Measurement(source, disparity, look_up(distance.astype(np.float32), source))


def look_up(of_camera: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Return values (H, W, ...), of 4 bytes, of the camera's pixels in the second imager's image, 0 for none."""
    flat = of_camera.reshape(source.size, *of_camera.shape[2:])
    return look_ups.look_up(source, np.concatenate([flat, np.zeros_like(flat[:1])]))


def _deviations(sensor: DepthSensor, shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Return normal deviations of blocks of pixels; none where the sensor has neither steps nor noise."""
    if sensor.noise_mean == 0:
        return np.zeros((0, 0))
    rows, columns = (int((size - 1) / sensor.noise_downscale_factor_pixel) + 1 for size in shape)
    return rng.standard_normal((rows, columns))


def without_outliers(source: np.ndarray, read: np.ndarray) -> np.ndarray:
    """Make isolated pixels of `source` match their neighbors, as the setting is described.

    A gap of one column, which reprojection leaves in surfaces, takes the farther of the pixels to its left and right; a
    measured pixel without a measured one among its eight neighbors is removed. read: distance of the camera's pixels.
    """
    from usdsdg.annotators.pixels import stereo_kernels as kernels

    mended = np.empty(source.shape, np.int32)
    inputs = [source.astype(np.int32, copy=False), read.astype(np.float64, copy=False)]
    run(kernels.mend_isolated, source.shape, inputs, [mended])
    return mended


def points_of(view: CameraView, measured: Measurement, depth: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return measured points in the camera's frame [m], float32 (H, W, 4) with 1, or 0 0 0 0 where nothing is measured.

    depth: along the optical axis [m]. position: (H, W, 3) in the world.
    """
    from usdsdg.annotators.pixels import stereo_kernels as kernels

    points = np.empty((*depth.shape, 4), np.float32)
    to_camera = kernels.wp.mat44d(*view.world_to_camera.reshape(-1).tolist())
    inputs = [measured.source, measured.distance, depth, position, to_camera, float(view.meters_per_unit)]
    run(kernels.place_points, (depth.size,), inputs, [points])
    return points


def luminance(color: np.ndarray) -> np.ndarray:
    """Return the luminance of an 8-bit image (H, W, 3 or 4), float32 (H, W) from 0 to 255."""
    return color[..., :3].astype(np.float32) @ _LUMINANCE


def texture(gray: np.ndarray) -> np.ndarray:
    """Return (H, W) float32, 0 to 1: the Sobel gradient of the luminance [gray levels], clipped at 1."""
    from usdsdg.annotators.pixels import stereo_kernels as kernels

    found = np.empty(gray.shape, np.float32)
    height, width = gray.shape
    inputs = [gray.astype(np.float32, copy=False)]
    run(kernels.find_texture, (height,), inputs, [found], band=band_of(height, width))
    return found


def confidence(sensor: DepthSensor, gray: np.ndarray) -> np.ndarray:
    """Return (H, W) float32: the texture times `confidence_threshold`, as the confidence map is documented."""
    return texture(gray) * np.float32(sensor.confidence_threshold)


def is_confident(sensor: DepthSensor, gray: np.ndarray) -> np.ndarray:
    """Return (H, W) bool: where the surface has enough texture to be matched.

    The documentation says that lower thresholds reject more smooth surfaces, but gives no formula: here the texture
    must reach 1 - `confidence_threshold`.
    """
    return texture(gray) >= 1 - sensor.confidence_threshold
