"""Film: running sums of radiance per pixel of one image."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from usdsdg_render.settings import LIGHT_AOVS

if TYPE_CHECKING:
    from usdsdg_render.kernels.path.film import FilmArrays
    from usdsdg_render.path.film_batch import FilmBatch


class Film:
    """Running sums of one image; `WarpRenderer.accumulate` adds samples, once for each motion-blur sub-frame."""

    def __init__(self, batch: FilmBatch, image: int = 0, lease: object = None) -> None:
        """
        Args:
            batch: has the sums of this image and of others of its size.
            image: its number there.
            lease: kept as long as the film.
        """
        self.batch, self.image, self._lease = batch, image, lease
        self.width, self.height, self.device = batch.width, batch.height, batch.device
        self.samples = 0  # per pixel, requested so far; a pixel may hold fewer (see `dropped`)

    @property
    def arrays(self) -> FilmArrays:
        """The sums, (height, width)."""
        return self.batch.image_arrays[self.image]

    @property
    def has_features(self) -> bool:
        """Whether there are the buffers that the denoisers need."""
        return self.batch.has_features

    @property
    def has_light_aovs(self) -> bool:
        """Whether there are the sums of the light AOVs."""
        return self.batch.has_light_aovs

    def allocate_features(self) -> None:
        """Allocate the feature buffers of the denoisers; call before the first sample."""
        self.batch.allocate_features()

    def allocate_light_aovs(self) -> None:
        """Allocate the sums of the light AOVs; call before the first sample."""
        self.batch.allocate_light_aovs()

    def light_aovs(self) -> dict[str, np.ndarray]:
        """Mean radiance per light AOV, (height, width, 3) float32 [nits] each; empty unless allocated."""
        if not self.has_light_aovs:
            return {}
        arrays: Any = self.arrays
        samples = np.maximum(arrays.color.numpy()[..., 3:], 1.0)
        return dict(zip(LIGHT_AOVS, arrays.light_aovs.numpy() / samples, strict=True))

    @property
    def dropped(self) -> int:
        """Number of samples that were rejected because they were not finite."""
        arrays: Any = self.arrays
        return int(arrays.dropped.numpy().sum())

    def radiance(self) -> np.ndarray:
        """Mean radiance, (height, width, 3) float32 [nits]; black where there is no sample."""
        arrays: Any = self.arrays
        color = arrays.color.numpy()
        return color[..., :3] / np.maximum(color[..., 3:], 1.0)
