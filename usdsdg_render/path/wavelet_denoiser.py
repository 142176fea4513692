"""A film's radiance with its noise smoothed away; edges, textures and mirrored edges stay."""

from __future__ import annotations

import warp as wp

from usdsdg_render.device.parallel import launch_rows
from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.kernels.path.wavelet_denoiser import combine, separate, smooth

# Tap distances of the passes: together they reach 62 pixels.
STEPS = (1, 2, 4, 8, 16)


def denoise(film: FilmArrays, device: str, *, threads: int | None = None) -> wp.array:
    """The film's mean radiance, filtered.

    Args:
        film: sums with features.

    Returns:
        (height, width) vec4: radiance [nits], and 1 as the number of samples.
    """
    shape = film.color.shape
    light, other, guide = (wp.empty(shape, dtype=wp.vec4, device=device) for _ in range(3))
    surface = wp.empty(shape, dtype=wp.vec3, device=device)
    inputs = [film.color, film.background, film.albedo, film.normal_depth, film.square]
    launch_rows(separate, shape, inputs, [light, guide, surface], device=device, threads=threads)
    for step in STEPS:
        launch_rows(smooth, shape, [light, guide, step], [other], device=device, threads=threads)
        light, other = other, light
    launch_rows(combine, shape, [light, surface, film.color, film.background], [other], device=device, threads=threads)
    return other
