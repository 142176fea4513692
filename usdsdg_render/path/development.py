"""Development of films: denoising and tone mapping."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import warp as wp

from usdsdg.errors import RenderError
from usdsdg.parallel import cheap_rows, launch_rows
from usdsdg.readback import read_back
from usdsdg_render.kernels.path.tone_map import tone_map_pixels
from usdsdg_render.kernels.path.wavelet_denoiser import blend
from usdsdg_render.path import oidn_denoiser
from usdsdg_render.path.film import Film
from usdsdg_render.path.film_batch import FilmBatch
from usdsdg_render.settings import ToneSettings

DENOISERS = ("wavelet", "oidn")


def develop(
    films: Sequence[Film], tone: ToneSettings, *, threads: int | None = None, fetched: bool = True
) -> list[dict[str, Any]]:
    """Denoise and tone-map films, those of one batch together; see `WarpRenderer.develop`."""
    batches = {id(film.batch): film.batch for film in films}
    developed = {key: developed_batch(batch, tone, threads) for key, batch in batches.items()}
    images = []
    for film in films:
        image: dict[str, Any] = {name: array[film.image] for name, array in developed[id(film.batch)].items()}
        images.append({**(read_back(image) if fetched or film.device == "cpu" else image), **film.light_aovs()})
    return images


def developed_batch(batch: FilmBatch, tone: ToneSettings, threads: int | None) -> dict[str, wp.array]:
    """Return HdrColor (images, height, width) vec4h and LdrColor vec4ub of a batch, on its device."""
    sums = batch.arrays.color
    radiance = sums
    if batch.has_features and tone.denoise is not False:
        radiance = _denoised(batch, tone, threads)
    hdr = wp.empty(sums.shape, dtype=wp.vec4h, device=batch.device)
    ldr = wp.empty(sums.shape, dtype=wp.vec4ub, device=batch.device)
    inputs = [radiance, sums, tone.exposure, int(tone.enabled)]
    _launch(tone_map_pixels, sums.shape, inputs, [hdr, ldr], batch.device, threads)
    shape = (batch.images, batch.height, batch.width)
    return {"HdrColor": hdr.reshape(shape), "LdrColor": ldr.reshape(shape)}


def _denoised(batch: FilmBatch, tone: ToneSettings, threads: int | None) -> wp.array:
    """Return radiance [nits] of the images of a batch, one below the other; it changes at the next call."""
    if tone.denoiser not in DENOISERS:
        raise RenderError(f"denoiser is {tone.denoiser!r}; it may be {' or '.join(map(repr, DENOISERS))}.")
    if tone.denoiser == "wavelet":
        denoised = batch.denoiser.denoise(threads=threads)
    else:
        denoised = _stacked([oidn_denoiser.denoise(each, batch.device, threads=threads) for each in batch.image_arrays])
    if tone.denoiser_blend == 0.0:
        return denoised
    blended = wp.empty_like(denoised)
    inputs = [batch.arrays.color, denoised, tone.denoiser_blend]
    _launch(blend, denoised.shape, inputs, [blended], batch.device, threads)
    return blended


def _stacked(images: Sequence[wp.array]) -> wp.array:
    """Return images of one size, one below the other."""
    if len(images) == 1:
        return images[0]
    height, width = images[0].shape
    whole: Any = wp.empty((len(images) * height, width), dtype=images[0].dtype, device=images[0].device)
    for index, image in enumerate(images):
        wp.copy(whole[index * height : (index + 1) * height], image)
    return whole


def _launch(
    kernel: Any, shape: tuple[int, ...], inputs: list[Any], outputs: list[wp.array], device: str, threads: int | None
) -> None:
    launch_rows(kernel, shape, inputs, outputs, device=device, threads=threads, band_rows=cheap_rows(shape[1]))
