"""Radiance pictures (.hdr): RGB float as shared-exponent bytes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

_CHUNK = 128


def write_hdr(path: Path, pixels: np.ndarray) -> None:
    """Write (height, width, 3) linear RGB >= 0, row 0 at the top. The width must lie in 8…32767.

    Rows use the newer scanline layout, in literal chunks: every reader knows it and nothing is searched.
    """
    height, width = pixels.shape[:2]
    header = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n"
    planes = _shared_exponent(pixels).transpose(0, 2, 1)
    with path.open("wb") as file:
        file.write(header.encode())
        start = np.tile(np.array([2, 2, width >> 8, width & 255], np.uint8), (height, 1))
        columns = [start]
        for channel in range(4):
            for left in range(0, width, _CHUNK):
                chunk = planes[:, channel, left : left + _CHUNK]
                columns += [np.full((height, 1), chunk.shape[1], np.uint8), chunk]
        file.write(np.concatenate(columns, axis=1).tobytes())


def _shared_exponent(pixels: np.ndarray) -> np.ndarray:
    """(…, 4) uint8: three mantissas and the exponent (biased by 128) of the largest component."""
    largest = pixels.max(axis=-1)
    _, exponent = np.frexp(largest)
    scale = np.where(largest > 1e-32, np.ldexp(np.float32(256.0), -exponent), 0.0)
    mantissa = np.clip(pixels * scale[..., None], 0.0, 255.0)
    biased = np.where(largest > 1e-32, exponent + 128, 0)
    return np.concatenate([mantissa, biased[..., None]], axis=-1).astype(np.uint8)
