"""A stereo depth camera computed from one view: disparity, noise, reprojection to the second imager, confidence.

Follows the documentation of the single-view depth camera of Omniverse's camera extension; where that leaves a choice
open, the docstring of the function says so. Depths are in meters.
"""

from dataclasses import dataclass

import numpy as np

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

    source: np.ndarray  # (H, W) int64: flat index of the camera's pixel that it shows; -1 not measured
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
    disparity_times_depth = sensor.disparity_times_depth(depth.shape[1])
    depth = np.where(depth > 0, depth, np.inf)
    exact = disparity_times_depth / depth.astype(np.float64)
    source = reprojected(depth, np.copysign(exact, sensor.baseline_mm))
    disparity = noisy(sensor, exact, rng)
    with np.errstate(divide="ignore"):
        measured = disparity_times_depth / disparity
    # Points that cannot be measured still occlude others, so they are removed only after reprojection.
    within = (measured >= sensor.min_distance) & (measured <= sensor.max_distance)
    within &= np.isfinite(measured) & np.isfinite(depth)
    within &= disparity * sensor.sensor_size_pixel <= sensor.max_disparity_pixel * depth.shape[1]
    source = np.where(look_up(within & confident, source), source, -1)
    if sensor.outlier_removal_enabled:
        source = without_outliers(source, measured)
    return Measurement(source, disparity, look_up(measured, source).astype(np.float32))


def look_up(of_camera: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Return (H, W, ...) values of the camera's pixels in the second imager's image, 0 where it shows none."""
    flat = of_camera.reshape(source.size, *of_camera.shape[2:])
    values = flat[source]
    values[source < 0] = 0
    return values


def noisy(sensor: DepthSensor, disparity: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Quantize the disparity in steps of `noise_mean`, add normal noise of `noise_sigma`, and clip at 0."""
    step = abs(sensor.noise_mean)
    if step == 0:
        return disparity
    height, width = disparity.shape
    rows, columns = (
        (np.arange(size) / sensor.noise_downscale_factor_pixel).astype(np.int64) for size in (height, width)
    )
    deviations = rng.standard_normal((rows[-1] + 1, columns[-1] + 1)) * sensor.noise_sigma
    return np.maximum(np.rint(disparity / step) * step + deviations[np.ix_(rows, columns)], 0)


def reprojected(depth: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Return (H, W) int64: the flat index of the camera's pixel that each pixel of the second imager shows; -1 none.

    A pixel moves `shift` columns to the left, as its point does in the image of an imager on the right; the nearest of
    those that coincide is visible. Noise is not included: a matching error changes the distance, not the position.
    """
    height, width = depth.shape
    columns = np.floor(np.arange(width) + 0.5 - shift).astype(np.int64)
    inside = (columns >= 0) & (columns < width)
    source = np.flatnonzero(inside)
    target = (columns + np.arange(height)[:, None] * width)[inside]
    near = depth[inside]
    nearest = np.full(depth.size, np.inf, depth.dtype)
    np.minimum.at(nearest, target, near)
    seen = nearest[target] == near
    found = np.full(depth.size, -1, np.int64)
    found[target[seen]] = source[seen]
    return found.reshape(depth.shape)


def without_outliers(source: np.ndarray, read: np.ndarray) -> np.ndarray:
    """Make isolated pixels of `source` match their neighbors, as the setting is described.

    A gap of one column, which reprojection leaves in surfaces, takes the farther of the pixels to its left and right; a
    measured pixel without a measured one among its eight neighbors is removed.
    """
    from scipy import ndimage

    has = source >= 0
    left, right = np.roll(source, 1, 1), np.roll(source, -1, 1)
    gap = ~has & (left >= 0) & (right >= 0)
    gap[:, [0, -1]] = False
    farther = np.where(read.ravel()[left] >= read.ravel()[right], left, right)
    around = ndimage.maximum_filter(has, footprint=_AROUND, mode="constant", cval=0)
    return np.where(gap, farther, np.where(has & np.logical_not(around), -1, source))


_AROUND = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], bool)


def luminance(color: np.ndarray) -> np.ndarray:
    """Return the luminance of an 8-bit image (H, W, 3 or 4), float32 (H, W) from 0 to 255."""
    return color[..., :3].astype(np.float32) @ _LUMINANCE


def texture(gray: np.ndarray) -> np.ndarray:
    """Return (H, W) float32, 0 to 1: the Sobel gradient of the luminance [gray levels], clipped at 1."""
    from scipy import ndimage

    return np.minimum(np.hypot(ndimage.sobel(gray, 0, mode="nearest"), ndimage.sobel(gray, 1, mode="nearest")), 1)


def confidence(sensor: DepthSensor, gray: np.ndarray) -> np.ndarray:
    """Return (H, W) float32: the texture times `confidence_threshold`, as the confidence map is documented."""
    return texture(gray) * np.float32(sensor.confidence_threshold)


def is_confident(sensor: DepthSensor, gray: np.ndarray) -> np.ndarray:
    """Return (H, W) bool: where the surface has enough texture to be matched.

    The documentation says that lower thresholds reject more smooth surfaces, but gives no formula: here the texture
    must reach 1 - `confidence_threshold`.
    """
    return texture(gray) >= 1 - sensor.confidence_threshold
