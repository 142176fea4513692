"""Radiance RGBE images (.hdr, .pic): decode flat, old and adaptive run-length coding; encode the adaptive one.

Our own, because imageio (through Pillow) clips HDR to 8 bits and the libraries that read it correctly (imagecodecs,
OpenCV, OpenImageIO) are large for one format of two hundred lines.

Format: Greg Ward, "Real Pixels", Graphics Gems II; Radiance's `color.c`. Values are returned as stored, mantissa times
2^(exponent - 136); EXPOSURE and COLORCORR lines are ignored, as in other renderers.
"""

import re

import numpy as np

from usdsdg import errors

_RESOLUTION = re.compile(rb"([-+])([XY]) +(\d{1,9}) +([-+])([XY]) +(\d{1,9})\s*$")
# CIE XYZ (equal-energy white as Radiance stores it) to linear Rec.709.
_XYZ_TO_RGB = np.array(
    [[2.5653124, -1.1668500, -0.3984624], [-1.0221008, 1.9782866, 0.0438142], [0.0747243, -0.2519398, 1.1772155]],
    np.float32,
)
# 2^(e - 136), and 0 for exponent 0, which means black.
_SCALE = np.concatenate([[0.0], np.ldexp(1.0, np.arange(1, 256) - 136)]).astype(np.float32)
MAX_PIXELS = 1 << 28
# Images with more pixels are refused where their files have less than a byte for so many of them.
LARGE_PIXELS, MOST_PIXELS_A_BYTE = 1 << 26, 100
_MAX_LITERALS = 128  # of one run


def decode(data: bytes, *, name: str) -> np.ndarray:
    """Decode a file, called `name` in errors, to (H, W, 3) float32 linear Rec.709, row 0 at the top.

    Raises:
        AssetUnreadable: `data` is not a Radiance image, or is truncated.
    """
    header, offset = _read_header(data, name)
    major, minor, flips = _read_resolution(header, name)
    if major * minor > MAX_PIXELS:
        raise errors.AssetUnreadable(f"{name}: {major} x {minor} pixels are more than the {MAX_PIXELS} that are read.")
    if major * minor > max(LARGE_PIXELS, MOST_PIXELS_A_BYTE * len(data)):
        raise errors.AssetUnreadable(
            f"{name}: its {len(data)} bytes would become an image of {minor} x {major}; such an image is not read"
        )
    rgbe = _read_scanlines(data, offset, major, minor, name)
    scale = _SCALE[rgbe[..., 3]]
    image = np.empty((*scale.shape, 3), np.float32)
    for channel in range(3):
        np.multiply(rgbe[..., channel], scale, out=image[..., channel])
    if b"32-bit_rle_xyze" in header:
        image = np.maximum(image @ _XYZ_TO_RGB.T, 0.0)
    return _upright(image, flips)


def encode(pixels: np.ndarray) -> bytes:
    """Encode (height, width, 3) linear RGB >= 0, row 0 at the top; the width must be 8 to 32767.

    Rows use the adaptive scanline layout with literal runs only, which every reader supports.
    """
    height, width = pixels.shape[:2]
    header = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n"
    planes = _shared_exponent(pixels).transpose(0, 2, 1)
    columns = [np.tile(np.array([2, 2, width >> 8, width & 255], np.uint8), (height, 1))]
    for channel in range(4):
        for left in range(0, width, _MAX_LITERALS):
            run = planes[:, channel, left : left + _MAX_LITERALS]
            columns += [np.full((height, 1), run.shape[1], np.uint8), run]
    return header.encode() + np.concatenate(columns, axis=1).tobytes()


def _read_header(data: bytes, name: str) -> tuple[bytes, int]:
    """Return the header with its resolution line, and the offset of the pixels."""
    blank = data.find(b"\n\n")
    end = data.find(b"\n", blank + 2)
    if not data.startswith(b"#?") or blank < 0 or end < 0:
        raise errors.AssetUnreadable(
            f"{name}: not a whole Radiance image, which begins with '#?RADIANCE' and has a blank line and its size "
            "before the pixels"
        )
    return data[: end + 1], end + 1


