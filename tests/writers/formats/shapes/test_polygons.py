"""Outlines of masks: filled again by counting crossings, they give the mask without its holes."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from usdsdg.writers.formats.shapes.polygons import joined, outlines, without_holes


def filled(polygon, shape):
    """Return the pixels (H, W) whose centers are inside a polygon, by the even-odd rule."""
    y, x = np.mgrid[: shape[0], : shape[1]] + 0.5
    inside = np.zeros(shape, bool)
    for (x0, y0), (x1, y1) in zip(polygon, np.roll(polygon, -1, axis=0)):
        if y0 != y1:
            crosses = ((y0 > y) != (y1 > y)) & (x < (x1 - x0) * (y - y0) / (y1 - y0) + x0)
            inside ^= crosses
    return inside


@st.composite
def masks(draw):
    height, width = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    return np.array(draw(st.lists(st.booleans(), min_size=height * width, max_size=height * width))).reshape(
        height, width
    )


@settings(max_examples=300, deadline=None)
@given(masks())
def test_outlines_filled_are_the_parts_without_their_holes(mask):
    labels, count = ndimage.label(mask)
    # A hole that touches the outside at a corner is none.
    parts = [ndimage.binary_fill_holes(labels == number + 1, np.ones((3, 3))) for number in range(count)]
    found = outlines(mask)
    assert len(found) == count
    assert sorted(filled(each, mask.shape).tobytes() for each in found) == sorted(part.tobytes() for part in parts)
    areas = [np.count_nonzero(filled(each, mask.shape)) for each in found]
    assert areas == sorted(areas, reverse=True)
    for each in found:
        turns = np.abs(np.diff(np.concatenate([each, each[:1]]), axis=0))
        assert (np.count_nonzero(turns, axis=1) == 1).all()  # along the edges of pixels
        directions = (turns > 0)[:, 0]
        assert (directions != np.roll(directions, 1)).all()  # no corner on a straight line


@settings(max_examples=100, deadline=None)
@given(masks())
def test_joined_outlines_fill_all_parts(mask):
    whole = without_holes(mask)
    assert (whole == ndimage.binary_fill_holes(mask, np.ones((3, 3)))).all()
    if mask.any():
        assert filled(joined(outlines(whole)), mask.shape).tobytes() == whole.tobytes()


def test_what_is_inside_of_a_hole_is_covered_once():
    ring = np.ones((7, 7), bool)
    ring[1:6, 1:6] = False
    ring[3, 3] = True
    assert filled(joined(outlines(without_holes(ring))), ring.shape).all()


def test_corners_of_a_square():
    mask = np.zeros((5, 6), bool)
    mask[1:3, 2:5] = True
    [corners] = outlines(mask)
    assert sorted(map(tuple, corners.tolist())) == [(2, 1), (2, 3), (5, 1), (5, 3)]
