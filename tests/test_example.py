"""Content for examples."""

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
    with pytest.raises(AttributeError, match="it has TEXTURES"):
        _ = rep.example.MODELS
