"""Content for examples."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import usdsdg as rep


def test_textures_are_images_that_randomizers_take(stage):
    textures = rep.example.TEXTURES
    assert len(set(textures)) == 6
    for file in textures:
        with Image.open(file) as image:
            assert np.array(image).ndim == 3
    with rep.create.cube():
        rep.randomizer.texture(textures=textures)
    folder = Path(rep.example.TEXTURES_DIR)
    assert {Path(file) for file in textures if "Warehouse" in file} <= set(folder.iterdir())
    with pytest.raises(AttributeError, match="it has TEXTURES and TEXTURES_DIR"):
        _ = rep.example.MODELS
    with pytest.raises(AttributeError, match="get_assets_root_path"):
        _ = rep.example.ASSETS_DIR
