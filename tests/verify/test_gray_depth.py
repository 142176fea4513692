"""Gray pictures of depth, of which there are two ranges: that of the frame, and 0.00001 to 100 m before version 0.2."""

from types import SimpleNamespace

import numpy as np
import pytest

from usdsdg.verify.checks import depth

DEPTH = np.array([[2.0, 4.0, 8.0, 32.0, np.inf]], np.float32)
OF_FRAME = [255, 191, 127, 0, 0]  # two of four doublings are half of the way
OLD = [61, 50, 39, 18, 0]


def faults(levels, values=DEPTH):
    picture = np.array([levels], np.uint8)
    seen = SimpleNamespace(name="0000", depths=[], truth=None, extra={"drawn depth": [("d.png", picture, values)]})
    return list(depth.check(seen))


@pytest.mark.parametrize("levels", [OF_FRAME, OLD])
def test_both_ranges_are_taken(levels):
    assert faults(levels) == []


@pytest.mark.parametrize("levels", [OF_FRAME, OLD])
def test_one_other_level_is_a_fault(levels):
    assert len(faults([*levels[:2], levels[2] + 2, *levels[3:]])) == 1


def test_a_picture_in_both_ranges_is_a_fault():
    assert len(faults([*OF_FRAME[:2], *OLD[2:]])) == 1


def test_a_frame_without_a_hit_is_black():
    assert faults([0], np.array([[np.inf]], np.float32)) == []
    assert len(faults([200], np.array([[np.inf]], np.float32))) == 1
