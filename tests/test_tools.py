"""`rep.tools`: masks, boxes and distances as pictures."""

import colorsys
import hashlib
import math

import numpy as np
import pytest

import usdsdg as rep
from usdsdg.errors import ArgumentError

LABELS = {"0": {"class": "BACKGROUND"}, "2": {"class": "Cube"}, "3": {"class": "ball"}}


def test_segmentation_is_colored_by_id():
    mask = np.array([[0, 2], [3, 9]], np.uint32)
    image, labels, ids = rep.tools.colorize_segmentation(mask, LABELS)
    assert image.shape == (2, 2, 4)
    assert image.dtype == np.uint8
    assert tuple(image[0, 0]) == (0, 0, 0, 0)
    assert labels[tuple(image[0, 1].tolist())] == {"class": "Cube"}
    assert ids[tuple(image[0, 1].tolist())] == "2"
    assert labels[tuple(image[1, 1].tolist())] == "UNLABELLED"


@pytest.mark.parametrize("labels", [LABELS, {int(key): value for key, value in LABELS.items()}])
def test_segmentation_in_colors_of_a_table(labels):
    image = rep.tools.colorize_segmentation(np.array([[0, 2, 3]]), labels, {"cube": (1, 2, 3, 255)})
    assert image.tolist() == [[[0, 0, 0, 0], [1, 2, 3, 255], [0, 0, 0, 0]]]


def test_distance_is_white_near_and_black_far():
    image = rep.tools.colorize_distance(np.array([[1.0, 10.0, 100.0, np.inf]], np.float32), near=None, far=None)
    assert image.tolist() == [[255, 127, 0, 0]]
    assert rep.tools.colorize_distance(np.full((2, 2), 3.0, np.float32), None, None).tolist() == [[255, 255]] * 2


def test_motion_has_replicators_colors():
    # omni.replicator.core 1.12.27, writers_default/tools.py: polar angles as hue and lightness of HLS.
    directions = [(1, 0, 0), (-0.5, 0, 0), (0, 2, 0), (0, -2, 0), (0, 0, 0), (0.3, -0.4, 0.5), (3, 4, -2)]

    def color(x, y, z):
        hue = (math.degrees(math.atan2(y, x)) + 180) / 360
        lightness = math.degrees(math.atan2(math.sqrt(x * x + y * y), z)) / 180
        return [*colorsys.hls_to_rgb(hue, lightness, 1.0), 1.0]

    image = rep.tools.colorize_motion_vector(np.array([[(*each, 0) for each in directions]], np.float32))
    assert image.dtype == np.uint8
    assert image.shape == (1, 7, 4)
    np.testing.assert_allclose(image[0], [np.multiply(color(*each), 255) for each in directions], atol=1)
    assert image[0, 0].tolist() == [0, 255, 255, 255]
    assert image[0, 4].tolist() == [0, 0, 0, 255]


def box(left, top, right, bottom):
    rows = np.zeros(1, [("semanticId", "<u4"), *((name, "<i4") for name in ("x_min", "y_min", "x_max", "y_max"))])
    rows["x_min"], rows["y_min"], rows["x_max"], rows["y_max"] = left, top, right, bottom
    return rows


def test_boxes_are_drawn_around_inclusive_pixels():
    image = rep.tools.colorize_bbox_2d(np.zeros((20, 30, 3), np.uint8), box(4, 6, 20, 15))
    rows, columns = np.nonzero(image.any(axis=2))
    assert (columns.min(), rows.min(), columns.max(), rows.max()) == (4, 6, 20, 15)


def test_boxes_follow_a_shift_of_the_picture():
    shift = np.array([[1, 0, 0], [0, 1, 0], [2, 5, 1]], float)  # two rows down, five columns right
    for rotated in (False, True):
        image = rep.tools.colorize_bbox_2d(np.zeros((20, 30, 3), np.uint8), box(4, 6, 20, 15), shift, rotated)
        rows, columns = np.nonzero(image.any(axis=2))
        # A polygon's lines of two pixels lie around the corners.
        assert np.abs(np.subtract((columns.min(), rows.min(), columns.max(), rows.max()), (9, 8, 25, 17))).max() <= 1
    with pytest.raises(ArgumentError, match="3 x 3"):
        rep.tools.colorize_bbox_2d(image, box(0, 0, 1, 1), np.eye(2))


def test_color_of_a_label_is_from_its_hash():
    key = int(hashlib.sha256(b"cube").hexdigest()[:8], 16)
    red, green, blue = (((key >> shift & 255) + 1) * 33 % 255 for shift in (0, 8, 16))
    expected = tuple(int(each * 384 / (red + green + blue)) for each in (red, green, blue))
    assert rep.tools.data_to_colour("cube") == rep.tools.data_to_colour(b"cube") == expected


def test_random_colours_repeat():
    first, second = rep.tools.random_colours(7), rep.tools.random_colours(7)
    assert first.shape == (7, 4)
    assert (first == second).all()
    assert len(np.unique(first, axis=0)) == 7


def test_colors_in_order_are_those_of_ids_as_in_replicator():
    # omni.replicator.core 1.12.27: the colors of segmentations, with a hue of 0 turns, 0.7 and 0.8 for id 0.
    assert rep.tools.random_colours_id(0) == (204, 61, 61, 255)
    assert rep.tools.random_colours_id(0, num_channels=3) == (204, 61, 61)
    colors = rep.tools.random_colours(4, enable_random=False, start=2)
    assert colors.dtype == np.uint8
    assert [tuple(color) for color in colors.tolist()] == [rep.tools.random_colours_id(each) for each in (2, 3, 4, 5)]
    assert rep.tools.random_colours(2, False, 3).tolist() == [list(rep.tools.random_colours_id(n, 3)) for n in (0, 1)]


def test_run_lengths_are_by_columns():
    assert rep.tools.binary_mask_to_rle(np.array([[1, 0], [1, 1]])) == {"counts": [0, 2, 1, 1], "size": [2, 2]}
