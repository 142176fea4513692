import colorsys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from usdsdg.annotators.colors import colors_of_ids


@pytest.mark.parametrize(
    ("identifier", "color"),
    [
        (0, (0, 0, 0, 0)),
        (1, (0, 0, 0, 255)),
        # Published pictures of Replicator 1.12.26 and later.
        (2, (93, 220, 11, 255)),
        (3, (243, 69, 141, 255)),
        (4, (35, 198, 233, 255)),
        (5, (227, 192, 29, 255)),
    ],
)
def test_colors_of_the_first_ids(identifier, color):
    assert tuple(colors_of_ids(np.array([identifier]))[0]) == color


@given(st.integers(2, 2**32 - 1))
def test_color_equals_the_formula_in_unbounded_integers(n):
    h = n
    h ^= h >> 16
    h *= 0x85EBCA6B
    h ^= h >> 13
    h *= 0xC2B2AE35
    h ^= h >> 16
    hue = (n / 1.618033988749895 % 1 + 0.1 * (h & 0xFFFF) / 65536) % 1
    rgb = colorsys.hsv_to_rgb(hue, 0.7 + 0.3 * (h >> 16 & 255) / 255, 0.8 + 0.2 * (h >> 8 & 255) / 255)
    got = colors_of_ids(np.array([n]))[0]
    # One step of 255: HSV to RGB may be evaluated in another order.
    assert np.abs(got[:3].astype(int) - [int(c * 255) for c in rgb]).max() <= 1
    assert got[3] == 255
