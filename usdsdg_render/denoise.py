"""A film's radiance with its noise smoothed away; edges, textures and mirrored edges stay."""

from __future__ import annotations

from typing import Any

import warp as wp

from usdsdg_render.kernels.denoise import combine, separate, smooth
from usdsdg_render.kernels.path import FilmArrays
from usdsdg_render.parallel import for_bands

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
    inputs = [film.color, film.albedo, film.normal_depth, film.square]
    _over_rows(separate, inputs, [light, guide, surface], device, threads)
    for step in STEPS:
        _over_rows(smooth, [light, guide, step], [other], device, threads)
        light, other = other, light
    _over_rows(combine, [light, surface], [other], device, threads)
    return other


def _over_rows(kernel: Any, inputs: list[Any], outputs: list[wp.array], device: str, threads: int | None) -> None:
    height, width = outputs[0].shape

    def band(first_row: int, rows: int) -> None:
        wp.launch(kernel, dim=(rows, width), inputs=[*inputs, first_row], outputs=outputs, device=device)

    if device == "cpu":
        for_bands(height, band, threads=threads)
    else:
        band(0, height)
