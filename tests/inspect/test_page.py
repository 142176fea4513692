"""The page as a file: self-contained, bounded, whole, and clear where there is nothing to show."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from tests.inspect.datasets import pose_object, write_pose
from tests.inspect.page import Page
from usdsdg.errors import DatasetError, OutputNotWritable
from usdsdg.inspect import inspect
from usdsdg.inspect.statistics import BINS, nice_edges

MUG = pose_object(None, "mug", [0.0, 0.0, -2.0], [0.2] * 3)


def noisy(folder, count: int, size=(320, 240)) -> None:
    """Pictures that do not compress."""
    rng = np.random.default_rng(0)
    for number in range(count):
        write_pose(folder, number, [MUG])
        Image.fromarray(rng.integers(0, 255, (size[1], size[0], 3), np.uint8)).save(folder / f"{number:06d}.png")


def test_nothing_is_loaded_from_elsewhere(tmp_path):
    write_pose(tmp_path, 0, [MUG])
    made = Page(inspect(tmp_path))
    asked = [attributes.get("href") or attributes.get("src") for _, attributes in made.tags]
    assert {each for each in asked if each} <= {"data:,"}  # the icon that browsers would ask for
    # The name of the SVG language is no address that anybody visits.
    assert set(re.findall(r"https?://[^\"' ]+", made.text)) == {"http://www.w3.org/2000/svg"}
    assert "@import" not in made.text
    assert "url(" not in made.text


def test_labels_and_paths_cannot_break_out_of_the_data(tmp_path):
    evil = {**MUG, "label": "</script><img src=x>", "prim_path": "<!--"}
    write_pose(tmp_path, 0, [evil])
    made = Page(inspect(tmp_path))
    assert made.values["classes"][0]["name"] == "</script><img src=x>"
    assert not [tag for tag, _ in made.tags if tag == "img"]


def test_the_page_lies_in_the_folder_or_where_it_is_wanted(tmp_path):
    write_pose(tmp_path / "data", 0, [MUG])
    assert inspect(tmp_path / "data") == tmp_path / "data" / "inspect.html"
    assert inspect(str(tmp_path / "data"), str(tmp_path / "new" / "page.html")).is_file()
    # A page in the folder is no part of the dataset, and nothing else is left there.
    again = Page(inspect(tmp_path / "data"))
    assert len(again.values["frames"]) == 1
    assert {path.name for path in (tmp_path / "data").iterdir()} == {"000000.png", "000000.json", "inspect.html"}


def test_folders_of_any_name_are_shown_in_any_locale(tmp_path):
    folder = tmp_path / "données ü"
    write_pose(folder, 0, [MUG])
    plain = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    done = subprocess.run(
        [sys.executable, "-m", "usdsdg", "inspect", os.fsencode(folder)],
        env={**os.environ, **plain},
        capture_output=True,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.rstrip() == os.fsencode(folder / "inspect.html")
    made = Page(folder / "inspect.html")
    assert made.values["title"] == "données ü"
    assert "<title>données ü" in made.text


def test_pictures_get_smaller_before_frames_are_left_out(tmp_path):
    noisy(tmp_path, 6, (960, 720))
    full = Page(inspect(tmp_path))
    assert full.values["notes"] == []
    assert full.image(full.frame("000000")["picture"]).size == (960, 720)
    smaller = Page(inspect(tmp_path, budget=len(full.text) // 3))
    assert len(smaller.values["frames"]) == 6
    assert max(smaller.image(smaller.frame("000000")["picture"]).size) in (720, 540, 400)
    assert "shown at most" in smaller.values["notes"][0]
    # Coordinates stay those of the original.
    assert smaller.frame("000000")["size"] == [960, 720]
    assert smaller.frame("000000")["objects"] == full.frame("000000")["objects"]


def test_many_frames_are_sampled_evenly_and_counted_all(tmp_path):
    noisy(tmp_path, 40)
    (tmp_path / "000033.json").write_text("{")
    budget = 300_000
    made = Page(inspect(tmp_path, budget=budget))
    names = [frame["name"] for frame in made.values["frames"]]
    assert 3 <= len(names) < 40
    assert len(made.text) < 1.5 * budget + 60_000
    assert names == sorted(names)
    assert "000000" in names
    # A frame with a problem is among them.
    assert "000033" in names
    assert made.values["totals"] == {"frames": 40, "shown": len(names), "objects": 39}
    assert made.values["classes"][0]["objects"] == 39
    assert f"{len(names)} of 40 pictures are on this page" in made.values["notes"][0]


def test_a_folder_without_a_dataset_is_explained(tmp_path):
    (tmp_path / "notes.txt").write_text("hello")
    (tmp_path / "cat.png").write_bytes(b"")
    with pytest.raises(DatasetError) as caught:
        inspect(tmp_path)
    message = str(caught.value)
    assert "rgb_0000.png of BasicWriter, only 1 x" in message
    assert "1 x .png" in message
    assert "output_dir" in message
    assert len(message) < 300 + len(str(tmp_path))
    assert not (tmp_path / "inspect.html").exists()


def test_a_missing_folder_is_named(tmp_path):
    with pytest.raises(DatasetError, match="nowhere does not exist"):
        inspect(tmp_path / "nowhere")
    (tmp_path / "file").write_text("")
    with pytest.raises(DatasetError, match="file is a file; give the folder"):
        inspect(tmp_path / "file")


def test_a_page_that_cannot_be_written_is_named(tmp_path):
    write_pose(tmp_path, 0, [MUG])
    (tmp_path / "blocked").write_text("")
    with pytest.raises(OutputNotWritable, match=r"blocked.*choose another file with --output"):
        inspect(tmp_path, tmp_path / "blocked" / "page.html")


def test_progress_counts_pictures(tmp_path):
    noisy(tmp_path, 3)
    told = []
    inspect(tmp_path, progress=lambda *report: told.append(report))
    assert told == [("pictures", number, 3) for number in (1, 2, 3)]


def test_nan_never_reaches_the_page(tmp_path):
    odd = json.loads(json.dumps(MUG))
    odd["visibility"] = float("nan")
    write_pose(tmp_path, 0, [odd])
    made = Page(inspect(tmp_path))
    assert "visibility" not in made.frame("000000")["objects"][0]


@given(st.floats(1e-5, 1e7))
def test_edges_are_round_and_cover_everything(highest):
    edges = nice_edges(highest)
    assert edges[0] == 0.0
    assert edges[-1] >= highest * (1 - 1e-9)
    assert len(edges) - 1 <= BINS + 1
    steps = np.diff(edges)
    assert steps == pytest.approx(steps[0])
    assert any(abs(steps[0] / 10.0 ** np.floor(np.log10(steps[0]) + 1e-9) - nice) < 1e-6 for nice in (1, 2, 2.5, 5, 10))
