"""The extractor of a file's own stage."""

import pytest

from usdsdg_render.sync.extract import SceneExtractor


@pytest.fixture
def extractor(stage):
    """Of `stage`, of which it has read all."""
    extractor = SceneExtractor(stage)
    extractor.update()
    return extractor
