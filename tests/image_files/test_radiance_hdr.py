"""Radiance images: files written by hand, every coding and orientation, damaged files."""

import numpy as np
import pytest

from usdsdg import errors
from usdsdg.image_files import radiance_hdr

HEADER = b"#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\n\n"


def picture(size: str, pixels: bytes, header: bytes = HEADER) -> bytes:
    return header + size.encode() + b"\n" + pixels


def rgbe(rng: np.random.Generator, height: int, width: int) -> np.ndarray:
    pixels = rng.integers(0, 256, (height, width, 4), dtype=np.uint8)
    pixels[..., 3] = rng.integers(100, 140, (height, width))
    # Runs of both kinds in every component.
    pixels[:, : width // 2] = pixels[:, :1]
    return pixels


def values(pixels: np.ndarray) -> np.ndarray:
    return np.ldexp(pixels[..., :3].astype(np.float64), pixels[..., 3:].astype(int) - 136)


def encode_adaptive(pixels: np.ndarray) -> bytes:
    """A plain encoder of its own: runs of four or more become runs, the rest literals."""
    width = pixels.shape[1]
    out = bytearray()
    for row in pixels:
        out += bytes([2, 2, width >> 8, width & 255])
        for component in row.T:
            line, k = component.tobytes(), 0
            while k < width:
                run = 1
                while k + run < width and run < 127 and line[k + run] == line[k]:
                    run += 1
                if run >= 4:
                    out += bytes([128 + run, line[k]])
                    k += run
                    continue
                end = k + 1
                while end < width and end - k < 128 and line[end : end + 4] != line[end : end + 1] * 4:
                    end += 1
                out += bytes([end - k]) + line[k:end]
                k = end
    return bytes(out)


def test_known_pixels_have_known_values():
    # 128 * 2^(129-136) = 1; 64 * 2^(129-136) = 0.5; exponent 0 is black whatever the mantissa.
    pixels = bytes([128, 64, 0, 129, 255, 255, 255, 0])
    decoded = radiance_hdr.decode(picture("-Y 1 +X 2", pixels), name="hand.hdr")
    assert decoded.dtype == np.float32
    assert decoded.tolist() == [[[1.0, 0.5, 0.0], [0.0, 0.0, 0.0]]]


@pytest.mark.parametrize("width", [8, 100, 300])
def test_adaptive_coding_gives_back_the_pixels(width):
    pixels = rgbe(np.random.default_rng(width), 5, width)
    decoded = radiance_hdr.decode(picture(f"-Y 5 +X {width}", encode_adaptive(pixels)), name="rle.hdr")
    np.testing.assert_allclose(decoded, values(pixels), rtol=1e-6)


@pytest.mark.parametrize("width", [3, 8, 50])
def test_flat_coding_gives_back_the_pixels(width):
    pixels = rgbe(np.random.default_rng(width), 4, width)
    pixels[0, 0] = 9, 9, 9, 130  # not the marker of a coded scanline
    decoded = radiance_hdr.decode(picture(f"-Y 4 +X {width}", pixels.tobytes()), name="flat.hdr")
    np.testing.assert_allclose(decoded, values(pixels), rtol=1e-6)


def test_old_coding_repeats_the_last_pixel():
    a, b = bytes([10, 20, 30, 129]), bytes([40, 50, 60, 128])
    # a, then 3 repeats; b, then 300 = 44 + 1 * 256 repeats in two markers following each other.
    coded = a + bytes([1, 1, 1, 3]) + b + bytes([1, 1, 1, 44]) + bytes([1, 1, 1, 1])
    decoded = radiance_hdr.decode(picture("-Y 5 +X 61", coded), name="old.hdr").reshape(-1, 3)
    assert len(decoded) == 305
    np.testing.assert_allclose(decoded[:4], np.tile([10 / 128, 20 / 128, 30 / 128], (4, 1)))
    np.testing.assert_allclose(decoded[4:], np.tile([40 / 256, 50 / 256, 60 / 256], (301, 1)))


@pytest.mark.parametrize(
    ("size", "turn"),
    [
        ("-Y 2 +X 3", lambda p: p),
        ("+Y 2 +X 3", lambda p: p[::-1]),
        ("-Y 2 -X 3", lambda p: p[:, ::-1]),
        ("+Y 2 -X 3", lambda p: p[::-1, ::-1]),
        ("+X 2 -Y 3", lambda p: p.transpose(1, 0, 2)),
        ("-X 2 -Y 3", lambda p: p.transpose(1, 0, 2)[:, ::-1]),
        ("+X 2 +Y 3", lambda p: p.transpose(1, 0, 2)[::-1]),
    ],
)
def test_row_zero_is_the_top_whatever_the_stored_order(size, turn):
    stored = np.zeros((2, 3, 4), np.uint8)
    stored[..., 0] = np.arange(6).reshape(2, 3) + 10
    stored[..., 3] = 136
    decoded = radiance_hdr.decode(picture(size, stored.tobytes()), name="turned.hdr")
    np.testing.assert_array_equal(decoded, turn(stored[..., :3].astype(np.float32)))


def test_xyz_white_is_rgb_white():
    header = HEADER.replace(b"rgbe", b"xyze")
    decoded = radiance_hdr.decode(picture("-Y 1 +X 1", bytes([128, 128, 128, 129]), header), name="xyz.hdr")
    np.testing.assert_allclose(decoded, 1.0, atol=1e-3)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"PNG",
        HEADER,
        picture("-Y 2 -Y 2", bytes(16)),
        picture("-Y 0 +X 2", b""),
        picture("-Y 2 +X 2", bytes(12)),
        picture("-Y 4 +X 100", encode_adaptive(rgbe(np.random.default_rng(0), 4, 100))[:-5]),
        picture("-Y 1 +X 8", bytes([2, 2, 0, 8]) + bytes([0] * 40)),
        picture("-Y 1 +X 8", bytes([2, 2, 0, 8]) + bytes([255, 7] * 40)),
        picture("-Y 99999999 +X 99999999", bytes(100)),
    ],
)
def test_damaged_files_are_named(data):
    with pytest.raises(errors.AssetUnreadable, match=r"sky\.hdr"):
        radiance_hdr.decode(data, name="sky.hdr")
