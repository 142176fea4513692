"""PNG encoding with one filter for all rows, and of their bytes only runs as matches.

Our own, because a 1080p RGB frame takes 8 ms against 1.1 s with Pillow's defaults (143 ms with OpenCV), for a file
within 20 % of the size, and because its bytes are the same on every CPU and with every zlib.

Every row is stored as its difference from the row above (filter Up), which vectorizes over the whole image and
compresses rendered images and label maps equally well.
"""

import functools
import struct
import zlib

import numpy as np

from usdsdg.image_files import runs

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_FILTER_UP = 2
# PNG color types by number of channels.
_COLOR_TYPES = {1: 0, 3: 2, 4: 6}
_INDEXED = 3


def encode_png(image: np.ndarray, palette: np.ndarray | None = None) -> bytes:
    """Return the bytes of the file; arguments and errors are those of `png_chunks`."""
    return b"".join(png_chunks(image, palette))


def channels_of(image: np.ndarray) -> int:
    """Return how many channels an image has as a PNG.

    Raises:
        ValueError: a PNG cannot hold it.
    """
    channels = 1 if image.ndim == 2 else image.shape[2] if image.ndim == 3 else 0
    if image.dtype not in (np.uint8, np.uint16) or channels not in _COLOR_TYPES or image.size == 0:
        raise ValueError(f"a PNG cannot hold {image.dtype} of shape {image.shape}")
    return channels


def png_chunks(image: np.ndarray, palette: np.ndarray | None = None) -> tuple[bytes | memoryview, ...]:
    """Encode a uint8 or uint16 image: (H, W) or (H, W, 1) gray, (H, W, 3) RGB or (H, W, 4) RGBA.

    palette: colors of a gray uint8 image, uint8 (N, 3) with N to 256, which then has indices of them.

    Returns the bytes of the file in pieces; a copy of the largest would keep other threads from running Python.

    Raises:
        ValueError: another shape or dtype, or no pixels.
    """
    channels = channels_of(image)
    height, width = image.shape[:2]
    depth = 8 * image.dtype.itemsize
    if palette is not None and (channels != 1 or depth != 8):
        raise ValueError(f"a PNG with a palette cannot hold {image.dtype} of shape {image.shape}")
    kind = _COLOR_TYPES[channels] if palette is None else _INDEXED
    header = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)
    colors = () if palette is None else _chunk(b"PLTE", np.ascontiguousarray(palette, np.uint8).tobytes())
    data = runs.compressed_chunks(_filtered_rows(image))
    return _SIGNATURE, *_chunk(b"IHDR", header), *colors, *_chunk(b"IDAT", *data), *_chunk(b"IEND")


def _filtered_rows(image: np.ndarray) -> np.ndarray:
    """Return (H, 1 + bytes per row) uint8: each row's filter byte and its difference from the row above, modulo 256."""
    if image.dtype == np.uint16:
        image = image.astype(">u2")
    rows = np.ascontiguousarray(image).view(np.uint8).reshape(image.shape[0], -1)
    filtered = np.empty((rows.shape[0], rows.shape[1] + 1), np.uint8)
    filtered[:, 0] = _FILTER_UP
    filtered[0, 1:] = rows[0]
    np.subtract(rows[1:], rows[:-1], out=filtered[1:, 1:])
    return filtered


def _chunk(kind: bytes, *data: bytes | memoryview) -> tuple[bytes | memoryview, ...]:
    checksum = functools.reduce(lambda until, piece: zlib.crc32(piece, until), data, zlib.crc32(kind))
    return struct.pack(">I", sum(map(len, data))) + kind, *data, struct.pack(">I", checksum)
