"""Films of one size share memory and launches, and their memory is used again; their images do not depend on it."""

from __future__ import annotations

import numpy as np

from tests.render import scenes
from tests.render.images import renderer_of
from tests.render.path.test_wavefront import everything
from usdsdg_render.path import film_pool
from usdsdg_render.settings import PathSettings, ToneSettings

SIZE = (24, 18)
VIEWS = [scenes.view_from((x, -4, 2), size=SIZE) for x in (-1, 0, 1)]
SETTINGS = PathSettings(denoise=True)


def alone(renderer, view, settings=SETTINGS, tone=None):
    film = renderer.new_film(*SIZE)
    renderer.accumulate(film, view, samples=3, settings=settings)
    return renderer.develop(film, tone)


def test_films_of_one_call_give_the_images_of_single_ones():
    renderer = renderer_of(everything())
    films = renderer.new_films(3, *SIZE)
    assert len({film.batch for film in films}) == 1
    renderer.accumulate_all(films, VIEWS, samples=3, settings=SETTINGS)
    for image, view in zip(renderer.develop_all(films), VIEWS, strict=True):
        expected = alone(renderer, view)
        assert image.keys() == expected.keys() == {"HdrColor", "LdrColor"}
        for name, values in expected.items():
            np.testing.assert_array_equal(image[name], values)


def test_one_film_of_a_batch_can_be_developed():
    renderer = renderer_of(everything())
    films = renderer.new_films(2, *SIZE)
    renderer.accumulate_all(films, VIEWS[:2], samples=3, settings=SETTINGS)
    np.testing.assert_array_equal(renderer.develop(films[1])["HdrColor"], alone(renderer, VIEWS[1])["HdrColor"])


def test_light_aovs_are_those_of_each_film():
    renderer = renderer_of(everything())
    settings = PathSettings(light_aovs=True)
    films = renderer.new_films(2, *SIZE)
    renderer.accumulate_all(films, VIEWS[:2], samples=3, settings=settings)
    for image, view in zip(renderer.develop_all(films), VIEWS):
        for name, values in alone(renderer, view, settings).items():
            np.testing.assert_array_equal(image[name], values, err_msg=name)


def test_a_film_in_used_memory_is_empty_and_has_no_features():
    renderer = renderer_of(everything())
    film = renderer.new_film(*SIZE)
    renderer.accumulate(film, VIEWS[0], samples=3, settings=PathSettings(denoise=True, light_aovs=True))
    images, batch = renderer.develop(film), film.batch
    kept = {name: values.copy() for name, values in images.items()}
    del film
    again = renderer.new_film(*SIZE)
    assert again.batch is batch
    assert not again.radiance().any()
    assert (again.samples, again.has_features, again.has_light_aovs) == (0, False, False)
    plain = PathSettings()
    renderer.accumulate(again, VIEWS[1], samples=3, settings=plain)
    developed = renderer.develop(again)
    assert developed.keys() == {"HdrColor", "LdrColor"}
    for name, values in kept.items():  # images that were handed out stay as they are
        np.testing.assert_array_equal(images[name], values, err_msg=name)
    fresh = renderer_of(everything())
    np.testing.assert_array_equal(developed["HdrColor"], alone(fresh, VIEWS[1], plain)["HdrColor"])


def test_features_of_used_memory_begin_anew():
    renderer = renderer_of(everything())
    first = alone(renderer, VIEWS[0])
    alone(renderer, VIEWS[1])
    np.testing.assert_array_equal(alone(renderer, VIEWS[0])["HdrColor"], first["HdrColor"])


def test_films_in_use_do_not_share_memory():
    renderer = renderer_of(everything())
    one, other = renderer.new_film(*SIZE), renderer.new_film(*SIZE)
    assert one.batch is not other.batch


def test_many_films_are_divided_into_batches(monkeypatch):
    monkeypatch.setattr(film_pool, "BATCH_PIXELS", 2 * SIZE[0] * SIZE[1])
    renderer = renderer_of(everything())
    films = renderer.new_films(3, *SIZE)
    assert [film.batch.images for film in films] == [2, 2, 1]
    renderer.accumulate_all(films, VIEWS, samples=2, settings=PathSettings())
    for film, view in zip(films, VIEWS):
        expected = renderer.new_film(*SIZE)
        renderer.accumulate(expected, view, samples=2, settings=PathSettings())
        np.testing.assert_array_equal(film.radiance(), expected.radiance())


def test_memory_that_is_kept_is_limited(monkeypatch):
    monkeypatch.setattr(film_pool, "KEPT_BYTES", 1)
    renderer = renderer_of(everything())
    for width in (8, 9, 10):
        renderer.new_film(width, 8)
    assert [batch.width for batch in renderer._films._free] == [10]


def test_an_image_that_is_blended_with_the_noisy_one_differs_from_both():
    renderer = renderer_of(everything())
    noisy, clean, both = (
        alone(renderer, VIEWS[0], tone=tone)["HdrColor"].astype(float)
        for tone in (ToneSettings(denoise=False), ToneSettings(), ToneSettings(denoiser_blend=0.5))
    )
    np.testing.assert_allclose(both, (noisy + clean) / 2, rtol=2e-3, atol=1e-4)
    assert np.abs(noisy - clean).max() > 0.01
