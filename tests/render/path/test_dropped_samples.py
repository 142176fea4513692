"""The warning about samples that are not finite: for one image, and for a batch of images."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Usd

from usdsdg.errors import UsdsdgWarning
from usdsdg_render.path.dropped_samples import DroppedSamples
from usdsdg_render.path.film import Film
from usdsdg_render.path.film_batch import FilmBatch
from usdsdg_render.renderer import WarpRenderer


def drop(film: Film | FilmBatch, count: int) -> None:
    dropped = np.zeros(film.arrays.dropped.shape, np.int32)
    dropped[-1, 0] = count
    film.arrays.dropped.assign(dropped)


def test_those_of_one_image():
    film, dropped = Film(FilmBatch(1, 4, 3, "cpu")), DroppedSamples()
    dropped.look_at(film)
    drop(film, 2)
    with pytest.warns(UsdsdgWarning, match="2 samples of a 4x3 image were not finite"):
        dropped.look_at(film)


def test_one_sample_is_told_in_the_singular():
    dropped = DroppedSamples()
    film = Film(FilmBatch(1, 4, 3, "cpu"))
    drop(film, 1)
    with pytest.warns(UsdsdgWarning, match="^1 sample of a 4x3 image was not finite and was dropped$"):
        dropped.look_at(film)


def test_those_of_many_images_at_once():
    batch = FilmBatch(2, 4, 3, "cpu")
    drop(batch, 5)
    with pytest.warns(UsdsdgWarning, match="5 samples of a 4x3 image were not finite"):
        DroppedSamples().look_at(batch)
    batch.clear()
    assert not batch.arrays.dropped.numpy().any()


def test_a_renderer_tells_of_those_of_the_images_that_it_develops():
    renderer = WarpRenderer(Usd.Stage.CreateInMemory(), device="cpu")
    film = renderer.new_film(4, 3)
    drop(film, 7)
    with pytest.warns(UsdsdgWarning, match="7 samples of a 4x3 image were not finite"):
        renderer.develop(film)
