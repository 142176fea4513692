"""What a selection of labeled prims finds out about many pictures at once, against one pixel after the other."""

from __future__ import annotations

import numpy as np
import pytest

from usdsdg.annotators.pixels.look_ups import sum_by_gprim
from usdsdg.annotators.selection import Selection

HEIGHT, WIDTH, GPRIMS = 9, 13, 7


def selection(member_of_gprim: list[int], prims: int) -> Selection:
    nothing = np.zeros(prims, np.int64)
    return Selection(nothing, np.array(member_of_gprim, np.int32), ({},) * prims, nothing, {}, {}, nothing, prims)


def counted(picture: np.ndarray, members: np.ndarray) -> list[int]:
    """Pixels and inclusive bounds of the gprims of one prim."""
    rows, columns = np.nonzero(np.isin(picture, members))
    if not len(rows):
        return [0, -1, -1, -1, -1]
    return [len(rows), columns.min(), rows.min(), columns.max(), rows.max()]


@pytest.mark.parametrize(
    ("members", "prims"),
    [
        ([0, 1, 2, 3, 4, 5, 6], 7),  # each has one gprim
        ([2, 0, 2, -1, 0, 2, -1], 3),  # several gprims, none, and gprims that no selected prim has
        ([-1] * GPRIMS, 0),
        ([-1] * GPRIMS, 2),
    ],
)
def test_pixels_of_prims_are_those_of_their_gprims(members, prims):
    rng = np.random.default_rng(5)
    pictures = [rng.integers(-1, GPRIMS, (HEIGHT, WIDTH)).astype(np.int32) for _ in range(3)]
    pictures[1] = np.where(rng.random((HEIGHT, WIDTH)) < 0.9, -1, pictures[1]).astype(np.int32)
    pictures.append(np.full((HEIGHT, WIDTH), -1, np.int32))
    chosen = selection(members, prims)
    found = chosen.sum_members(np.stack([sum_by_gprim(each, GPRIMS) for each in pictures]))
    assert found.shape == (4, prims, 5)
    for picture, of_picture in zip(pictures, found, strict=True):
        for prim, sums in enumerate(of_picture):
            assert sums.tolist() == counted(picture, np.flatnonzero(np.equal(members, prim)))
