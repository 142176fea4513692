"""Host side of the wavefront path tracer (CUDA): launches its kernels and owns the memory of the paths in flight."""

from typing import Any

import warp as wp

from usdsdg_render.kernels.labels.views import Views
from usdsdg_render.kernels.path import wavefront
from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.kernels.path.path_memory import FEATURE_WORDS, HIT_WORDS, PATH_WORDS, SHADOW_RAY_WORDS
from usdsdg_render.kernels.path.path_state import LightAovs, PathOptions
from usdsdg_render.scene.structs import SceneTables

# Paths in flight, at about 200 bytes each. The fewest fill a large GPU; more of them save launches, each of which takes
# Python longer than the GPU takes for its part of a small image, and may take this share of the device's memory.
FEWEST_PATHS, MOST_PATHS = 1 << 21, 1 << 24
BYTES_PER_PATH, MEMORY_SHARE = 200, 1 / 24
# Index of the argument of the kernels of a segment that is its number.
SEGMENT = 4


class WavefrontTracer:
    """Traces paths on one device in chunks; memory is kept between calls."""

    def __init__(self, device: str, paths: int | None = None) -> None:
        """`paths`: most of them in flight; None: as many as suit the memory of the device."""
        self.device = device
        self._max_paths = paths or _paths_for(wp.get_device(device))
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
        bounce = [
            self._recorded(kernel, size, tables, options, views, state, 0)
            for kernel in (
                wavefront.intersect_closest,
                wavefront.shade_misses,
                wavefront.shade,
                wavefront.intersect_shadow,
            )
        ]
        for segment in range(segments):
            for launch in bounce:
                launch.set_param_at_index(SEGMENT, segment)
                launch.launch()
        self._launch(wavefront.update_film, pixels, options, views, state, films)

    def _launch(self, kernel: Any, size: int, *inputs: Any) -> None:
        wp.launch(kernel, dim=size, inputs=inputs, device=self.device, block_dim=wavefront.BLOCK)

    def _recorded(self, kernel: Any, size: int, *inputs: Any) -> Any:
        """Return a launch that has not been made, whose arguments are converted once for all segments of paths."""
        return wp.launch(
            kernel, dim=size, inputs=inputs, device=self.device, block_dim=wavefront.BLOCK, record_cmd=True
        )

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
            state.ray_queue = empty(wp.int32, (2, size))
            state.hit_queue, state.shadow_queue = empty(wp.int32), empty(wp.int32)
        length = self._size if options.light_aovs else 0
        if _length(state.light_aovs) != length:
            state.light_aovs = empty(LightAovs, length)
        shape = (FEATURE_WORDS, self._size) if options.features else (0, 0)
        if state.features is None or state.features.shape != shape:
            state.features = empty(wp.vec4, shape)
        if _length(state.counts) < wavefront.COUNTS * (segments + 1):
            state.counts = empty(wp.int32, wavefront.COUNTS * (segments + 1))


def _paths_for(device: wp.Device) -> int:
    """Return how many paths are in flight at most on a device."""
    affordable = int(MEMORY_SHARE * device.total_memory / BYTES_PER_PATH) if device.is_cuda else 0
    return min(max(affordable, FEWEST_PATHS), MOST_PATHS)


def _length(array: wp.array | None) -> int:
    return -1 if array is None else array.size
