"""Stages as one layer."""

import os

import pytest
from pxr import Sdf, Usd

from usdsdg.stage import flatten


@pytest.mark.skipif(os.name == "nt", reason="Windows has names of characters only")
def test_a_working_folder_whose_name_is_no_utf8_leaves_relative_paths_as_they_are(tmp_path, monkeypatch):
    try:
        os.mkdir(folder := os.fsencode(tmp_path) + b"/\xff")
    except OSError:  # macOS
        pytest.skip("the file system has names of characters only")
    monkeypatch.chdir(os.fsdecode(folder))
    with open("skin.png", "wb"):
        pass
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/Skin")
    prim.CreateAttribute("file", Sdf.ValueTypeNames.Asset).Set("skin.png")
    flat = flatten.flattened(stage, tmp_path)
    assert flat.GetAttributeAtPath("/Skin.file").default.path == "skin.png"
