"""Panoramas: the file format against an independent decoder, the light against hand calculation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from usdsdg.demo import asset_urls
from usdsdg.demo.skies.panorama import panorama
from usdsdg.demo.skies.patterns import plain
from usdsdg.demo.skies.room import Block, Lamp, Room
from usdsdg.image_files import radiance_hdr


def read_hdr(path: Path) -> np.ndarray:
    """Decode a Radiance file literally by the format's description, run by run."""
    data = path.read_bytes()
    header, _, rest = data.partition(b"\n\n")
    assert header.startswith(b"#?RADIANCE")
    size, _, body = rest.partition(b"\n")
    _, height, _, width = size.split()
    rows, columns = int(height), int(width)
    image, at = np.zeros((rows, columns, 3)), 0
    for row in range(rows):
        assert body[at : at + 4] == bytes([2, 2, columns >> 8, columns & 255])
        at += 4
        planes = []
        for _ in range(4):
            plane = bytearray()
            while len(plane) < columns:
                count = body[at]
                if count > 128:
                    plane += bytes([body[at + 1]]) * (count - 128)
                    at += 2
                else:
                    plane += body[at + 1 : at + 1 + count]
                    at += 1 + count
            planes.append(np.frombuffer(bytes(plane), np.uint8).astype(float))
        image[row] = np.stack(planes[:3], axis=-1) * np.exp2(planes[3] - 136.0)[:, None]
    assert at == len(body)
    return image


def test_pixels_are_the_same_after_writing_and_reading(tmp_path):
    rng = np.random.default_rng(1)
    pixels = np.exp(rng.uniform(-8.0, 5.0, (3, 300, 1))) * rng.uniform(0.5, 1.0, (3, 300, 3))
    pixels[0, 0] = 0.0
    (tmp_path / "sky.hdr").write_bytes(radiance_hdr.encode(pixels.astype(np.float32)))
    # Eight bits of mantissa under the largest component's exponent, cut off: at most 1/128 of it.
    largest = pixels.max(axis=2, keepdims=True)
    assert (np.abs(read_hdr(tmp_path / "sky.hdr") - pixels) <= largest / 127.0).all()


@pytest.mark.parametrize("url", asset_urls.PANORAMAS)
def test_rooms_have_lamps_and_walls_of_plausible_brightness(url):
    sky = panorama(asset_urls.PANORAMAS[url](), 256)
    rows = np.cos((np.arange(128) + 0.5) / 128 * np.pi - np.pi / 2)
    mean = (sky.mean(axis=(1, 2)) * rows).sum() / rows.sum()
    assert sky.shape == (128, 256, 3)
    assert np.isfinite(sky).all()
    assert sky.min() >= 0.0
    assert mean == pytest.approx(0.4, rel=0.05)
    assert 2.0 < sky.max() <= 50.0
    # Dim corners and bright panes, not one gray.
    assert np.percentile(sky.mean(axis=2), 95) > 3.0 * np.percentile(sky.mean(axis=2), 5)


def test_edges_of_lamps_fall_off_over_some_pixels():
    sky = panorama(asset_urls.PANORAMAS[f"{asset_urls.SKIES}/autoshop_01_4k.hdr"](), 512)
    logarithms = np.log(sky.max(axis=2))
    steps = max(np.abs(np.diff(logarithms, axis=axis)).max() for axis in (0, 1))
    # A step to a lamp in one pixel would be as high as the lamp above its ceiling.
    assert steps < 0.5 * np.log(sky.max() / np.median(sky))


def gray(value: float):
    return plain((value, value, value), 0.0)


def small_room(**changes) -> Room:
    lamp = Lamp((-0.25, -0.25, 2.99), (0.25, 0.25, 2.99), (0.0, 0.0, -1.0), (10.0, 10.0, 10.0))
    parts = {"floor": gray(0.5), "ceiling": gray(0.0), "walls": gray(0.0), "lamps": [lamp], **changes}
    return Room((-3.0, -3.0, 0.0), (3.0, 3.0, 3.0), (0.0, 0.0, 1.5), **parts)


def test_the_floor_under_a_lamp_has_the_radiance_of_the_inverse_square_law():
    sky = panorama(small_room(), 512)
    lamp, below = sky[0].mean(), sky[-1].mean()
    # Radiance x area / distance² arrives under a small lamp; a matte floor sends albedo/π of it on.
    assert below / lamp == pytest.approx(0.5 / np.pi * 0.25 / 2.99**2, rel=0.06)


def test_black_walls_without_lamp_light_stay_black_and_white_ones_brighten_the_floor():
    dark, bright = panorama(small_room(), 512), panorama(small_room(walls=gray(0.8)), 512)
    # Both are exposed to one mean, so compare each with its own lamp.
    assert dark[112:144].max() == 0.0
    assert bright[-1].mean() / bright[0].mean() > 1.05 * dark[-1].mean() / dark[0].mean()


def test_a_table_casts_a_shadow():
    table = Block((-1.0, -1.0, 1.0), (1.0, 1.0, 1.1), gray(0.0))
    open_floor = panorama(small_room(), 256)
    shaded = panorama(small_room(blocks=(table,)), 256)
    # 36 degrees down the view passes the table's edge and ends on the floor 2.1 m out, still within its shadow.
    row = round((90 + 36.5) / 180 * 128)
    across = 256 // 2
    assert open_floor[row, across].mean() > 0.0
    assert shaded[row, across].mean() / shaded[0].mean() < 0.5 * open_floor[row, across].mean() / open_floor[0].mean()


def test_up_is_the_top_row():
    sky = panorama(small_room(), 128)
    assert sky[0].mean() > 10 * sky[-1].mean()
