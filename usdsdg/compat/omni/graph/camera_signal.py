"""The signal of a camera's sensor and its image processor, as `omni.sensors.nv.camera` describes the steps.

Only its documentation is public, not its arithmetic: each function says what is computed here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdsdg.errors import ArgumentError

# Interpolation of a missing color from the pixels around it that have it.
_NEAR = np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]], np.float64)
_FORMATS = {"UINT8": np.uint8, "UINT16": np.uint16, "FLOAT16": np.float16, "FLOAT32": np.float32}


@dataclass(frozen=True)
class Signal:
    """An image (H, W) or (H, W, 3 or 4) and the value that stands for white in it."""

    pixels: np.ndarray
    white: float = 1.0


def color_correction(
    image: Signal,
    *,
    matrix: np.ndarray,
    white_balance: Sequence[float],
    black: float,
    fullwell_black: float,
    swap_red_blue: bool,
    half: bool,
) -> Signal:
    """Multiply colors by a matrix (3, 3), row vectors, then by gains; limit them to 0..fullwell_black and add black.

    Returns float16 (H, W, 4) if `half`, else uint8 with white at 255.
    """
    rgba = image.pixels.astype(np.float32) / image.white
    color = np.clip(rgba[..., :3] @ matrix * np.asarray(white_balance), 0.0, fullwell_black) + black
    if swap_red_blue:
        color = color[..., ::-1]
    corrected = np.concatenate([color, rgba[..., 3:]], axis=-1)
    if half:
        return Signal(corrected.astype(np.float16))
    return Signal(np.round(255 * np.clip(corrected, 0, 1)).astype(np.uint8), 255.0)


def mosaic(
    image: Signal, *, filters: Sequence[Sequence[float]], white: int, flip_horizontal: bool, flip_vertical: bool
) -> Signal:
    """Read each pixel through one of four color filters (r, g, b weights), which repeat every 2 x 2 pixels.

    filters: those at (row, column) 0 0, 0 1, 1 0, 1 1. Returns whole numbers (H, W), uint16 or, for more than 16 bits,
    uint32; they saturate at `white`.
    """
    color = image.pixels[..., :3].astype(np.float64) / image.white
    color = color[:: -1 if flip_vertical else 1, :: -1 if flip_horizontal else 1]
    raw = np.empty(color.shape[:2])
    for place, weights in enumerate(filters):
        row, column = divmod(place, 2)
        raw[row::2, column::2] = color[row::2, column::2] @ np.asarray(weights, np.float64)
    return _whole(raw * white, white)


def noise(
    image: Signal, *, dark_gain: float, dark_sigma: float, zones: Sequence[Sequence[float]], rng: np.random.Generator
) -> Signal:
    """Add photon shot noise, a Poisson distribution, and dark noise, normal with deviation dark_gain x dark_sigma.

    zones: (gain [value per electron], upper limit [value]) of exposures that are combined to one of a high dynamic
        range; values above all limits belong to the last.
    """
    values = image.pixels.astype(np.float64)
    table = np.array(sorted(zones, key=lambda zone: zone[1]), np.float64).reshape(-1, 2)
    if len(table):
        zone = np.minimum(np.searchsorted(table[:, 1], values), len(table) - 1)
        gains = np.maximum(table[zone, 0], 1e-12)
        values = rng.poisson(np.minimum(values / gains, 1e15)) * gains
    return _whole(values + dark_gain * dark_sigma * rng.standard_normal(values.shape), image.white)


def compand(
    image: Signal, *, curve: Sequence[Sequence[float]], before: float, after: float, alignment: int | None
) -> Signal:
    """Compress values by a piecewise linear curve of (value, compressed value).

    before, after: pedestals that are added. alignment: the bit, from 0, to which the highest bit of the output is
    shifted; None shifts nothing.
    """
    points = _curve(curve)
    compressed = np.interp(image.pixels + before, points[:, 0], points[:, 1]) + after
    shift = _shift(points[:, 1].max(), alignment)
    return _whole(np.round(compressed) * 2.0**shift, points[:, 1].max() * 2.0**shift)


def decompand(
    image: Signal, *, curve: Sequence[Sequence[float]], before: float, after: float, alignment: int | None
) -> Signal:
    """Undo `compand`: by a curve of (compressed value, value), or by the same curve as was given to `compand`."""
    points = _curve(curve)
    if points[-1, 1] < points[-1, 0]:  # it compresses
        points = points[:, ::-1]
    shift = _shift(points[:, 0].max(), alignment)
    values = np.interp(image.pixels / 2.0**shift - after, points[:, 0], points[:, 1]) - before
    return _whole(values, points[:, 1].max())


def demosaic(image: Signal, *, grid: str, output: str) -> Signal:
    """Return the image (H, W, 4) of a mosaic; `grid` names the colors of 2 x 2 pixels, row by row, such as "RGGB".

    A color that a pixel lacks is the weighted mean of its eight neighbors that have it.

    Raises:
        ArgumentError: `grid` is not of two green, one red and one blue pixel, or `output` is no format.
    """
    if sorted(grid) != sorted("RGGB"):
        raise ArgumentError(f"demosaicing: the grid is {grid!r}; expected RGGB, BGGR, GBRG or GRBG")
    raw = image.pixels.astype(np.float64) / image.white
    rgba = np.ones((*raw.shape, 4))
    for channel, color in enumerate("RGB"):
        has = np.zeros(raw.shape)
        for place, letter in enumerate(grid):
            if letter == color:
                has[place // 2 :: 2, place % 2 :: 2] = 1.0
        rgba[..., channel] = _spread(raw * has) / np.maximum(_spread(has), 1e-12)
    return in_format(Signal(rgba), output)


def in_format(image: Signal, output: str, *, gamma: bool = False) -> Signal:
    """Convert an image to "UINT8", "UINT16", "FLOAT16" or "FLOAT32", with white at the highest whole number or at 1.

    gamma: encode colors for displays, with sRGB's exponent of 1 / 2.2.

    Raises:
        ArgumentError: there is no such format.
    """
    if output not in _FORMATS:
        raise ArgumentError(f"camera image: {output!r} is no format; expected {', '.join(_FORMATS)}")
    values = np.clip(image.pixels.astype(np.float64) / image.white, 0.0, 1.0)
    if gamma:
        values[..., :3] **= 1 / 2.2
    kind = np.dtype(_FORMATS[output])
    if kind.kind == "f":
        return Signal(values.astype(kind))
    white = float(np.iinfo(kind).max)
    return Signal(np.round(values * white).astype(kind), white)


def _spread(values: np.ndarray) -> np.ndarray:
    """Return the sums of the 3 x 3 neighborhoods, weighted by `_NEAR`; nothing is outside of the image."""
    height, width = values.shape
    padded = np.pad(values, 1)
    parts = (_NEAR[y, x] * padded[y : y + height, x : x + width] for y in range(3) for x in range(3))
    return sum(parts, np.zeros(values.shape))


def _whole(values: np.ndarray, white: float) -> Signal:
    kind = np.uint16 if white <= np.iinfo(np.uint16).max else np.uint32
    return Signal(np.clip(np.round(values), 0, white).astype(kind), float(white))


def _curve(points: Sequence[Sequence[float]]) -> np.ndarray:
    curve = np.array(points, np.float64).reshape(-1, 2)
    if len(curve) < 2 or (np.diff(curve, axis=0) < 0).any():
        raise ArgumentError(f"companding: the curve needs two or more points (x, y) that rise; got {points!r}")
    return curve


def _shift(highest: float, alignment: int | None) -> int:
    return 0 if alignment is None else int(alignment) - (int(highest).bit_length() - 1)
