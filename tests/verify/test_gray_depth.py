"""Gray pictures of depth, of which there are two ranges: that of the frame, and 0.00001 to 100 m before version 0.2."""

from types import SimpleNamespace

import numpy as np
import pytest

from usdsdg.verify.checks import depth
from usdsdg.writers.formats.writer_basic import colorize_distance

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


# A wall before the camera: one distance, up to the last bits of 32-bit numbers.
WALL = np.array([[7.0, 6.9999995, 7.0000005, 7.000001, np.inf]], np.float32)


def test_a_wall_is_white_whatever_its_rounding():
    levels = colorize_distance(WALL)[0].tolist()
    assert min(levels[:4]) >= 254
    assert levels[4] == 0
    assert faults(levels, WALL) == []
    assert len(faults([255, 255, 200, 255, 0], WALL)) == 1


@pytest.mark.parametrize("ratio", [1.00002, 1.0001, 1.01])
def test_narrow_ranges_are_taken_as_written(ratio):
    values = np.linspace(3.3, 3.3 * ratio, 500, dtype=np.float32)[None]
    assert faults(colorize_distance(values)[0], values) == []
