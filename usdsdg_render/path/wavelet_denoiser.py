"""Edge-avoiding wavelet denoiser: smooths noise, keeps edges, textures and edges in mirrors."""

import warp as wp

from usdsdg.parallel import launch_rows
from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.kernels.path.wavelet_denoiser import atrous_pass, demodulate, remodulate

# Tap distances of the passes [pixels]; the combined filter radius is 62 pixels.
STEPS = (1, 2, 4, 8, 16)


def denoise(film: FilmArrays, device: str, *, threads: int | None = None) -> wp.array:
    """Denoise the film's mean radiance.

    Args:
        film: sums with feature buffers.

    Returns:
        (height, width) vec4: radiance [nits], and 1 as the number of samples.
    """
    shape = film.color.shape
    irradiance, buffer, guide = (wp.empty(shape, dtype=wp.vec4, device=device) for _ in range(3))
    albedo = wp.empty(shape, dtype=wp.vec3, device=device)
    inputs = [film.color, film.background, film.albedo, film.normal_depth, film.square]
    launch_rows(demodulate, shape, inputs, [irradiance, guide, albedo], device=device, threads=threads)
    for step in STEPS:
        launch_rows(atrous_pass, shape, [irradiance, guide, step], [buffer], device=device, threads=threads)
        irradiance, buffer = buffer, irradiance
    inputs = [irradiance, albedo, film.color, film.background]
    launch_rows(remodulate, shape, inputs, [buffer], device=device, threads=threads)
    return buffer
