"""Films made by hand, for tests of the denoisers."""

import numpy as np
import pytest
import warp as wp

from usdsdg_render.path import oidn_denoiser
from usdsdg_render.path.development import develop
from usdsdg_render.path.film import Film
from usdsdg_render.path.film_batch import FilmBatch
from usdsdg_render.path.wavelet_denoiser import WaveletDenoiser

SAMPLES = 8

needs_library = pytest.mark.skipif(
    not oidn_denoiser.is_installed() or oidn_denoiser.lacks_sve(),
    reason="Open Image Denoise is an extra, for SVE on aarch64",
)


def film_of(light, *, albedo=None, normal=(0.0, 0.0, 1.0), depth=2.0, noise=0.3, seed=0, behind=0, sky=0.0):
    """A film of SAMPLES noisy samples of `light` (H, W, 3) on surfaces of `albedo`.

    `behind` samples of each pixel, (H, W) or one number, show the `sky` instead.
    """
    shape = light.shape[:2]
    albedo = np.broadcast_to(np.ones(3) if albedo is None else albedo, light.shape)
    factors = np.random.default_rng(seed).gamma(1 / noise**2, noise**2, (SAMPLES, *shape, 1))
    hit = np.arange(SAMPLES)[:, None, None, None] >= np.broadcast_to(behind, shape)[..., None]
    samples = light * factors * hit
    hits = hit.sum(0)
    film = Film(FilmBatch(1, shape[1], shape[0], "cpu"))
    film.allocate_features()
    background = np.concatenate([(SAMPLES - hits) * np.broadcast_to(sky, light.shape), SAMPLES - hits], -1)
    color = background + np.concatenate([(samples * albedo).sum(0), hits], -1)
    brightness = samples @ np.array([0.2126, 0.7152, 0.0722])
    normal_depth = np.concatenate([np.broadcast_to(normal, light.shape), np.broadcast_to(depth, shape)[..., None]], -1)
    film.arrays.color = wp.array(color, dtype=wp.vec4, device="cpu")
    film.arrays.background = wp.array(background, dtype=wp.vec4, device="cpu")
    film.arrays.albedo = wp.array(albedo * hits, dtype=wp.vec3, device="cpu")
    film.arrays.normal_depth = wp.array(normal_depth * hits, dtype=wp.vec4, device="cpu")
    film.arrays.square = wp.array((brightness**2).sum(0), dtype=wp.float32, device="cpu")
    return film


def rms(image, truth):
    """Root mean square of the difference."""
    return np.sqrt(((image - truth) ** 2).mean())


def developed(film, tone):
    """The denoised and tone-mapped images of one film."""
    return develop([film], tone)[0]


def denoise(arrays, device, **options):
    """The radiance that the wavelet filter makes of the sums of one film."""
    return WaveletDenoiser(arrays, device).denoise(**options)
