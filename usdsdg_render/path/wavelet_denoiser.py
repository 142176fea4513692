"""Edge-avoiding wavelet denoiser: smooths noise, keeps edges, textures and edges in mirrors."""

from typing import Any

import warp as wp

from usdsdg.parallel import CUDA_BLOCK, cheap_rows, launch_rows
from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.kernels.path.wavelet_denoiser import atrous_pass, demodulate, remodulate

# Tap distances of the passes [pixels]; the combined filter radius is 62 pixels.
STEPS = (1, 2, 4, 8, 16)
# Rows of taps on either side.
REACH = 2


class WaveletDenoiser:
    """Denoises images whose sums are always in the same arrays.

    Its buffers and, on CUDA, its launches are made once: describing them to Warp takes longer than a GPU takes to run
    them on a small image.
    """

    def __init__(self, film: FilmArrays, device: str, *, images: int = 1) -> None:
        """
        Args:
            film: sums with feature buffers.
            images: how many images of one size the film holds, one below the other.
        """
        self._film: Any = film
        self._device, self._images = device, images
        shape = self._film.color.shape
        self._ping, self._pong, self._guide = (wp.empty(shape, dtype=wp.vec4, device=device) for _ in range(3))
        self._albedo = wp.empty(shape, dtype=wp.vec3, device=device)
        self._recorded: list[Any] = []

    @property
    def bytes(self) -> int:
        """Memory of the device that the buffers take."""
        return sum(array.capacity for array in (self._ping, self._pong, self._guide, self._albedo))

    def denoise(self, *, threads: int | None = None) -> wp.array:
        """Denoise the mean radiance.

        Returns:
            (rows, width) vec4: radiance [nits], and 1 as the number of samples. The next call changes it.
        """
        launches, denoised = self._launches()
        if self._device == "cpu":
            shape = self._film.color.shape
            for kernel, inputs, outputs in launches:
                rows = cheap_rows(shape[1])
                launch_rows(kernel, shape, inputs, outputs, device="cpu", threads=threads, band_rows=rows)
            return denoised
        if not self._recorded:
            self._recorded = [self._record(*launch) for launch in launches]
        for launch in self._recorded:
            launch.launch()
        return denoised

    def _launches(self) -> tuple[list[tuple[Any, list[Any], list[wp.array]]], wp.array]:
        """Return kernels with their inputs and outputs, and the array with the result."""
        film, ping, pong = self._film, self._ping, self._pong
        height = film.color.shape[0] // self._images
        sums = [film.color, film.background, film.albedo, film.normal_depth, film.square]
        launches = [(demodulate, sums, [ping, self._guide, self._albedo])]
        for step in STEPS:
            launches.append((atrous_pass, [ping, self._guide, step, REACH, height], [pong]))
            ping, pong = pong, ping
        launches.append((remodulate, [ping, self._albedo, film.color, film.background], [pong]))
        return launches, pong

    def _record(self, kernel: Any, inputs: list[Any], outputs: list[wp.array]) -> Any:
        first_row = 0
        shape, device = self._film.color.shape, self._device
        return wp.launch(
            kernel, shape, [*inputs, first_row], outputs, device=device, block_dim=CUDA_BLOCK, record_cmd=True
        )
