"""AOVs in the types of images: four channels of float16, float32 or uint8.

Images are (H, W, channels) or, of numbers, (H, W); results have four channels unless said otherwise, and are where the
image is.
"""

from __future__ import annotations

import numpy as np

from usdsdg.annotators.pixels.launch import Pixels, channels_of, new, run_over_pixels

HALF_MAX = float(np.finfo(np.float16).max)
_NO_FLOATS, _NO_IDS = np.zeros(0, np.float32), np.zeros(0, np.int32)


def halves(image: Pixels, *, limit: float = np.inf, plus: Pixels = _NO_FLOATS, instance: Pixels = _NO_IDS) -> Pixels:
    """Return numbers or vectors as float16, with 1 in the fourth channel; numbers are the three others.

    limit: of values; larger ones than float16 has are infinite. plus: vectors that are added. instance: the AOV; the
        fourth channel is 0 where it is -1.
    """
    from usdsdg.annotators.pixels import encoding_kernels as kernels  # imports Warp

    found, pixels = _image_like(image, 4, np.float16)
    inputs = [_floats(image), channels_of(image), _floats(plus), instance, limit]
    run_over_pixels(kernels.halves, pixels, inputs, [found])
    return found


def floats(image: Pixels, fourth: float) -> Pixels:
    """Return vectors of two or three numbers as float32: missing channels are 0, the fourth is given."""
    from usdsdg.annotators.pixels import encoding_kernels as kernels

    found, pixels = _image_like(image, 4, np.float32)
    run_over_pixels(kernels.floats, pixels, [_floats(image), channels_of(image), fourth], [found])
    return found


def eight_bits(image: Pixels) -> Pixels:
    """Return vectors or numbers from 0 to 1 as uint8 from 0 to 255; a missing fourth channel is 255."""
    from usdsdg.annotators.pixels import encoding_kernels as kernels

    found, pixels = _image_like(image, 4, np.uint8)
    run_over_pixels(kernels.eight_bits, pixels, [_floats(image), channels_of(image)], [found])
    return found


def without_alpha(image: Pixels) -> Pixels:
    """Return the first three channels of an image of four, uint8 (H, W, 3)."""
    from usdsdg.annotators.pixels import encoding_kernels as kernels

    found, pixels = _image_like(image, 3, np.uint8)
    run_over_pixels(kernels.without_alpha, pixels, [image], [found])
    return found


def behind_everything(color: Pixels, instance: Pixels) -> Pixels:
    """Return a float16 image where the AOV `instance` is -1, and 0 elsewhere."""
    from usdsdg.annotators.pixels import encoding_kernels as kernels

    found, pixels = _image_like(instance, 4, np.float16)
    color = color.astype(np.float16, copy=False) if isinstance(color, np.ndarray) else color
    run_over_pixels(kernels.behind_everything, pixels, [color, instance], [found])
    return found


def _image_like(image: Pixels, channels: int, dtype: type[np.generic]) -> tuple[Pixels, int]:
    """Return an array for the result, and the number of pixels."""
    height, width = image.shape[:2]
    return new((height, width, channels), dtype, image), height * width


def _floats(image: Pixels) -> Pixels:
    return image.astype(np.float32, copy=False) if isinstance(image, np.ndarray) else image
