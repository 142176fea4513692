"""Values of a recipe: as JSON has them, with portable paths."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf

from usdsdg.stage.assets import anchors
from usdsdg.writers.journal.facts import plain


@pytest.fixture(autouse=True)
def _root(monkeypatch, tmp_path):
    monkeypatch.setenv("USDSDG_ASSETS_ROOT", str(tmp_path))


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (None, None), (True, True), (3, 3), (0.5, 0.5), ("a/b", "a/b"), ((1, "x"), [1, "x"]), ({1: (2,)}, {"1": [2]}),
        (np.float32(0.5), 0.5), (np.bool_(True), True), (np.arange(3), [0, 1, 2]), (np.array(["a"]), ["a"]),
        ({"a": [object()]}, {"a": ["<object>"]}), (Gf.Vec3f(1), "<Vec3f>"), ({1, 2}, "<set>"),
    ],
)  # fmt: skip
def test_values_are_those_of_json_and_others_the_name_of_their_type(value, expected):
    assert plain(value) == expected
    assert type(plain(value)) is type(expected)


def test_paths_are_portable_wherever_they_are(tmp_path):
    values = {"a": [str(tmp_path / "x.png")], "b": {"c": (tmp_path / "y",)}, "d": np.array([str(tmp_path / "z")])}
    named = {"a": ["<assets>/x.png"], "b": {"c": ["<assets>/y"]}, "d": ["<assets>/z"]}
    assert plain(values) == named


def test_values_that_are_not_of_json_stay_where_only_paths_are_wanted(tmp_path):
    size = np.float32(2)
    assert anchors.portable_value({1: (size, Path("a"))}) == {1: [size, "a"]}
    assert anchors.portable_value([size])[0] is size
