"""Which objects are visible enough to be labeled."""

import numpy as np
import pytest

from usdsdg.errors import WriterError
from usdsdg.writers.formats.shapes.visible_enough import VisibleEnough, is_hidden_more


@pytest.mark.parametrize("hidden", [1 / 5, 1 / 3, 3 / 5, 2 / 3, 9 / 10])
def test_what_is_just_visible_enough_is_labeled_although_occlusion_is_rounded(hidden):
    row = {"occlusionRatio": np.float32(hidden)}
    assert VisibleEnough("W", 1.0 - hidden, 1).holds(row, 5)
    assert not VisibleEnough("W", 1.0 - hidden + 1e-4, 1).holds(row, 5)


@pytest.mark.parametrize("hidden", [1 / 20, 1 / 5, 1 / 3, 3 / 5, 2 / 3])
def test_what_is_hidden_by_just_a_limit_is_not_hidden_by_more(hidden):
    row = {"occlusionRatio": np.float32(hidden)}
    assert not is_hidden_more(row, hidden)
    assert is_hidden_more(row, hidden - 1e-4)
    assert not is_hidden_more({"occlusionRatio": np.float32(np.nan)}, 0.0)


def test_few_pixels_are_not_enough_and_unknown_occlusion_is():
    enough = VisibleEnough("W", 0.5, 10)
    assert enough.holds({"occlusionRatio": np.float32(np.nan)}, 10)
    assert not enough.holds({"occlusionRatio": np.float32(0.0)}, 9)


def test_a_visibility_is_a_fraction():
    with pytest.raises(WriterError, match="min_visibility is 2"):
        VisibleEnough("W", 2, 1)


@pytest.mark.parametrize("pixels", [0, -3, float("nan")])
def test_there_is_a_least_pixel(pixels):
    with pytest.raises(WriterError, match=f"min_pixels is {pixels}; expected 1 or more"):
        VisibleEnough("W", 0.0, pixels)
