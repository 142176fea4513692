"""The one color of a PNG file without alpha that is transparent (tRNS).

Our own, because Pillow compares gray of 2 and 4 bits with the color before it widens it, and loses that of 16 bits.

Source: https://www.w3.org/TR/png-3/#11tRNS
"""

import struct

import numpy as np

from usdsdg.image_files.png16 import SIGNATURE

_GRAY, _RGB = 0, 2


def transparent_color(data: bytes) -> tuple[int, ...] | None:
    """Return the gray or RGB color of a file that is transparent, in 8 bits, or in 16 where the file has them.

    None for files with alpha, with a palette, without such a color, and other than PNG.
    """
    if not data.startswith(SIGNATURE) or len(data) < 33 or data[25] not in (_GRAY, _RGB):
        return None
    depth, size = data[24], 2 if data[25] == _GRAY else 6
    at = len(SIGNATURE)
    while at + 8 <= len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, content = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        if kind == b"tRNS" and len(content) >= size:
            most = (1 << depth) - 1  # bits above the file's depth do not count
            return tuple((each & most) * max(255 // most, 1) for (each,) in struct.iter_unpack(">H", content[:size]))
        if kind == b"IDAT":
            return None
        at += length + 12
    return None


def with_alpha(values: np.ndarray, color: tuple[int, ...]) -> np.ndarray:
    """Return (H, W) gray or (H, W, 3 or 4) colors as gray + alpha or RGBA, of which `color` alone is transparent."""
    colors = values[..., None] if values.ndim == 2 else values[..., : len(color)]
    is_opaque = (colors != np.array(color, values.dtype)).any(axis=-1, keepdims=True)
    alpha = is_opaque.astype(values.dtype) * np.iinfo(values.dtype).max
    return np.concatenate([colors, alpha], axis=-1)
