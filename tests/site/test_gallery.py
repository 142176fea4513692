"""The programs of the gallery run, tiny, and leave a picture that is not black; those shown are small files."""

import os

import numpy as np
import pytest
from PIL import Image

from docs.site.gallery_pages import FOLDER, NAMES
from tests import forked
from tests.sampled_cases import sampled
from tests.site.walk import kernels

TINY = {"WIDTH": "24", "SAMPLES": "1", "PARTS": "1"}


def test_every_program_is_shown():
    assert {file.stem for file in FOLDER.glob("*.py")} == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_the_picture_is_small_and_480_pixels_wide(name):
    file = FOLDER / f"{name}.png"
    assert file.stat().st_size < 150_000
    with Image.open(file) as picture:
        assert picture.width == 480


@pytest.mark.parametrize("names", [sampled(NAMES, 3)])
def test_the_programs_make_their_pictures(names, tmp_path):
    """In one process, to load the engines once."""
    run = "import runpy, sys, usdsdg as rep\nfor path in sys.argv[1:]:\n    rep.new_stage()\n    runpy.run_path(path)\n"
    arguments = ["-c", run, *(str(FOLDER / f"{name}.py") for name in names)]
    variables = {**os.environ, **TINY, "WARP_CACHE_PATH": kernels()}
    done = forked.run(arguments, cwd=tmp_path, env=variables)
    assert done.returncode == 0, done.stderr
    for name in names:
        with Image.open(tmp_path / f"{name}.png") as picture:
            assert np.asarray(picture.convert("L")).max() > 40
