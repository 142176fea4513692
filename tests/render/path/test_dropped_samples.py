"""Samples that are not finite are told of, of single images and of many at once."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from usdsdg.errors import UsdsdgWarning, forget_warnings
from usdsdg_render.path.dropped_samples import look_for_dropped
from usdsdg_render.path.film import Film
from usdsdg_render.path.film_batch import FilmBatch
from usdsdg_render.settings import ToneSettings


@pytest.fixture(autouse=True)
def _untold() -> None:
    forget_warnings()


def drop(film: Film | FilmBatch, count: int) -> None:
    dropped = np.zeros(film.arrays.dropped.shape, np.int32)
    dropped[-1, 0] = count
    film.arrays.dropped = wp.array(dropped, dtype=wp.int32, device="cpu")


def test_those_of_one_image():
    film = Film(4, 3, "cpu")
    look_for_dropped(film)
    drop(film, 2)
    with pytest.warns(UsdsdgWarning, match="2 samples of a 4x3 image were not finite"):
        look_for_dropped(film)


def test_those_of_many_images_at_once():
    batch = FilmBatch(2, 4, 3, "cpu", features=False)
    drop(batch, 5)
    with pytest.warns(UsdsdgWarning, match="5 samples of a 4x3 image were not finite"):
        batch.develop(ToneSettings(denoise=False), threads=1)
    batch.clear()
    assert not batch.arrays.dropped.numpy().any()
