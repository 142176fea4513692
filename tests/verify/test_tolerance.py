"""How far files may differ that another version or device has made."""

import json

import numpy as np
import pytest
from PIL import Image

from usdsdg.verify.tolerance import Unknown, difference

PHOTO = np.random.default_rng(0).integers(0, 240, (40, 40, 3), dtype=np.uint8)
IDS = np.repeat(np.arange(40, dtype=np.uint8) // 10, 40).reshape(40, 40)


def images(tmp_path, one, other):
    for name, pixels in (("a.png", one), ("b.png", other)):
        Image.fromarray(pixels).save(tmp_path / name)
    return difference(tmp_path / "a.png", tmp_path / "b.png")


def test_colors_may_differ_a_little_everywhere_or_much_in_few_pixels(tmp_path):
    assert images(tmp_path, PHOTO, PHOTO + 8) is None
    assert images(tmp_path, PHOTO, PHOTO + 9) == "100.0 % of the pixels"
    spots = PHOTO.copy()
    spots[0, :16] = 255
    assert images(tmp_path, PHOTO, spots) is None
    spots[1, :1] = 255
    assert "1.1 %" in images(tmp_path, PHOTO, spots)


def test_ids_differ_or_not(tmp_path):
    assert images(tmp_path, IDS, IDS + 1) == "100.0 % of the pixels"
    edge = IDS.copy()
    edge[10, :16] = 0
    assert images(tmp_path, IDS, edge) is None


@pytest.mark.parametrize(
    ("one", "other", "said"),
    [
        ({"a": [1.0, 2]}, {"a": [1.0005, 3]}, None),
        ({"a": [1.0, 2]}, {"a": [1.01, 2]}, "a[0]: 1.0 and 1.01"),
        ({"a": [1.0, 2]}, {"a": [1.0, 4]}, "a[1]: 2 and 4"),
        ({"a": "x"}, {"a": "y"}, "a: 'x' and 'y'"),
        ({"a": True}, {"a": False}, "a: True and False"),
        ({"a": 1}, {"b": 1}, "the names: ['a', 'b']"),
        ({"a": [1]}, {"a": [1, 2]}, "a: 1 and 2 items"),
    ],
)
def test_values_of_json(tmp_path, one, other, said):
    (tmp_path / "a.json").write_text(json.dumps(one))
    (tmp_path / "b.json").write_text(json.dumps(other))
    assert difference(tmp_path / "a.json", tmp_path / "b.json") == said


def test_arrays_and_texts(tmp_path):
    np.save(tmp_path / "a.npy", np.linspace(0, 1, 500))
    np.save(tmp_path / "b.npy", np.linspace(0, 1, 500) + 5e-4)
    assert difference(tmp_path / "a.npy", tmp_path / "b.npy") is None
    np.save(tmp_path / "b.npy", np.linspace(0, 1, 500) + 1e-2)
    assert "of the values" in difference(tmp_path / "a.npy", tmp_path / "b.npy")
    (tmp_path / "a.txt").write_text("car 0.5 0.25 -1e-3")
    (tmp_path / "b.txt").write_text("car 0.5 0.25003 -1e-3")
    assert difference(tmp_path / "a.txt", tmp_path / "b.txt") is None
    (tmp_path / "b.txt").write_text("cup 0.5 0.25 -1e-3")
    assert difference(tmp_path / "a.txt", tmp_path / "b.txt") == "words"


def test_of_other_files_nothing_is_known(tmp_path):
    (tmp_path / "a.mp4").write_bytes(b"a")
    with pytest.raises(Unknown):
        difference(tmp_path / "a.mp4", tmp_path / "a.mp4")
