"""The steps of a camera's signal, against closed forms."""

import numpy as np
import pytest

from usdsdg.compat.omni.graph import camera_signal
from usdsdg.compat.omni.graph.camera_signal import Signal
from usdsdg.errors import ArgumentError

CURVE = [[0, 0], [1000, 500], [60000, 4095]]


def uniform(color, size=(8, 6)):
    return Signal(np.broadcast_to(np.array([*color, 1.0], np.float32), (*size, 4)).copy())


def corrected(image, **options):
    given = {
        "matrix": np.eye(3),
        "white_balance": [1, 1, 1],
        "black": 0.0,
        "fullwell_black": 1.0,
        "swap_red_blue": False,
        "half": True,
    }
    return camera_signal.color_correction(image, **(given | options))


def raw(image, white=4095, **flips):
    filters = [(1, 0, 0), (0, 1, 0), (0, 1, 0), (0, 0, 1)]
    flips = {"flip_horizontal": False, "flip_vertical": False} | flips
    return camera_signal.mosaic(image, filters=filters, white=white, **flips)


def test_colors_are_mixed_then_balanced_then_limited():
    red_to_green = np.array([[0, 1, 0], [0, 0, 0], [0, 0, 0]])
    image = corrected(uniform((0.5, 0.1, 0.2)), matrix=red_to_green, white_balance=[1, 3, 1])
    assert image.pixels.dtype == np.float16
    assert image.pixels[0, 0, :3] == pytest.approx([0, 1, 0])


def test_eight_bits_have_white_at_255():
    image = corrected(uniform((1.0, 0.5, 0.0)), half=False)
    assert image.pixels[0, 0].tolist() == [255, 128, 0, 255]
    assert image.white == 255


def test_a_mosaic_reads_one_color_per_pixel():
    image = raw(uniform((1.0, 0.5, 0.25)))
    assert image.pixels.dtype == np.uint16
    assert image.pixels[:2, :2].tolist() == [[4095, 2048], [2048, 1024]]


def test_flips_move_the_picture_below_a_fixed_pattern():
    gradient = uniform((1, 1, 1), (2, 4))
    gradient.pixels[..., :3] *= np.linspace(0, 1, 4)[None, :, None]
    assert raw(gradient, flip_horizontal=True).pixels[0].tolist() == [4095, 2730, 1365, 0]


def test_more_than_sixteen_bits_take_32():
    assert raw(uniform((1, 1, 1)), white=2**24 - 1).pixels.dtype == np.uint32


def test_companding_is_undone_by_its_own_curve_and_by_the_inverse():
    image = Signal(np.array([[0, 500, 1000, 30500, 60000]], np.uint32), 60000)
    small = camera_signal.compand(image, curve=CURVE, before=0, after=0, alignment=None)
    assert small.pixels.tolist() == [[0, 250, 500, 2298, 4095]]
    assert small.pixels.dtype == np.uint16
    for curve in (CURVE, [[y, x] for x, y in CURVE]):
        back = camera_signal.decompand(small, curve=curve, before=0, after=0, alignment=None)
        assert back.pixels.tolist() == pytest.approx(image.pixels, abs=60000 / 4095)


def test_raw_values_can_be_aligned_to_the_highest_bit():
    image = camera_signal.compand(Signal(np.array([[60000]]), 60000), curve=CURVE, before=0, after=0, alignment=15)
    assert image.pixels.tolist() == [[4095 << 4]]


def test_demosaicing_gives_a_uniform_color_back():
    image = camera_signal.demosaic(raw(uniform((1.0, 0.5, 0.25))), grid="RGGB", output="UINT16")
    assert image.pixels.shape == (8, 6, 4)
    assert image.pixels[..., :3] / 65535 == pytest.approx(np.broadcast_to([1, 0.5, 0.25], (8, 6, 3)), abs=1e-3)


def test_shot_noise_has_the_variance_of_its_gain():
    image = Signal(np.full((200, 200), 10000.0), 65535)
    noisy = camera_signal.noise(
        image, dark_gain=2.0, dark_sigma=5.0, zones=[(4.0, 20000), (50.0, 60000)], rng=np.random.default_rng(1)
    )
    # variance: gain x value for the photons, (2 x 5)^2 for the dark current; 40000 samples have 0.7 % deviation
    assert noisy.pixels.var() == pytest.approx(4.0 * 10000 + 100, rel=0.04)
    assert noisy.pixels.mean() == pytest.approx(10000, abs=4)


def test_wrong_names_are_refused():
    with pytest.raises(ArgumentError, match="RGGB"):
        camera_signal.demosaic(raw(uniform((1, 1, 1))), grid="RCCB", output="UINT8")
    with pytest.raises(ArgumentError, match="UINT8"):
        camera_signal.in_format(uniform((1, 1, 1)), "JPEG")
