"""Edge-avoiding wavelet denoiser: smooths noise, keeps edges, textures and edges in mirrors."""

from typing import Any

import warp as wp

from usdsdg.parallel import cheap_rows, launch_rows
from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.kernels.path.wavelet_denoiser import atrous_pass, demodulate, remodulate

# Tap distances of the passes [pixels]; the combined filter radius is 62 pixels.
STEPS = (1, 2, 4, 8, 16)


def denoise(film: FilmArrays, device: str, *, images: int = 1, threads: int | None = None) -> wp.array:
    """Denoise the film's mean radiance.

    Args:
        film: sums with feature buffers.
        images: how many images of one size the film holds, one below the other.

    Returns:
        (rows, width) vec4: radiance [nits], and 1 as the number of samples.
    """
    shape = film.color.shape
    irradiance, buffer, guide = (wp.empty(shape, dtype=wp.vec4, device=device) for _ in range(3))
    albedo = wp.empty(shape, dtype=wp.vec3, device=device)

    def launch(kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        rows = cheap_rows(shape[1])
        launch_rows(kernel, shape, inputs, outputs, device=device, threads=threads, band_rows=rows)

    inputs = [film.color, film.background, film.albedo, film.normal_depth, film.square]
    launch(demodulate, inputs, [irradiance, guide, albedo])
    for step in STEPS:
        launch(atrous_pass, [irradiance, guide, step, shape[0] // images], [buffer])
        irradiance, buffer = buffer, irradiance
    launch(remodulate, [irradiance, albedo, film.color, film.background], [buffer])
    return buffer
