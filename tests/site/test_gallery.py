"""Programs of pictures run, tiny, and leave pictures that are not black; those shown are small files."""

import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from docs import pictures
from docs.site.gallery_pages import FOLDER, NAMES
from tests import forked
from tests.sampled_cases import sampled
from tests.site.walk import kernels

TINY = {"WIDTH": "48", "SAMPLES": "4", "PARTS": "1"}
OF_PAGES = tuple(file.stem for file in sorted(pictures.IMAGES.glob("*.py")))
SCREENSHOTS = {"viewer"}


def test_every_program_is_shown():
    assert {file.stem for file in FOLDER.glob("*.py")} == set(NAMES)


def test_every_picture_of_a_page_has_a_program_or_example_that_makes_it():
    shown = {file.stem for folder in (pictures.IMAGES, FOLDER) for file in folder.glob("*.png")}
    assert shown - SCREENSHOTS == set(pictures.names())


@pytest.mark.parametrize("name", NAMES)
def test_the_picture_is_small_and_480_pixels_wide(name):
    file = FOLDER / f"{name}.png"
    assert file.stat().st_size < 150_000
    with Image.open(file) as picture:
        assert picture.width == 480


@pytest.mark.parametrize("names", [sampled(NAMES, 3), sampled(OF_PAGES, 2)])
def test_the_programs_make_their_pictures(names, tmp_path):
    """In one process, to load the engines once."""
    run = "import runpy, sys, usdsdg as rep\nfor path in sys.argv[1:]:\n    rep.new_stage()\n    runpy.run_path(path)\n"
    programs = {each.stem: each for folder in (FOLDER, pictures.IMAGES) for each in folder.glob("*.py")}
    arguments = ["-c", run, *(str(programs[name]) for name in names)]
    variables = {**os.environ, **TINY, "WARP_CACHE_PATH": kernels()}
    done = forked.run(arguments, cwd=tmp_path, env=variables)
    assert done.returncode == 0, done.stderr
    for name in names:
        with Image.open(tmp_path / f"{name}.png") as picture:
            assert np.asarray(picture.convert("L")).max() > 40


def test_a_picture_takes_the_place_of_the_one_that_is_there(tmp_path, monkeypatch):
    monkeypatch.setattr(pictures, "IMAGES", tmp_path)
    assert pictures.make({"example_many_cameras"}) == [tmp_path / "example_many_cameras.png"]
    folders = (tmp_path, pictures.ROOT / "docs" / "images")
    made, shown = (np.asarray(Image.open(each / "example_many_cameras.png").convert("RGB")) for each in folders)
    assert (made != shown).any(axis=-1).mean() < 0.005  # pixels at edges may be others on a GPU


def test_large_pictures_get_a_palette(tmp_path: Path):
    noise = Image.fromarray(np.random.default_rng(0).integers(0, 255, (150, 200, 3), np.uint8))
    pictures.save_small(noise, tmp_path / "example_noise.png")
    assert (tmp_path / "example_noise.png").stat().st_size < 60_000
