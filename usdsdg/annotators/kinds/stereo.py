"""A stereo depth camera computed from one view: disparity, noise, the second imager's picture, confidence.

Follows the single-view depth camera of Omniverse's camera extension: what its page says of each step holds, and where
it leaves a choice open, the function that makes the choice says so. Arrays in, arrays out; depths in metres.
"""

from __future__ import annotations

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
    max_disparity_pixel: float  # of that sensor; what would be above, because it is near, is not measured
    confidence_threshold: float  # 1 measures any surface; the lower, the more texture it needs
    noise_mean: float  # step of the disparity [pixels of the picture]; 0: neither steps nor noise
    noise_sigma: float  # standard deviation of the disparity [pixels of the picture]
    noise_downscale_factor_pixel: float  # side of the blocks that share a deviation [pixels of the picture]
    outlier_removal_enabled: bool
    min_distance: float  # measured distances outside are left out
    max_distance: float

    def strength(self, width: int) -> float:
        """Disparity times depth [pixels of a picture of `width` columns, metres]."""
        return abs(self.focal_length_pixel * self.baseline_mm * 1e-3) * width / self.sensor_size_pixel


@dataclass(frozen=True)
class Measurement:
    """What the pair says of each pixel of the second imager."""

    source: np.ndarray  # (H, W) int64: index, row by row, of the camera's pixel that it shows; -1 not measured
    disparity: np.ndarray  # (H, W) float64 [pixels of the picture] of each of the camera's pixels, with noise
    distance: np.ndarray  # (H, W) float32 [metres] along the optical axis; 0 not measured

    @property
    def measured(self) -> np.ndarray:
        """(H, W) bool."""
        return self.source >= 0


def measure(sensor: DepthSensor, depth: np.ndarray, confident: np.ndarray, rng: np.random.Generator) -> Measurement:
    """What the pair measures.

    Args:
        depth: (H, W) along the optical axis [metres]; +inf where nothing is hit, below 0 beside a very wide lens.
        confident: (H, W) bool, as `is_confident` gives.
        rng: where the noise comes from.
    """
    strength = sensor.strength(depth.shape[1])
    depth = np.where(depth > 0, depth, np.inf)
    exact = strength / depth.astype(np.float64)
    source = reprojected(depth, np.copysign(exact, sensor.baseline_mm))
    disparity = noisy(sensor, exact, rng)
    with np.errstate(divide="ignore"):
        read = strength / disparity
    # What cannot be measured still hides what lies behind it, so it goes only now.
    within = (read >= sensor.min_distance) & (read <= sensor.max_distance) & np.isfinite(read) & np.isfinite(depth)
    within &= disparity * sensor.sensor_size_pixel <= sensor.max_disparity_pixel * depth.shape[1]
    source = np.where(look_up(within & confident, source), source, -1)
    if sensor.outlier_removal_enabled:
        source = without_outliers(source, read)
    return Measurement(source, disparity, look_up(read, source).astype(np.float32))


def look_up(of_camera: np.ndarray, source: np.ndarray) -> np.ndarray:
    """(H, W, ...): the values of the camera's pixels in the second imager's picture, 0 where it shows none of them."""
    flat = of_camera.reshape(source.size, *of_camera.shape[2:])
    values = flat[source]
    values[source < 0] = 0
    return values


def noisy(sensor: DepthSensor, disparity: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The disparity in steps of `noise_mean`, plus a normal deviation of `noise_sigma`; below 0 it is 0."""
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
    """(H, W) int64: which of the camera's pixels each pixel of the second imager shows, row by row; -1 none.

    A pixel moves `shift` columns to the left, as its point does in the picture of an imager on the right; of those that
    meet the nearest is seen. Noise is no part of it: an error of matching changes what is read, not where.
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
    """`source` with lone pixels made to match their neighbours, as the setting's description has it.

    A gap of one column, as reprojection leaves in a surface, takes the farther of the pixels to its left and right; a
    measured pixel with no measured one among the eight around it goes.
    """
    from scipy import ndimage

    has = source >= 0
    left, right = np.roll(source, 1, 1), np.roll(source, -1, 1)
    gap = ~has & (left >= 0) & (right >= 0)
    gap[:, [0, -1]] = False
    farther = np.where(read.ravel()[left] >= read.ravel()[right], left, right)
    around = ndimage.maximum_filter(has, footprint=_AROUND, mode="constant", cval=0)
    return np.where(gap, farther, np.where(has & ~around, -1, source))


_AROUND = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], bool)


def luminance(color: np.ndarray) -> np.ndarray:
    """(H, W) float32, 0 to 255, of an 8-bit picture (H, W, 3 or 4)."""
    return color[..., :3].astype(np.float32) @ _LUMINANCE


def texture(grey: np.ndarray) -> np.ndarray:
    """(H, W) float32, 0 to 1: Sobel's gradient of the luminance [grey levels], saturated."""
    from scipy import ndimage

    return np.minimum(np.hypot(ndimage.sobel(grey, 0, mode="nearest"), ndimage.sobel(grey, 1, mode="nearest")), 1)


def confidence(sensor: DepthSensor, grey: np.ndarray) -> np.ndarray:
    """(H, W) float32: the texture times `confidence_threshold`, as the page defines the confidence map."""
    return texture(grey) * np.float32(sensor.confidence_threshold)


def is_confident(sensor: DepthSensor, grey: np.ndarray) -> np.ndarray:
    """(H, W) bool: where the surface has enough texture to be matched.

    The page says that lower thresholds reject more of smooth surfaces, but not by which formula: here the texture must
    reach 1 - `confidence_threshold`.
    """
    return texture(grey) >= 1 - sensor.confidence_threshold
