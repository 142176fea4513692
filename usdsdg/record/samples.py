"""What a record keeps of whole images: checksums, every few pixels exactly, means of blocks."""

import zlib

import numpy as np

from usdsdg.record.frame_record import BLOCK, STEP

_NORMAL_STEPS = 127


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
    return ((normals[..., :3] * 0.5 + 0.5) * 255).astype(np.uint8)


def block_means(image: np.ndarray) -> np.ndarray:
    """Return the mean colors, uint8 (h, w, 3), of blocks of BLOCK pixels; an incomplete last block is left out."""
    height, width = (max(size // BLOCK, 1) for size in image.shape[:2])
    tall, wide = image.shape[0] // height, image.shape[1] // width
    blocks = image[: height * tall, : width * wide, :3].reshape(height, tall, width, wide, 3)
    # Summed along rows first, over contiguous memory.
    sums = blocks.sum(axis=1, dtype=np.uint32).sum(axis=2, dtype=np.uint32)
    return ((sums + tall * wide // 2) // (tall * wide)).astype(np.uint8)


def _first(size: int) -> int:
    return min(STEP // 2, size - 1)
