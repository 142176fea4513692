"""Portions of the frames of a run."""

import pytest

from usdsdg.errors import BadValue
from usdsdg.writers.journal.portion import Portion


@pytest.mark.parametrize(
    ("portion", "frames", "name"),
    [
        (Portion.of_frames("2:5"), [2, 3, 4], "2-5"),
        (Portion.of_frames(":2"), [0, 1], "0-2"),
        (Portion.of_frames("7:"), [7, 8, 9], "7-end"),
        (Portion.of_shard("0/1"), list(range(10)), "0-end"),
        (Portion.of_shard("1/4"), [1, 5, 9], "1-of-4"),
    ],
)
def test_frames_of_a_portion(portion, frames, name):
    assert [number for number in range(10) if portion.has(number)] == frames
    assert [portion.count(end) for end in range(11)] == [sum(map(portion.has, range(end))) for end in range(11)]
    assert portion.name == name
    assert Portion.of_name(name) == portion


def test_frames_by_number_are_counted():
    portion = Portion.of_numbers("0,12,3")
    assert [portion.count(end) for end in (0, 1, 12, 13, 20)] == [0, 1, 2, 3, 3]


def test_a_portion_is_over_after_its_last_frame():
    assert not Portion.of_frames("2:5").is_over(4)
    assert Portion.of_frames("2:5").is_over(5)
    assert not Portion.of_shard("0/2").is_over(10**9)


@pytest.mark.parametrize("text", ["", "5", "5:5", "6:2", "-1:3", "a:b", "1:2:3"])
def test_wrong_frames_are_errors(text):
    with pytest.raises(BadValue, match="--frames"):
        Portion.of_frames(text)


@pytest.mark.parametrize("text", ["", "1", "2/2", "0/0", "-1/2", "1/x", "0/2/3"])
def test_wrong_shards_are_errors(text):
    with pytest.raises(BadValue, match="--shard"):
        Portion.of_shard(text)
