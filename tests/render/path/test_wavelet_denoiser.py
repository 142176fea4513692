"""The wavelet denoiser on films made by hand: noise is removed; textures, edges and background stay."""

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import DEVICE, renderer_of
from tests.render.path.films import SAMPLES, denoise, developed, film_of, rms
from usdsdg.errors import RenderError
from usdsdg_render.settings import PathSettings, ToneSettings

SIZE = 48


def filtered(film):
    return denoise(film.arrays, "cpu").numpy()[..., :3]


def test_noise_falls_by_more_than_a_factor_of_five():
    truth = np.full((SIZE, SIZE, 3), 100.0)
    film = film_of(truth)
    assert rms(filtered(film), truth) < rms(film.radiance(), truth) / 5


def test_an_image_without_noise_is_not_changed():
    rng = np.random.default_rng(1)
    truth = np.broadcast_to(rng.uniform(10, 200, 3), (SIZE, SIZE, 3)).copy()
    albedo = rng.uniform(0.1, 1.0, (SIZE, SIZE, 3))
    film = film_of(truth, albedo=albedo, noise=1e-3)
    np.testing.assert_allclose(filtered(film), film.radiance(), rtol=5e-3)


def test_textures_keep_their_contrast():
    checks = np.where(np.indices((SIZE, SIZE)).sum(0) % 2, 0.9, 0.1)[..., None] * np.ones(3)
    truth = np.full((SIZE, SIZE, 3), 100.0)
    result = filtered(film_of(truth, albedo=checks))
    assert rms(result, truth * checks) < 4
    np.testing.assert_allclose(result[checks > 0.5].mean() / result[checks < 0.5].mean(), 9, rtol=0.02)


def test_light_does_not_cross_an_edge_between_normals():
    left = (np.arange(SIZE) < SIZE // 2)[None, :, None]
    truth = np.where(left, 10.0, 200.0) * np.ones((SIZE, SIZE, 3))
    normal = np.where(left, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    result = filtered(film_of(truth, normal=normal))
    np.testing.assert_allclose(result[:, : SIZE // 2].mean((0, 2)), 10.0, rtol=0.1)
    np.testing.assert_allclose(result[:, SIZE // 2 :].mean((0, 2)), 200.0, rtol=0.1)


def test_light_does_not_cross_a_step_in_depth():
    left = np.arange(SIZE)[None, :] < SIZE // 2
    truth = np.where(left[..., None], 10.0, 200.0) * np.ones((SIZE, SIZE, 3))
    result = filtered(film_of(truth, depth=np.where(left, 1.0, 4.0)))
    np.testing.assert_allclose(result[:, : SIZE // 2].mean((0, 2)), 10.0, rtol=0.1)


def test_background_is_not_filtered():
    sky = np.random.default_rng(2).uniform(0, 500, (SIZE, SIZE, 3))
    film = film_of(np.ones_like(sky), behind=SAMPLES, sky=sky)
    np.testing.assert_allclose(filtered(film), film.radiance(), rtol=1e-5)
    np.testing.assert_allclose(filtered(film), sky, rtol=1e-5)


@pytest.mark.parametrize("albedo", [0.1, 0.9])
def test_an_edge_against_the_background_blends_both_colors(albedo):
    # Columns in which 0 to 8 samples show the background.
    behind = np.broadcast_to(np.clip(np.arange(SIZE) - SIZE // 2, 0, SAMPLES), (SIZE, SIZE))
    sky, light = np.array([30.0, 40.0, 60.0]), np.array([500.0, 400.0, 300.0])
    film = film_of(
        np.broadcast_to(light, (SIZE, SIZE, 3)), albedo=np.full(3, albedo), behind=behind, sky=sky, noise=0.1
    )
    share = behind[..., None] / SAMPLES
    truth = (1 - share) * light * albedo + share * sky
    np.testing.assert_allclose(filtered(film), truth, rtol=0.05)


def test_edges_before_a_surface_that_shines_are_no_brighter_than_both_sides():
    """A dark picture that shines by itself, as behind the objects of the detection job, is not lit by its albedo."""
    shining, ball = scenes.material(base_color=0.0, specular=0.0, emission=(2.0, 1.5, 0.3)), scenes.material()
    placed = [(scenes.square(), scenes.moved(scale=20), 0), (scenes.sphere(), scenes.moved((0, 0, 3)), 1)]
    scene = scenes.scene_of(placed, materials=[shining, ball], dome=scenes.white_dome(0.3))
    renderer, view = renderer_of(scene), scenes.view_from((0, -3, 12), (0, 0, 2), size=(40, 30))
    films = [renderer.new_film(view.width, view.height) for _ in range(2)]
    for film, samples in zip(films, (8, 128)):
        renderer.accumulate(film, view, samples=samples, settings=PathSettings(denoise=True))
    truth = films[1].radiance()
    assert np.ptp(truth[..., 1]) > 0.5
    # Of eight samples at an edge one or two more or fewer show what shines.
    assert np.abs(denoise(films[0].arrays, DEVICE).numpy()[..., :3] - truth).max() < 0.45
    assert denoise(films[1].arrays, DEVICE).numpy()[..., :3] == pytest.approx(truth, abs=0.1)


@pytest.mark.parametrize("threads", [1, 2])
def test_the_result_does_not_depend_on_threads(threads):
    film = film_of(np.full((SIZE, SIZE, 3), 50.0))
    assert np.array_equal(denoise(film.arrays, "cpu", threads=threads).numpy(), denoise(film.arrays, "cpu").numpy())


def test_tone_mapping_denoises_unless_disabled():
    film = film_of(np.full((SIZE, SIZE, 3), 300.0))
    plain = developed(film, ToneSettings(denoise=False))["LdrColor"].astype(float)
    clean = developed(film, ToneSettings())["LdrColor"].astype(float)
    assert clean[..., :3].std() < plain[..., :3].std() / 3


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_the_noisy_image_is_blended_in(share):
    film = film_of(np.full((SIZE, SIZE, 3), 300.0))
    got = developed(film, ToneSettings(denoiser_blend=share))["HdrColor"][..., :3]
    expected = share * film.radiance() + (1 - share) * filtered(film)
    np.testing.assert_allclose(got, expected, rtol=2**-10)  # half floats have eleven digits


def test_the_error_names_an_unknown_denoiser():
    film = film_of(np.full((4, 4, 3), 300.0))
    with pytest.raises(RenderError, match="'median'; it may be 'wavelet' or 'oidn'"):
        developed(film, ToneSettings(denoiser="median"))