def _read_resolution(header: bytes, name: str) -> tuple[int, int, tuple[bytes, bytes, bytes, bytes]]:
    match = _RESOLUTION.search(header.rstrip())
    if match is None or match[2] == match[5] or int(match[3]) == 0 or int(match[6]) == 0:
        raise errors.AssetUnreadable(f"{name}: the resolution line is not like '-Y 512 +X 1024'.")
    return int(match[3]), int(match[6]), (match[1], match[2], match[4], match[5])


def _upright(image: np.ndarray, flips: tuple[bytes, bytes, bytes, bytes]) -> np.ndarray:
    """Reorder pixels, stored major axis first, into rows from top to bottom and columns from left to right."""
    major_sign, major_axis, minor_sign, _ = flips
    if major_axis == b"X":
        image = image.transpose(1, 0, 2)
        major_sign, minor_sign = minor_sign, major_sign
    if major_sign == b"+":  # +Y: the first row is the lowest
        image = image[::-1]
    if minor_sign == b"-":
        image = image[:, ::-1]
    return np.ascontiguousarray(image)


def _read_scanlines(data: bytes, offset: int, rows: int, width: int, name: str) -> np.ndarray:
    marker = bytes([2, 2, width >> 8 & 255, width & 255])
    if 8 <= width <= 32767 and data[offset : offset + 4] == marker:
        return _read_adaptive(data, offset, rows, width, name)
    flat_size = rows * width * 4
    if len(data) - offset >= flat_size and len(data) - offset < flat_size + 4:
        return np.frombuffer(data, np.uint8, flat_size, offset).reshape(rows, width, 4)
    return _read_old(data, offset, rows, width, name)


def _read_adaptive(data: bytes, offset: int, rows: int, width: int, name: str) -> np.ndarray:
    """Decode scanlines of four separate components, each as runs (count > 128) and literals."""
    image = np.empty((rows, 4, width), np.uint8)
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
            image[row] = np.frombuffer(scanline, np.uint8).reshape(4, width)
    except IndexError:
        raise errors.AssetUnreadable(f"{name}: ends inside scanline {row} of {rows}; copy the file again.") from None
    return image.transpose(0, 2, 1)


def _read_old(data: bytes, offset: int, rows: int, width: int, name: str) -> np.ndarray:
    """Decode interleaved pixels; (1, 1, 1, n) repeats the last one n times, and the next such entries n << 8 times."""
    total = rows * width
    stored = np.frombuffer(data, np.uint8, (len(data) - offset) // 4 * 4, offset).reshape(-1, 4)
    repeat = (stored[:, :3] == 1).all(axis=1)
    # The k-th repeat in a row counts n << 8k pixels.
    position = np.zeros(len(stored), np.int64)
    index = np.arange(len(stored))
    last_literal = np.maximum.accumulate(np.where(repeat, -1, index))
    position[repeat] = index[repeat] - last_literal[repeat] - 1
    counts = np.where(repeat, stored[:, 3].astype(np.int64) << np.minimum(8 * position, 40), 1)
    # Stop at the entry that completes the image, so that trailing bytes cannot inflate the expansion.
    ends = np.cumsum(np.minimum(counts, total))
    needed = int(np.searchsorted(ends, total)) + 1
    if (len(repeat) and repeat[0]) or needed > len(stored):
        raise errors.AssetUnreadable(f"{name}: ends before its {rows} x {width} pixels; copy the file again.")
    source = np.maximum(last_literal[:needed], 0)
    pixels = np.repeat(stored[source], np.minimum(counts[:needed], total), axis=0)
    return pixels[:total].reshape(rows, width, 4)


def _shared_exponent(pixels: np.ndarray) -> np.ndarray:
    """Return (…, 4) uint8: three mantissas and the exponent (biased by 128) of the largest component."""
    largest = pixels.max(axis=-1)
    _, exponent = np.frexp(largest)
    scale = np.where(largest > 1e-32, np.ldexp(np.float32(256.0), -exponent), 0.0)
    mantissa = np.clip(pixels * scale[..., None], 0.0, 255.0)
    biased = np.where(largest > 1e-32, exponent + 128, 0)
    return np.concatenate([mantissa, biased[..., None]], axis=-1).astype(np.uint8)
