"""Decoding of PNG with several channels of 16 bits.

Our own, because Pillow keeps only the high 8 bits of 16-bit RGB, RGBA and gray + alpha.

Source: https://www.w3.org/TR/png-3/. Every byte is stored as its difference from a prediction from its left, upper and
upper-left neighbors. Pixels of one anti-diagonal do not depend on each other and are restored together.
"""

import struct
import zlib

import numpy as np

from usdsdg import errors

SIGNATURE = b"\x89PNG\r\n\x1a\n"
# Channels by color type; gray without alpha is left to Pillow, which reads all 16 bits of it.
CHANNELS = {2: 3, 4: 2, 6: 4}
LEFT, ABOVE, MEAN, PAETH = 1, 2, 3, 4


def decode(data: bytes, *, name: str) -> np.ndarray | None:
    """Decode a file with 2 to 4 channels of 16 bits to (H, W, C) uint16; None for any other or an interlaced file.

    Raises:
        AssetUnreadable: `data` is such a file, but damaged; names it by `name`.
    """
    if not data.startswith(SIGNATURE) or len(data) < 33:
        return None
    width, height, depth, color_type, _, _, interlaced = struct.unpack(">IIBBBBB", data[16:29])
    if depth != 16 or color_type not in CHANNELS or interlaced:
        return None
    channels = CHANNELS[color_type]
    size = height * (1 + 2 * width * channels)
    stream = zlib.decompressobj()
    try:
        # One byte more tells data that are too long, which could be of any length, and lets their checksum be read.
        raw = np.frombuffer(stream.decompress(_image_data(data), size + 1), np.uint8)
    except (zlib.error, struct.error) as error:
        raise errors.AssetUnreadable(f"{name}: {error}") from error
    if len(raw) != size or not stream.eof or not len(raw):
        raise errors.AssetUnreadable(f"{name}: the image data is truncated, or of another size than its header says")
    rows = raw.reshape(height, -1)
    stored = rows[:, 1:].reshape(height, width, 2 * channels)
    restored = _restored(rows[:, 0], stored)
    return restored.reshape(height, width, channels, 2).view(">u2")[..., 0].astype(np.uint16)


def _image_data(data: bytes) -> bytes:
    parts = []
    at = len(SIGNATURE)
    while at + 8 <= len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        if data[at + 4 : at + 8] == b"IDAT":
            parts.append(data[at + 8 : at + 8 + length])
        at += length + 12
    return b"".join(parts)


def _restored(filters: np.ndarray, stored: np.ndarray) -> np.ndarray:
    """Undo the filters: (H, W, bytes per pixel) uint8, with one filter per row."""
    height, width, size = stored.shape
    if not filters.any():
        return np.ascontiguousarray(stored)
    # [x + y, y + 1] holds the pixel (x, y); entries that are never written are the zeros outside the image.
    skewed = np.zeros((width + height, height + 1, size), np.uint8)
    for y in range(height):
        skewed[y : y + width, y + 1] = stored[y]
    chosen = [(filters == kind)[:, None] for kind in range(5)]
    for diagonal in range(width + height - 1):
        rows = slice(max(0, diagonal - width + 1), min(height, diagonal + 1))
        here, up = slice(rows.start + 1, rows.stop + 1), rows
        left = skewed[diagonal - 1, here].astype(np.int16)
        above = skewed[diagonal - 1, up].astype(np.int16)
        corner = skewed[diagonal - 2, up].astype(np.int16)
        predicted = np.where(chosen[LEFT][rows], left, 0)
        predicted = np.where(chosen[ABOVE][rows], above, predicted)
        predicted = np.where(chosen[MEAN][rows], (left + above) >> 1, predicted)
        predicted = np.where(chosen[PAETH][rows], _paeth(left, above, corner), predicted)
        skewed[diagonal, here] += predicted.astype(np.uint8)
    return np.stack([skewed[y : y + width, y + 1] for y in range(height)])


def _paeth(left: np.ndarray, above: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """Return the Paeth predictor: the neighbor nearest to left + above - corner."""
    to_left, to_above = np.abs(above - corner), np.abs(left - corner)
    to_corner = np.abs(left + above - 2 * corner)
    return np.where(
        (to_left <= to_above) & (to_left <= to_corner), left, np.where(to_above <= to_corner, above, corner)
    )
