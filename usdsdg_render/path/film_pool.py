"""FilmPool: films whose memory is used again once nothing refers to them."""

from __future__ import annotations

from collections import deque

from usdsdg_render.path.film import Film
from usdsdg_render.path.film_batch import FilmBatch

# Pixels of a batch at most: its buffers take about 140 bytes each.
BATCH_PIXELS = 1 << 22
# Memory of batches that wait for the next images of their size.
KEPT_BYTES = 1 << 29


class FilmPool:
    """Films of one device.

    Allocating and describing the arrays of a film to Warp takes longer than a GPU takes to trace a small image.
    """

    def __init__(self, device: str) -> None:
        self._device = device
        self._free: deque[FilmBatch] = deque()

    def films(self, count: int, width: int, height: int) -> list[Film]:
        """Return empty films of one size, in few batches."""
        at_once = max(1, BATCH_PIXELS // max(1, width * height))
        films: list[Film] = []
        for first in range(0, count, at_once):
            batch = self._batch(min(at_once, count - first), width, height)
            lease = _Lease(self, batch)
            films += [Film(batch, image, lease) for image in range(batch.images)]
        return films

    def release(self, batch: FilmBatch) -> None:
        """Keep a batch, whose films are gone, for later images; any thread may call this."""
        self._free.append(batch)
        while len(self._free) > 1 and sum(each.bytes for each in tuple(self._free)) > KEPT_BYTES:
            self._free.popleft()

    def _batch(self, images: int, width: int, height: int) -> FilmBatch:
        for batch in tuple(self._free):
            if (batch.images, batch.width, batch.height) == (images, width, height):
                try:
                    self._free.remove(batch)
                except ValueError:  # another thread was faster
                    continue
                batch.clear()
                return batch
        return FilmBatch(images, width, height, self._device)


class _Lease:
    """Returns a batch to its pool when the last of its films is deleted."""

    def __init__(self, pool: FilmPool, batch: FilmBatch) -> None:
        self._pool, self._batch = pool, batch

    def __del__(self) -> None:
        self._pool.release(self._batch)
