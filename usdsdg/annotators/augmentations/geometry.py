"""Augmentations that move pixels: crop and rotate. They return the transform of pixel positions (`Warped.xform`).

Images are uint8 (H, W, C) of the same size before and after; (0, 0) is the center of the top left pixel.
"""

from collections.abc import Sequence

import numpy as np

from usdsdg.annotators.augmentations.array_transform import Warped
from usdsdg.graph.sampling import generator


def crop_resize(
    data_in: np.ndarray,
    cropFactor: float | None = None,
    offsetFactor: Sequence[float] = (0.0, 0.0),
    minPercent: float = 0.5,
    seed: int = 0,
) -> Warped:
    """Crop a part and scale it up to the size of the image.

    Args:
        data_in: the image.
        cropFactor: size of the part as a fraction, above 0 to 1. None draws it between `minPercent` and 1, and the
            offset too, as older versions do.
        offsetFactor: (vertical, horizontal), each from -1 to 1: direction in which the contents move. (1, 1) is to the
            top right, so that the bottom left is cropped; (0, 0) crops the center.
        minPercent: smallest fraction that is drawn.
        seed: of the random draws.

    Raises:
        ValueError: a factor is outside its range, or nothing would be left.
    """
    factor, (vertical, horizontal) = cropFactor, offsetFactor
    if factor is None:
        draws = generator(seed, "crop_resize", 0).random(3)
        factor = minPercent + (1 - minPercent) * draws[0]
        vertical, horizontal = 2 * draws[1] - 1, 2 * draws[2] - 1
    if not 0 < factor <= 1:
        raise ValueError(f"cropFactor is {factor!r}; expected a number above 0 and at most 1")
    if max(abs(vertical), abs(horizontal)) > 1:
        raise ValueError(f"offsetFactor is {offsetFactor!r}; expected two numbers from -1 to 1")
    height, width = data_in.shape[:2]
    top, rows = _cut(height, factor, vertical)
    left, columns = _cut(width, factor, -horizontal)
    scale_y, scale_x = (height - 1) / max(rows - 1, 1), (width - 1) / max(columns - 1, 1)
    xform = np.array([[scale_x, 0, -left * scale_x], [0, scale_y, -top * scale_y], [0, 0, 1]])
    return Warped(_resampled(data_in, xform, outside="nearest"), xform)


def rotate(data_in: np.ndarray, rotation: float | None = None, rotateDegrees: float = 45.0, seed: int = 0) -> Warped:
    """Rotate the image about its center; pixels from outside are 0 in all channels.

    Args:
        data_in: the image.
        rotation: degrees, counterclockwise in the displayed image (as Replicator does; its documentation says
            clockwise). None draws it between -rotateDegrees and rotateDegrees, as older versions do.
        rotateDegrees: largest angle that is drawn.
        seed: of the random draws.
    """
    if rotation is None:
        rotation = rotateDegrees * (2 * generator(seed, "rotate", 0).random() - 1)
    height, width = data_in.shape[:2]
    x, y = (width - 1) / 2, (height - 1) / 2
    c, s = np.cos(np.deg2rad(rotation)), np.sin(np.deg2rad(rotation))
    xform = np.array([[c, s, x - c * x - s * y], [-s, c, y + s * x - c * y], [0, 0, 1]])
    return Warped(_resampled(data_in, xform, outside="grid-constant"), xform)


def _cut(length: int, factor: float, offset: float) -> tuple[int, int]:
    """Return the first pixel and the number of pixels of the cropped part of `length`."""
    size = int(factor * length)
    if size < 1:
        raise ValueError(f"cropFactor {factor:g} leaves nothing of {length} pixels")
    return int(offset * (1 - factor) / 2 * length + (length - size) / 2), size


def _resampled(image: np.ndarray, xform: np.ndarray, *, outside: str) -> np.ndarray:
    """Transform the image by `xform` with linear interpolation; `outside` is a mode of scipy.ndimage."""
    from scipy import ndimage

    back = np.linalg.inv(xform)
    # scipy orders coordinates (row, column).
    matrix, offset = back[1::-1, 1::-1], back[1::-1, 2]
    out = np.empty_like(image)
    for channel in range(image.shape[2]):
        values = image[..., channel].astype(np.float32)
        # SciPy has no types; for pyright `offset` has that of its default, a float.
        moved = ndimage.affine_transform(values, matrix, offset, order=1, mode=outside)  # pyright: ignore[reportArgumentType]
        out[..., channel] = np.clip(moved + 1e-3, 0, 255)
    return out
