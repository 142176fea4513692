"""What a record keeps of whole images: checksums, every few pixels exactly, means of blocks."""

import zlib

import numpy as np

from usdsdg.record.frame_record import BLOCK, STEP

_NORMAL_STEPS = 127
_BAND = 16


def checksum(image: np.ndarray) -> int:
    """Return the CRC-32 of an array's bytes."""
    return zlib.crc32(np.ascontiguousarray(image).data.cast("B") if image.size else b"")


def grid(image: np.ndarray) -> np.ndarray:
    """Return every STEP-th pixel of every STEP-th row, from the middle of the first step."""
    return np.ascontiguousarray(image[_first(image.shape[0]) :: STEP, _first(image.shape[1]) :: STEP])


def grid_pixels(shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return rows and columns of the pixels of `grid`, (h, w) each."""
    rows, columns = (np.arange(_first(size), size, STEP) for size in shape)
    return tuple(np.meshgrid(rows, columns, indexing="ij"))  # type: ignore[return-value]


def normal_steps(normals: np.ndarray) -> np.ndarray:
    """Return components of unit normals as int8."""
    return np.rint(normals[..., :3] * _NORMAL_STEPS).astype(np.int8)


def normal_image(normals: np.ndarray) -> np.ndarray:
    """Return components of unit normals in 8 bits as images have them: -1 is 0, and 1 is 255."""
    image = np.empty((*normals.shape[:-1], 3), np.uint8)
    for first in range(0, len(normals), _BAND):  # bands that stay in the cache
        steps = normals[first : first + _BAND, ..., :3] * 0.5
        steps += 0.5
        steps *= 255
        image[first : first + _BAND] = steps
    return image


def is_opaque(image: np.ndarray) -> bool:
    """Return whether the alpha of a uint8 (H, W, 4) image is 255 everywhere."""
    pixels = np.ascontiguousarray(image).view(np.uint32)
    alpha = np.array([0, 0, 0, 255], np.uint8).view(np.uint32)
    return bool(np.bitwise_and.reduce(pixels, axis=None) & alpha == alpha)


def block_means(image: np.ndarray) -> np.ndarray:
    """Return the mean colors, uint8 (h, w, 3), of blocks of BLOCK pixels; an incomplete last block is left out."""
    height, width = (max(size // BLOCK, 1) for size in image.shape[:2])
    tall, wide = image.shape[0] // height, image.shape[1] // width
    # Summed over whole rows first, which are contiguous; 16 bits hold the sum of a block's column.
    columns = image[: height * tall].reshape(height, tall, -1).sum(axis=1, dtype=np.uint16)
    blocks = columns.reshape(height, image.shape[1], -1)[:, : width * wide, :3].reshape(height, width, wide, 3)
    sums = blocks.sum(axis=2, dtype=np.uint32)
    return ((sums + tall * wide // 2) // (tall * wide)).astype(np.uint8)


def _first(size: int) -> int:
    return min(STEP // 2, size - 1)
