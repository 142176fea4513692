"""Masks that are filled by tiles of pixels have the bits of masks whose rays are traced one by one."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render.images import DEVICE, renderer_of
from tests.render.labels.test_label_tiles import some_scene, some_view
from usdsdg_render.labels.coverage import Coverage

pytestmark = pytest.mark.skipif(DEVICE != "cpu", reason="tiles are traced on CPUs")


def by_pixels(self, words, shown, mode, *_):
    return self._fill_words(words, shown, mode)


@pytest.mark.parametrize(("unit", "far"), [(1.0, 0.0), (1e-3, 0.0), (1.0, 1e2), (1e5, 1e6)])
def test_tiles_have_the_bits_of_rays(monkeypatch, unit, far):
    hidden = 0
    for seed in range(20, 40):
        rng = np.random.default_rng(seed)
        center = far * rng.normal(size=3)
        renderer = renderer_of(some_scene(rng, unit, center))
        groups = [[k] for k in range(len(renderer.gprims))]
        view = some_view(rng, unit, center)
        tiles = renderer.pixel_masks(view, groups)
        with monkeypatch.context() as patch:
            patch.setattr(Coverage, "_fill_by_tiles", by_pixels)
            pixels = renderer.pixel_masks(view, groups)
        np.testing.assert_array_equal(tiles.words, pixels.words)
        hidden += int((tiles.coverage[:, 0] - tiles.visible).sum())
    assert hidden > 500
