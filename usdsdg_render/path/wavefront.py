"""The host's side of CUDA's path tracer: pictures, many at once, cut into waves of paths, and their memory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import warp as wp

from usdsdg_render.kernels.labels.views import Views
from usdsdg_render.kernels.path import wavefront
from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.kernels.path.path_state import Connection, Feature, LightAovs, Path, PathOptions
from usdsdg_render.scene.structs import Hit, SceneTables

# Paths in flight: enough to fill a large GPU, in about 200 bytes each.
WAVE_PATHS = 1 << 21
BLOCK = 128


class Waves:
    """Memory for the paths in flight on one device, kept from picture to picture."""

    def __init__(self, device: str, paths: int = WAVE_PATHS) -> None:
        self.device = device
        self._most = paths
        self._wave = wavefront.Wave()
        self._size = 0

    def add_samples(
        self, tables: SceneTables, options: PathOptions, views: Views, films: Sequence[FilmArrays], samples: int
    ) -> None:
        """Add samples to the film of each of the views, numbered from `options.first_sample`."""
        pixels = len(films) * views.width * views.height
        table = wp.array(films, dtype=FilmArrays, device=self.device)
        first = options.first_sample
        for first_pixel in range(0, pixels, self._most):
            count = min(self._most, pixels - first_pixel)
            at_once = min(samples, max(1, self._most // count))
            for done in range(0, samples, at_once):
                options.first_sample = first + done
                self._run(tables, options, views, table, first_pixel, count, min(at_once, samples - done))
        options.first_sample = first

    def _run(
        self,
        tables: SceneTables,
        options: PathOptions,
        views: Views,
        films: wp.array,
        first_pixel: int,
        pixels: int,
        samples: int,
    ) -> None:
        steps = options.bounces + options.glass_bounces + 1
        wave, size = self._wave, pixels * samples
        self._grow(size, options, steps)
        wave.first_pixel, wave.pixels, wave.samples = first_pixel, pixels, samples
        wave.counts.zero_()
        self._launch(wavefront.begin, size, options, views, wave)
        for step in range(steps):
            self._launch(wavefront.trace, size, tables, options, views, wave, step)
            self._launch(wavefront.shade, size, tables, options, views, wave, step)
            self._launch(wavefront.connect, size, tables, wave, step)
        self._launch(wavefront.gather, pixels, options, views, wave, films)

    def _launch(self, kernel: Any, size: int, *inputs: Any) -> None:
        wp.launch(kernel, dim=size, inputs=inputs, device=self.device, block_dim=BLOCK)

    def _grow(self, size: int, options: PathOptions, steps: int) -> None:
        """Have memory for that many paths, with features and light_aovs where the film has them."""

        def make(dtype: Any, shape: Any = size) -> wp.array:
            return wp.empty(shape, dtype=dtype, device=self.device)

        wave = self._wave
        if size > self._size:
            self._size = size
            wave.paths, wave.hits, wave.connections = make(Path), make(Hit), make(Connection)
            wave.rays, wave.shadows = make(wp.int32, (2, size)), make(wp.int32)
        for name, dtype, wanted in (
            ("light_aovs", LightAovs, options.light_aovs),
            ("features", Feature, options.features),
        ):
            rows = self._size if wanted else 0
            if _length(getattr(wave, name)) != rows:
                setattr(wave, name, make(dtype, rows))
        if _length(wave.counts) < 2 * steps + 1:
            wave.counts = make(wp.int32, 2 * steps + 1)


def _length(array: wp.array | None) -> int:
    return -1 if array is None else array.size
