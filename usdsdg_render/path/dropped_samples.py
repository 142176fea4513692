"""Warns of samples that were not finite, without waiting for the device."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import warp as wp

from usdsdg.errors import counted, warn_once
from usdsdg.parallel import CUDA_BLOCK
from usdsdg.readback import Arrival, start_to_read_back
from usdsdg_render.kernels.path.tone_map import sum_dropped

if TYPE_CHECKING:
    from usdsdg_render.path.film import Film
    from usdsdg_render.path.film_batch import FilmBatch

# Films whose counts may be under way; then the oldest one is waited for.
AHEAD = 8


class DroppedSamples:
    """Warns of samples of one renderer's images that were not finite; on CUDA once the device has counted them."""

    def __init__(self) -> None:
        self._under_way: deque[tuple[Arrival, int, int]] = deque()  # with the width and height of the film

    def look_at(self, film: Film | FilmBatch) -> None:
        """Warn if samples of one image or of a batch of images were dropped.

        On a CPU that is at once, on CUDA after the device has counted them.
        """
        if film.device == "cpu":
            _warn(int(film.arrays.dropped.numpy().sum()), film.width, film.height)
            return
        total = wp.zeros(1, dtype=wp.int32, device=film.device)
        dropped = film.arrays.dropped
        wp.launch(
            sum_dropped, dim=dropped.shape, inputs=[dropped], outputs=[total], device=film.device, block_dim=CUDA_BLOCK
        )
        self._under_way.append((start_to_read_back({"total": total}), film.width, film.height))
        self.report(but=AHEAD)

    def report(self, *, but: int = 0) -> None:
        """Warn of what the device has counted, waiting for all films but the last ones."""
        while len(self._under_way) > but:
            arrival, width, height = self._under_way.popleft()
            arrival.wait()
            _warn(int(arrival.copies["total"][0]), width, height)


def _warn(count: int, width: int, height: int) -> None:
    if count:
        image = f"of a {width}x{height} image"
        dropped = counted(
            count, f"sample {image} was not finite and was dropped", f"samples {image} were not finite and were dropped"
        )
        warn_once(dropped, key="dropped samples")
