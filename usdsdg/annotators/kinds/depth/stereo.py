"""A stereo depth camera computed from one view: disparity, noise, reprojection to the second imager, confidence.

Follows the documentation of the single-view depth camera of Omniverse's camera extension; where that leaves a choice
open, the docstring of the function says so. Depths are in meters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdsdg.annotators.pixels.launch import Pixels, band_of, channels_of, new, on_host, placed, run, run_over_pixels
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.colors import LUMINANCE

_NO_IMAGE = np.zeros((0, 0), np.float32)


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
    """The measurement of each pixel of the second imager, where the depth image is."""

    source: Pixels  # (H, W) int32: flat index of the camera's pixel that it shows; -1 not measured
    disparity: Pixels  # (H, W) float64 [pixels of the image] of each of the camera's pixels, with noise
    distance: Pixels  # (H, W) float32 [meters] along the optical axis; 0 not measured

    @property
    def measured(self) -> np.ndarray:
        """(H, W) bool, on the host."""
        return on_host(self.source) >= 0


def measure(sensor: DepthSensor, depth: Pixels, confident: Pixels, rng: np.random.Generator) -> Measurement:
    """Simulate the measurement of the stereo pair.

    Args:
        depth: (H, W) along the optical axis [meters]; +inf where nothing is hit, negative behind a very wide lens.
        confident: (H, W) bool, from `is_confident`.
        rng: source of the noise.
    """
    from usdsdg.annotators.pixels import stereo_kernels as kernels  # imports Warp

    height, width = depth.shape
    pair = kernels.Pair()
    pair.disparity_times_depth, pair.baseline = sensor.disparity_times_depth(width), sensor.baseline_mm
    pair.step, pair.sigma, pair.block = abs(sensor.noise_mean), sensor.noise_sigma, sensor.noise_downscale_factor_pixel
    pair.least, pair.most = sensor.min_distance, sensor.max_distance
    pair.sensor_size, pair.most_disparity = sensor.sensor_size_pixel, sensor.max_disparity_pixel
    kinds = (np.float64, np.float64, np.float32, np.int32)
    disparity, distance, nearest, source = (new((height, width), kind, depth) for kind in kinds)
    inputs = [pair, depth, confident, _deviations(sensor, (height, width), rng)]
    run(kernels.match_rows, (height,), inputs, [disparity, distance, nearest, source], band=band_of(height, width))
    mended, measured = _read(source, distance, mends=sensor.outlier_removal_enabled)
    return Measurement(mended, disparity, measured)


def _read(source: Pixels, distance: Pixels, *, mends: bool) -> tuple[Pixels, Pixels]:
    """Return the source of each pixel, isolated ones mended if asked, and the distance that is measured there."""
    from usdsdg.annotators.pixels import stereo_kernels as kernels

    mended, measured = (new(source.shape, kind, source) for kind in (np.int32, np.float32))
    run_over_pixels(
        kernels.read_distances, source.size, [source, distance, int(mends), *source.shape], [mended, measured]
    )
    return mended, measured


def look_up(of_camera: Pixels, source: Pixels) -> Pixels:
    """Return colors (H, W, 4) of 8 bits of the camera's pixels in the second imager's image, 0 for none."""
    from usdsdg.annotators.pixels import stereo_kernels as kernels

    found = new((*source.shape, 4), np.uint8, source)
    run(kernels.move_colors, (source.size,), [of_camera, source], [found])
    return found


def _deviations(sensor: DepthSensor, shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Return normal deviations of blocks of pixels; none where the sensor has neither steps nor noise."""
    if sensor.noise_mean == 0:
        return np.zeros((0, 0))
    rows, columns = (int((size - 1) / sensor.noise_downscale_factor_pixel) + 1 for size in shape)
    return rng.standard_normal((rows, columns))


def points_of(view: CameraView, measured: Measurement, depth: Pixels, position: Pixels) -> Pixels:
    """Return measured points in the camera's frame [m], float32 (H, W, 4) with 1, or 0 0 0 0 where nothing is measured.

    depth: along the optical axis [m]. position: (H, W, 3) in the world.
    """
    from usdsdg.annotators.pixels import stereo_kernels as kernels

    points = new((*depth.shape, 4), np.float32, depth)
    to_camera = kernels.wp.mat44d(*view.world_to_camera.reshape(-1).tolist())
    inputs = [measured.source, measured.distance, depth, position, to_camera, float(view.meters_per_unit)]
    run(kernels.place_points, (depth.size,), inputs, [points])
    return points


def luminance(color: Pixels) -> Pixels:
    """Return the luminance of an 8-bit image (H, W, 3 or 4), float32 (H, W) from 0 to 255."""
    from usdsdg.annotators.pixels import texture_kernels as kernels

    gray = new(color.shape[:2], np.float32, color)
    inputs = [color, channels_of(color), kernels.wp.vec3(*LUMINANCE.tolist())]
    run_over_pixels(kernels.weigh_colors, gray.size, inputs, [gray])
    return gray


def texture(gray: Pixels) -> Pixels:
    """Return (H, W) float32, 0 to 1: the Sobel gradient of the luminance [gray levels], clipped at 1."""
    found = new(gray.shape, np.float32, gray)
    _find_texture(gray, 0.0, found)
    return found


def _find_texture(gray: Pixels, least: float, texture: Pixels) -> Pixels:
    """Fill in the texture, if it is not empty, and return (H, W) bool: where it is at least that."""
    from usdsdg.annotators.pixels import texture_kernels as kernels

    height, width = gray.shape
    is_textured = new((height, width), np.bool_, gray)
    run(kernels.find_texture, (height,), [gray, least], [texture, is_textured], band=band_of(height, width))
    return is_textured


def confidence(sensor: DepthSensor, gray: Pixels) -> np.ndarray:
    """Return (H, W) float32: the texture times `confidence_threshold`, as the confidence map is documented."""
    return on_host(texture(gray)) * np.float32(sensor.confidence_threshold)


def is_confident(sensor: DepthSensor, gray: Pixels) -> Pixels:
    """Return (H, W) bool: where the surface has enough texture to be matched.

    The documentation says that lower thresholds reject more smooth surfaces, but gives no formula: here the texture
    must reach 1 - `confidence_threshold`.
    """
    return _find_texture(gray, 1 - sensor.confidence_threshold, placed(_NO_IMAGE, gray))
