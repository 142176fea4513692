"""AOVs in the types of images: four channels of float16, float32 or uint8.

Images are (H, W, channels) or, of numbers, (H, W); results have four channels unless said otherwise.
"""

import numpy as np

from usdsdg.annotators.pixels.launch import run

HALF_MAX = float(np.finfo(np.float16).max)
_NO_VECTORS, _NO_IDS = np.zeros((0, 3), np.float32), np.zeros(0, np.int32)


def halves(
    image: np.ndarray,
    *,
    limit: float = np.inf,
    plus: np.ndarray = _NO_VECTORS,
    instance: np.ndarray = _NO_IDS,
) -> np.ndarray:
    """Return vectors as float16, with 1 in the fourth channel.

    limit: of values; larger ones than float16 has are infinite. plus: vectors that are added. instance: the AOV; the
        fourth channel is 0 where it is -1.
    """
    from usdsdg.annotators.pixels import encoding_kernels as kernels  # imports Warp

    found, pixels = _empty(image, np.float16)
    run(kernels.halves_of_vectors, pixels, [_floats(image), _floats(plus), instance, limit], [found])
    return found


def gray_halves(image: np.ndarray) -> np.ndarray:
    """Return numbers as float16 in three equal channels, with 1 in the fourth one."""
    from usdsdg.annotators.pixels import encoding_kernels as kernels

    found, pixels = _empty(image, np.float16)
    run(kernels.halves_of_numbers, pixels, [_floats(image)], [found])
    return found


def floats(image: np.ndarray, fourth: float) -> np.ndarray:
    """Return vectors of two or three numbers as float32: missing channels are 0, the fourth is given."""
    from usdsdg.annotators.pixels import encoding_kernels as kernels

    found, pixels = _empty(image, np.float32)
    kernel = kernels.floats_of_pairs if image.shape[2] == 2 else kernels.floats_of_vectors
    run(kernel, pixels, [_floats(image), fourth], [found])
    return found


def eight_bits(image: np.ndarray) -> np.ndarray:
    """Return vectors or numbers from 0 to 1 as uint8 from 0 to 255, with 255 in the fourth channel."""
    from usdsdg.annotators.pixels import encoding_kernels as kernels

    found, pixels = _empty(image, np.uint8)
    run(kernels.bytes_of_numbers if image.ndim == 2 else kernels.bytes_of_vectors, pixels, [_floats(image)], [found])
    return found


def without_alpha(image: np.ndarray) -> np.ndarray:
    """Return the first three channels of an image of four, uint8 (H, W, 3)."""
    from usdsdg.annotators.pixels import encoding_kernels as kernels

    height, width = image.shape[:2]
    found = np.empty((height, width, 3), np.uint8)
    run(kernels.without_alpha, (height * width,), [image], [found])
    return found


def behind_everything(color: np.ndarray, instance: np.ndarray) -> np.ndarray:
    """Return a float16 image where the AOV `instance` is -1, and 0 elsewhere."""
    from usdsdg.annotators.pixels import encoding_kernels as kernels

    found, pixels = _empty(color, np.float16)
    run(kernels.behind_everything, pixels, [color.astype(np.float16, copy=False), instance], [found])
    return found


def _empty(image: np.ndarray, kind: type[np.generic]) -> tuple[np.ndarray, tuple[int]]:
    """Return an array for the result, and the number of pixels as a shape."""
    height, width = image.shape[:2]
    return np.empty((height, width, 4), kind), (height * width,)


def _floats(image: np.ndarray) -> np.ndarray:
    return image.astype(np.float32, copy=False)
