"""Rectangles of least area against a brute-force search over directions and against the edges of the convex hull."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from tests.annotators.ray_caster import make_frame
from tests.annotators.scenes import street
from usdsdg import annotators
from usdsdg.annotators.kinds import oriented_boxes
from usdsdg.stage.geometry.pixel_masks import MASK_WORD, PixelMasks


class _Frame:
    """The part of a frame that rectangles are made from."""

    def __init__(self, masks: list[np.ndarray]) -> None:
        words = []
        for group, mask in enumerate(masks):
            for row, line in enumerate(mask):
                for word in range(-(-len(line) // 64)):
                    bits = sum(1 << k for k, shown in enumerate(line[64 * word : 64 * word + 64]) if shown)
                    if bits:
                        words.append((group, row, word, bits, bits))
        self.amodal_masks = PixelMasks(
            masks[0].shape, len(masks), lambda: np.array(words, MASK_WORD), coverage=np.zeros(0), visible=np.zeros(0)
        )
        self.labeled_prims = range(len(masks))


def corners_of(mask: np.ndarray) -> np.ndarray:
    """Return the corners of all pixels of a mask, (N, 2) column and row."""
    rows, columns = np.nonzero(mask)
    at = np.stack([columns, rows], axis=1)
    return np.concatenate([at + offset for offset in ((0, 0), (1, 0), (0, 1), (1, 1))]).astype(float)


def area_at(points: np.ndarray, angle: float) -> float:
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return float(np.prod(np.ptp(points @ turn, axis=0)))


def least_area(points: np.ndarray) -> float:
    """Return the least area over the directions between any two points, of which the hull's edges are some."""
    points = np.unique(points, axis=0)
    if len(points) > 60:  # the outermost of each row are enough
        kept = [points[points[:, 1] == y] for y in np.unique(points[:, 1])]
        points = np.concatenate([each[[0, -1]] for each in kept])
    difference = (points[:, None] - points[None])[np.triu_indices(len(points), 1)]
    angles = np.unique(np.round(np.arctan2(difference[:, 1], difference[:, 0]) % (np.pi / 2), 12))
    return min(area_at(points, angle) for angle in angles)


def check(mask: np.ndarray, rectangle: np.ndarray) -> None:
    x, y, dx, dy, width, height = rectangle
    points = corners_of(mask)
    np.testing.assert_allclose(width * height, least_area(points), rtol=1e-9)
    along, down = (points - (x, y)) @ (dx, dy), (points - (x, y)) @ (-dy, dx)
    np.testing.assert_allclose([np.abs(along).max(), np.abs(down).max()], [width / 2, height / 2], rtol=1e-9)


masks = arrays.arrays(bool, st.tuples(st.integers(1, 9), st.integers(1, 9))).filter(np.any)


@given(masks)
@settings(max_examples=60, deadline=None)
def test_the_rectangle_is_the_least_around_the_pixels(mask):
    check(mask, oriented_boxes._rectangles(_Frame([mask]), "visible")[0])


def test_rectangles_of_wide_masks_and_of_masks_without_pixels():
    rng = np.random.default_rng(0)
    y, x = np.mgrid[:40, :150]
    turned = np.abs((x - 75) * 0.96 + (y - 20) * 0.28) + 3 * np.abs((y - 20) * 0.96 - (x - 75) * 0.28) < 40
    scattered = rng.random((40, 150)) < 0.002
    found = oriented_boxes._rectangles(_Frame([turned, np.zeros_like(turned), scattered]), "covered")
    check(turned, found[0])
    np.testing.assert_array_equal(found[1], 0)
    check(scattered, found[2])


def test_angles_sides_and_corners_agree():
    frame = make_frame(street())
    for name in ("oriented_bounding_box_2d", "oriented_bounding_box_2d_amodal"):
        annotation = annotators.get(name).compute(frame)
        assert len(annotation.data) == len(annotation.info["primPaths"]) > 2
        for row in annotation.data:
            assert 0 <= row["angle"] < 90
            corners = row["corners"].astype(float)
            assert corners[:, 1].argmin() == 0
            sides = np.diff(np.concatenate([corners, corners[:1]]), axis=0)
            lengths = np.linalg.norm(sides, axis=1)
            np.testing.assert_allclose(lengths, [row["width"], row["height"]] * 2, atol=1e-4)
            if row["width"] > 0:
                direction = np.degrees(np.arctan2(sides[0, 1], sides[0, 0]))
                np.testing.assert_allclose(direction, row["angle"], atol=1e-3)
            np.testing.assert_allclose(corners.mean(0), (row["x"], row["y"]), atol=1e-4)


def test_the_visible_part_of_an_occluded_object_has_a_smaller_rectangle():
    frame = make_frame(street())
    modal, amodal = (annotators.get(f"oriented_bounding_box_2d{kind}").compute(frame) for kind in ("", "_amodal"))
    area = {
        path: [each.data[each.info["primPaths"].index(path)] for each in (modal, amodal)]
        for path in ("/World/Apple1", "/World/Apple2")
    }
    sizes = {path: [row["width"] * row["height"] for row in rows] for path, rows in area.items()}
    assert sizes["/World/Apple1"][0] == sizes["/World/Apple1"][1]
    assert sizes["/World/Apple2"][0] < sizes["/World/Apple2"][1]
    assert "/World/Hidden" in amodal.info["primPaths"]
    assert "/World/Hidden" not in modal.info["primPaths"]
