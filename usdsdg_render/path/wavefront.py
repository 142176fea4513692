"""Host side of the wavefront path tracer (CUDA): launches its kernels and owns the memory of the paths in flight."""

from typing import Any

import warp as wp

from usdsdg_render.kernels.labels.views import Views
from usdsdg_render.kernels.path import wavefront
from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.kernels.path.path_memory import FEATURE_WORDS, HIT_WORDS, PATH_WORDS, SHADOW_RAY_WORDS
from usdsdg_render.kernels.path.path_state import LightAovs, PathOptions
from usdsdg_render.scene.structs import SceneTables

# Paths in flight: enough to fill a large GPU, at about 200 bytes each.
MAX_ACTIVE_PATHS = 1 << 21


class WavefrontTracer:
    """Traces paths on one device in chunks; memory is kept between calls."""

    def __init__(self, device: str, paths: int = MAX_ACTIVE_PATHS) -> None:
        self.device = device
        self._max_paths = paths
        self._wavefront = wavefront.Wavefront()
        self._size = 0

    def add_samples(self, tables: SceneTables, options: PathOptions, views: Views, films: Any, samples: int) -> None:
        """Add samples to the film of each view, numbered from `options.first_sample`.

        films: the arrays of each, as a list or as a table on the device.
        """
        pixels = len(films) * views.width * views.height
        table = films if isinstance(films, wp.array) else wp.array(films, dtype=FilmArrays, device=self.device)
        first = options.first_sample
        for first_pixel in range(0, pixels, self._max_paths):
            count = min(self._max_paths, pixels - first_pixel)
            samples_at_once = min(samples, max(1, self._max_paths // count))
            for done in range(0, samples, samples_at_once):
                options.first_sample = first + done
                self._trace(tables, options, views, table, first_pixel, count, min(samples_at_once, samples - done))
        options.first_sample = first

    def _trace(
        self,
        tables: SceneTables,
        options: PathOptions,
        views: Views,
        films: wp.array,
        first_pixel: int,
        pixels: int,
        samples: int,
    ) -> None:
        segments = options.bounces + options.glass_bounces + 1
        state, size = self._wavefront, pixels * samples
        self._allocate(size, options, segments)
        state.first_pixel, state.pixels, state.samples = first_pixel, pixels, samples
        state.counts.zero_()
        self._launch(wavefront.generate_camera_rays, size, options, views, state)
        for segment in range(segments):
            self._launch(wavefront.intersect_closest, size, tables, options, views, state, segment)
            self._launch(wavefront.shade, size, tables, options, views, state, segment)
            self._launch(wavefront.intersect_shadow, size, tables, options, views, state, segment)
        self._launch(wavefront.update_film, pixels, options, views, state, films)

    def _launch(self, kernel: Any, size: int, *inputs: Any) -> None:
        wp.launch(kernel, dim=size, inputs=inputs, device=self.device, block_dim=wavefront.BLOCK)

    def _allocate(self, size: int, options: PathOptions, segments: int) -> None:
        """Allocate memory for that many paths, with features and light AOVs if the film has them."""

        def empty(dtype: Any, shape: Any = size) -> wp.array:
            return wp.empty(shape, dtype=dtype, device=self.device)

        def planes(words: int) -> wp.array:
            return empty(wp.vec4, (words, self._size))

        state = self._wavefront
        if size > self._size:
            self._size = size
            state.paths, state.hits, state.shadow_rays = planes(PATH_WORDS), planes(HIT_WORDS), planes(SHADOW_RAY_WORDS)
            state.ray_queue, state.shadow_queue = empty(wp.int32, (2, size)), empty(wp.int32)
        length = self._size if options.light_aovs else 0
        if _length(state.light_aovs) != length:
            state.light_aovs = empty(LightAovs, length)
        shape = (FEATURE_WORDS, self._size) if options.features else (0, 0)
        if state.features is None or state.features.shape != shape:
            state.features = empty(wp.vec4, shape)
        if _length(state.counts) < 2 * segments + 1:
            state.counts = empty(wp.int32, 2 * segments + 1)


def _length(array: wp.array | None) -> int:
    return -1 if array is None else array.size
