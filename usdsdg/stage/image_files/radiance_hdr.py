"""Radiance RGBE pictures (.hdr, .pic): flat, old and adaptive run-length coding.

Format: Greg Ward, "Real Pixels", Graphics Gems II; Radiance's `color.c`. Values are returned as stored, mantissa times
2^(exponent - 136); EXPOSURE and COLORCORR lines are left alone, as other renderers do.
"""

from __future__ import annotations

import re

import numpy as np

from usdsdg import errors

_RESOLUTION = re.compile(rb"([-+])([XY]) +(\d+) +([-+])([XY]) +(\d+)\s*$")
# CIE XYZ (equal-energy white as Radiance stores it) to linear Rec.709.
_XYZ_TO_RGB = np.array(
    [[2.5653124, -1.1668500, -0.3984624], [-1.0221008, 1.9782866, 0.0438142], [0.0747243, -0.2519398, 1.1772155]],
    np.float32,
)
# 2^(e - 136), and 0 for exponent 0, which means black.
_SCALE = np.concatenate([[0.0], np.ldexp(1.0, np.arange(1, 256) - 136)]).astype(np.float32)
MAX_PIXELS = 1 << 28


def decode(data: bytes, *, name: str) -> np.ndarray:
    """(H, W, 3) float32 linear Rec.709, row 0 at the top, of the bytes of a Radiance picture called `name`.

    Raises:
        AssetUnreadable: not a Radiance picture, or it ends early.
    """
    header, offset = _read_header(data, name)
    major, minor, flips = _read_resolution(header, name)
    if major * minor > MAX_PIXELS:
        raise errors.AssetUnreadable(f"{name}: {major} x {minor} pixels are more than the {MAX_PIXELS} that are read.")
    rgbe = _read_scanlines(data, offset, major, minor, name)
    scale = _SCALE[rgbe[..., 3]]
    picture = np.empty((*scale.shape, 3), np.float32)
    for channel in range(3):
        np.multiply(rgbe[..., channel], scale, out=picture[..., channel])
    if b"32-bit_rle_xyze" in header:
        picture = np.maximum(picture @ _XYZ_TO_RGB.T, 0.0)
    return _upright(picture, flips)


def _read_header(data: bytes, name: str) -> tuple[bytes, int]:
    """The header with its resolution line, and where the pixels begin."""
    blank = data.find(b"\n\n")
    end = data.find(b"\n", blank + 2)
    if not data.startswith(b"#?") or blank < 0 or end < 0:
        raise errors.AssetUnreadable(f"{name}: not a Radiance picture (it should begin with '#?RADIANCE').")
    return data[: end + 1], end + 1


def _read_resolution(header: bytes, name: str) -> tuple[int, int, tuple[bytes, bytes, bytes, bytes]]:
    match = _RESOLUTION.search(header.rstrip())
    if match is None or match[2] == match[5] or int(match[3]) == 0 or int(match[6]) == 0:
        raise errors.AssetUnreadable(f"{name}: the resolution line is not like '-Y 512 +X 1024'.")
    return int(match[3]), int(match[6]), (match[1], match[2], match[4], match[5])


def _upright(picture: np.ndarray, flips: tuple[bytes, bytes, bytes, bytes]) -> np.ndarray:
    """Turn the stored order (major axis first) into rows from top to bottom, columns from left to right."""
    major_sign, major_axis, minor_sign, _ = flips
    if major_axis == b"X":
        picture = picture.transpose(1, 0, 2)
        major_sign, minor_sign = minor_sign, major_sign
    if major_sign == b"+":  # +Y: the first row is the lowest
        picture = picture[::-1]
    if minor_sign == b"-":
        picture = picture[:, ::-1]
    return np.ascontiguousarray(picture)


def _read_scanlines(data: bytes, offset: int, rows: int, width: int, name: str) -> np.ndarray:
    marker = bytes([2, 2, width >> 8 & 255, width & 255])
    if 8 <= width <= 32767 and data[offset : offset + 4] == marker:
        return _read_adaptive(data, offset, rows, width, name)
    flat_size = rows * width * 4
    if len(data) - offset >= flat_size and len(data) - offset < flat_size + 4:
        return np.frombuffer(data, np.uint8, flat_size, offset).reshape(rows, width, 4)
    return _read_old(data, offset, rows, width, name)


def _read_adaptive(data: bytes, offset: int, rows: int, width: int, name: str) -> np.ndarray:
    """Each scanline holds its four components apart, each as runs (count > 128) and literal stretches."""
    picture = np.empty((rows, 4, width), np.uint8)
    scanline = bytearray(4 * width)
    marker = bytes([2, 2, width >> 8, width & 255])
    position, size = offset, 4 * width
    try:
        for row in range(rows):
            if data[position : position + 4] != marker:
                raise errors.AssetUnreadable(f"{name}: scanline {row} has no run-length header; the file is damaged.")
            position += 4
            filled = 0
            while filled < size:
                count = data[position]
                if count > 128:
                    count -= 128
                    scanline[filled : filled + count] = data[position + 1 : position + 2] * count
                    position += 2
                else:
                    scanline[filled : filled + count] = data[position + 1 : position + 1 + count]
                    position += count + 1
                if not count:
                    raise errors.AssetUnreadable(f"{name}: scanline {row} has an empty run; the file is damaged.")
                filled += count
            if filled != size or len(scanline) != size:
                raise errors.AssetUnreadable(f"{name}: scanline {row} does not fit its width; the file is damaged.")
            picture[row] = np.frombuffer(scanline, np.uint8).reshape(4, width)
    except IndexError:
        raise errors.AssetUnreadable(f"{name}: ends inside scanline {row} of {rows}; copy the file again.") from None
    return picture.transpose(0, 2, 1)


def _read_old(data: bytes, offset: int, rows: int, width: int, name: str) -> np.ndarray:
    """Pixels one by one; (1, 1, 1, n) repeats the last pixel n times, more bytes of n following each other."""
    total = rows * width
    stored = np.frombuffer(data, np.uint8, (len(data) - offset) // 4 * 4, offset).reshape(-1, 4)
    repeat = (stored[:, :3] == 1).all(axis=1)
    # The k-th repeat in a row counts n << 8k pixels.
    place = np.zeros(len(stored), np.int64)
    index = np.arange(len(stored))
    last_literal = np.maximum.accumulate(np.where(repeat, -1, index))
    place[repeat] = index[repeat] - last_literal[repeat] - 1
    counts = np.where(repeat, stored[:, 3].astype(np.int64) << np.minimum(8 * place, 40), 1)
    # Stop at the entry that completes the picture, so that trailing bytes cannot blow up the expansion.
    ends = np.cumsum(np.minimum(counts, total))
    needed = int(np.searchsorted(ends, total)) + 1
    if (len(repeat) and repeat[0]) or needed > len(stored):
        raise errors.AssetUnreadable(f"{name}: ends before its {rows} x {width} pixels; copy the file again.")
    source = np.maximum(last_literal[:needed], 0)
    pixels = np.repeat(stored[source], np.minimum(counts[:needed], total), axis=0)
    return pixels[:total].reshape(rows, width, 4)
