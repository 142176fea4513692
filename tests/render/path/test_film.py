"""Accumulation and tone mapping: numbered samples, independence of threads, photographic exposure."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import EXACT, radiance, renderer_of
from usdsdg.errors import RenderError, UsdsdgWarning
from usdsdg_render.settings import PathSettings, ToneSettings


def lit_scene():
    return scenes.scene_of(
        [(scenes.sphere(rings=16), scenes.moved((0, 0, 1)), 0), (scenes.square(), scenes.moved(scale=4), 1)],
        materials=[scenes.material(roughness=0.3, metallic=1.0), scenes.material(base_color=0.5)],
        lights=[scenes.sphere_light(300.0, (2, -2, 4), 0.5)],
        dome=scenes.white_dome(2.0),
    )


VIEW = scenes.view_from((3, -5, 3), (0, 0, 0.5), size=(40, 30))


def film_of(renderer, *parts, view=VIEW, **settings):
    film = renderer.new_film(view.width, view.height)
    first = 0
    for samples in parts:
        renderer.accumulate(film, view, samples=samples, settings=PathSettings(first_sample=first, **settings))
        first += samples
    return film


def test_threads_and_splits_do_not_change_a_bit():
    renderer = renderer_of(lit_scene(), threads=1)
    once = film_of(renderer, 16).arrays.color.numpy()
    in_parts = film_of(renderer, 1, 4, 11).arrays.color.numpy()
    np.testing.assert_array_equal(in_parts, once)
    for threads in (2, 3):
        renderer.threads = threads
        np.testing.assert_array_equal(film_of(renderer, 16).arrays.color.numpy(), once)


def test_seed_and_frame_change_the_noise_and_nothing_else():
    renderer = renderer_of(lit_scene())
    pictures = [film_of(renderer, 64, **key).radiance() for key in ({}, {"seed": 1}, {"frame": 1})]
    for k in (1, 2):
        assert (pictures[k] != pictures[0]).any()
        np.testing.assert_allclose(pictures[k].mean(), pictures[0].mean(), rtol=0.02)


def test_sobol_samples_beat_independent_ones():
    # Light of a ball on a floor, seen in full: the error of n well-spread samples falls faster than 1 / sqrt(n).
    floor = scenes.scene_of(
        [(scenes.square(), scenes.moved(scale=100), 0)],
        lights=[scenes.sphere_light(100.0, (0, 0, 5), 3.0, visible=0), scenes.sphere_light(500.0, (4, 0, 3), 0.5)],
        dome=scenes.white_dome(3.0),
    )
    renderer = renderer_of(floor)
    view = scenes.view_from((0, -3, 30), up=(0, 1, 0), size=(32, 32), focal_length=500.0)
    reference = film_of(renderer, 4096, view=view, bounces=1, seed=99).radiance()
    error = {}
    for n in (1, 64):
        error[n] = np.sqrt(((film_of(renderer, n, view=view, bounces=1).radiance() - reference) ** 2).mean())
    assert error[64] < 0.5 * error[1] / 8


def test_noise_of_neighboring_pixels_is_uncorrelated():
    renderer = renderer_of(
        scenes.scene_of(
            [(scenes.square(), scenes.moved(scale=100), 0)],
            lights=[scenes.sphere_light(100.0, (0, 0, 5), 3.0, visible=0)],
        )
    )
    view = scenes.view_from((0, 0, 50), up=(0, 1, 0), size=(64, 64), focal_length=5000.0)
    noise = film_of(renderer, 1, view=view, **EXACT).radiance()[..., 0]
    noise = noise - noise.mean()
    for shift in ((0, 1), (1, 0), (1, 1), (0, 2)):
        correlation = (noise * np.roll(noise, shift, (0, 1))).mean() / noise.var()
        # 4096 independent pixels: three standard deviations are 0.05.
        assert abs(correlation) < 0.06


def test_exposure_is_photographic():
    assert ToneSettings().white == pytest.approx(1500)
    # EV100 of f/5 at 1/50 s and ISO 100 is log2(25 * 50); the sensor saturates at 1.2 * 2^EV nits.
    assert ToneSettings().exposure == pytest.approx(1 / 1500)
    assert ToneSettings(film_iso=200).exposure == pytest.approx(2 / 1500)
    assert ToneSettings(f_number=10).exposure == pytest.approx(0.25 / 1500)
    assert ToneSettings(exposure_compensation=1.0).exposure == pytest.approx(2 / 1500)


def test_tone_mapping_of_a_uniform_sky():
    for nits in (1.0, 10.0, 300.0, 1500.0, 40000.0):
        renderer = renderer_of(scenes.scene_of([], dome=scenes.white_dome(nits)))
        film = film_of(renderer, 2)
        x = nits / 1500
        curve = np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0, 1)
        for tone, shown in ((ToneSettings(), curve), (ToneSettings(enabled=False), min(x, 1.0))):
            out = renderer.develop(film, tone)
            encoded = 12.92 * shown if shown <= 0.0031308 else 1.055 * shown ** (1 / 2.4) - 0.055
            assert out["LdrColor"].shape == (30, 40, 4)
            assert out["LdrColor"].dtype == np.uint8
            np.testing.assert_allclose(out["LdrColor"][..., :3], encoded * 255, atol=1.0)
            assert (out["LdrColor"][..., 3] == 255).all()
            assert out["HdrColor"].dtype == np.float16
            np.testing.assert_allclose(out["HdrColor"][..., :3], nits, rtol=3e-3)


def test_sub_frames_give_motion_blur():
    scene = scenes.scene_of(
        [(scenes.cube(), scenes.moved(), 0)], materials=[scenes.material(emission=1.0, base_color=0)]
    )
    renderer = renderer_of(scene)
    view = scenes.view_from((0, -10, 0), size=(32, 8))
    film = renderer.new_film(32, 8)
    for k in range(4):
        scene.instances.local_to_world[0, 3, 0] = k * 0.5
        scene.touch("transforms")
        renderer.sync()
        renderer.accumulate(film, view, samples=16, settings=PathSettings(first_sample=16 * k))
    row = film.radiance()[4, :, 0]
    steps = np.unique(np.round(row[(row > 0.1) & (row < 0.99)], 1))
    assert len(steps) >= 2  # partly covered on the way
    assert row.max() == pytest.approx(1.0)


def test_a_thin_lens_blurs_by_its_circle_of_confusion():
    # A small bright ball 20 away, focus at 5: its blur in the image has the diameter f_px * a * |1/5 - 1/20|.
    light = scenes.sphere_light(100.0, (0, 20, 0), 0.02)
    scene = scenes.scene_of([], lights=[light])
    lens = dict(focal_length=50.0, horizontal_aperture=20.0, size=(129, 129), focus_distance=5.0)
    sharp = radiance(scene, scenes.view_from((0, 0, 0), (0, 1, 0), **lens), samples=256)[..., 0] > 0
    open_view = scenes.view_from((0, 0, 0), (0, 1, 0), f_stop=5.0, **lens)
    blurred = radiance(scene, open_view, samples=1024)[..., 0] > 0
    aperture = 0.1 * 50.0 / 5.0
    expected = open_view.fx * aperture * abs(1 / 5 - 1 / 20)
    assert np.ptp(np.nonzero(sharp.any(0))[0]) <= 2
    assert np.ptp(np.nonzero(blurred.any(0))[0]) == pytest.approx(expected, rel=0.1)
    assert np.ptp(np.nonzero(blurred.any(1))[0]) == pytest.approx(expected, rel=0.1)
    in_focus = scenes.view_from((0, 0, 0), (0, 1, 0), f_stop=5.0, **{**lens, "focus_distance": 20.0})
    assert np.ptp(np.nonzero((radiance(scene, in_focus, samples=256)[..., 0] > 0).any(0))[0]) <= 2


def finished(renderer, film):
    """The image of a film, after a GPU has counted the samples that were dropped."""
    image = renderer.develop(film)["HdrColor"].astype(float)
    renderer.finish()
    return image


def test_samples_that_are_not_finite_are_dropped_and_counted():
    broken = scenes.material(emission=(np.inf, 1.0, 1.0))
    scene = scenes.scene_of([(scenes.cube(), scenes.moved(), 0)], materials=[broken], dome=scenes.white_dome())
    renderer = renderer_of(scene)
    view = scenes.view_from((0, -6, 0), size=(16, 12))
    film = film_of(renderer, 8, view=view)
    assert film.dropped > 0
    assert np.isfinite(film.radiance()).all()
    with pytest.warns(UsdsdgWarning, match="not finite"):
        image = finished(renderer, film)
    assert np.isfinite(image).all()


def test_a_scene_without_light_is_black_and_warns():
    scene = scenes.scene_of([(scenes.cube(), scenes.moved(), 0)])
    renderer = renderer_of(scene)
    with pytest.warns(UsdsdgWarning, match="no light"):
        film = film_of(renderer, 2)
    assert (film.radiance() == 0).all()


def test_cameras_inside_of_geometry_and_images_of_one_pixel_work():
    scene = scenes.scene_of([(scenes.cube(), scenes.moved(), 0)], dome=scenes.white_dome())
    picture = radiance(scene, scenes.view_from((0.2, 0.1, 0), (1, 0, 0), size=(1, 1)), samples=4)
    assert picture.shape == (1, 1, 3)
    assert (picture == 0).all()  # a closed box keeps the sky out


def test_films_of_another_size_are_refused():
    renderer = renderer_of(lit_scene())
    with pytest.raises(RenderError, match="film"):
        renderer.accumulate(renderer.new_film(3, 3), VIEW, samples=1, settings=PathSettings())
