"""COCO's run lengths: undone by a decoder of their own, and equal to what COCO's library writes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from usdsdg.writers.formats.shapes.run_length import encoded, runs_of_ids


def decoded(text: str, shape: tuple[int, int]) -> np.ndarray:
    """The mask of COCO's compact text, character by character."""
    lengths: list[int] = []
    place = 0
    while place < len(text):
        number = shift = 0
        follows = True
        while follows:
            bits = ord(text[place]) - 48
            number |= (bits & 0x1F) << shift
            follows, shift, place = bool(bits & 0x20), shift + 5, place + 1
        if bits & 0x10:
            number -= 1 << shift
        lengths.append(number + lengths[-2] if len(lengths) > 2 else number)
    inside = [bool(index % 2) for index, length in enumerate(lengths) for _ in range(length)]
    return np.array(inside, bool).reshape(shape, order="F")


shapes = st.tuples(st.integers(1, 40), st.integers(1, 40))


@given(ids=shapes.flatmap(lambda shape: arrays(np.uint32, shape, elements=st.integers(0, 4))))
def test_every_mask_of_a_picture_comes_back(ids):
    runs = runs_of_ids(ids)
    assert set(runs) == set(np.unique(ids).tolist())
    for value, lengths in runs.items():
        np.testing.assert_array_equal(decoded(encoded(lengths), ids.shape), ids == value)
        assert lengths[1::2].sum() == (ids == value).sum()


@given(size=st.integers(1, 3000), start=st.integers(0, 2999))
def test_lengths_of_several_characters_come_back(size, start):
    ids = np.zeros((60, 100), np.uint32)
    ids.reshape(-1)[start : start + size] = 1
    np.testing.assert_array_equal(decoded(encoded(runs_of_ids(ids)[1]), ids.shape), ids == 1)


def ring():
    y, x = np.mgrid[:48, :64]
    distance = np.hypot(y - 20, x - 30)
    return (distance < 15) & (distance > 6)


def corners():
    mask = np.zeros((7, 5), bool)
    mask[0, 0] = mask[-1, -1] = True
    return mask


# What pycocotools 2.0.11 makes of these masks.
KNOWN = {
    ring: "_h0;S14M2M4M2O0O2N2OB\\O0c0NC0<OF0:OH080H080H08OJ061H080H080H081F0:1D0=2]O0d0>1N2N101N3L3N3LSl0",
    corners: "01Q10",
}


@pytest.mark.parametrize("mask", KNOWN)
def test_the_text_is_that_of_cocos_library(mask):
    assert encoded(runs_of_ids(mask().astype(np.uint32))[1]) == KNOWN[mask]


def test_a_mask_of_all_pixels():
    lengths = runs_of_ids(np.ones((6, 9), np.uint32))[1]
    assert lengths.tolist() == [0, 54]
