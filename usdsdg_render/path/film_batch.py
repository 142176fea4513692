"""FilmBatch: the films of images of one size, in one piece of memory, so that one launch serves all of them."""

from functools import cached_property
from typing import Any

import warp as wp

from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.path.wavelet_denoiser import WaveletDenoiser
from usdsdg_render.scene.struct_rows import records_of, uploaded
from usdsdg_render.settings import LIGHT_AOVS

_SUMS = {"color": wp.vec4, "dropped": wp.int32}
_FEATURES = {"background": wp.vec4, "albedo": wp.vec3, "normal_depth": wp.vec4, "square": wp.float32}


class FilmBatch:
    """Running sums of `images` images, one below the other.

    Attributes:
        arrays: the sums of all images, (images * height, width).
        image_arrays: those of each image, in the same memory.
        has_features, has_light_aovs: whether there are the buffers of the denoiser, and those of light AOVs.
    """

    def __init__(self, images: int, width: int, height: int, device: str) -> None:
        self.images, self.width, self.height, self.device = images, width, height, device
        self.has_features = self.has_light_aovs = False
        self.arrays: Any = FilmArrays()
        self.image_arrays: list[Any] = [self.arrays] if images == 1 else [FilmArrays() for _ in range(images)]
        self._allocated: dict[str, wp.array] = {}
        self._allocate(_SUMS)

    def allocate_features(self) -> None:
        """Begin the feature buffers of the denoisers; call before the first sample."""
        if not self.has_features:
            self._allocate(_FEATURES)
            self.has_features = True

    def allocate_light_aovs(self) -> None:
        """Begin the sums of the light AOVs; call before the first sample."""
        if not self.has_light_aovs:
            self._allocate({"light_aovs": wp.vec3}, len(LIGHT_AOVS))
            self.has_light_aovs = True

    def clear(self) -> None:
        """Begin new images, without features and light AOVs; their memory stays."""
        self.has_features = self.has_light_aovs = False
        for name in _SUMS:
            self._allocated[name].zero_()

    @cached_property
    def table(self) -> wp.array:
        """(images,) `FilmArrays` on the device, one for each image."""
        return uploaded(records_of(self.image_arrays, FilmArrays), FilmArrays, self.device)

    @cached_property
    def denoiser(self) -> WaveletDenoiser:
        """The wavelet filter of all images; they need features."""
        return WaveletDenoiser(self.arrays, self.device, images=self.images)

    @property
    def bytes(self) -> int:
        """Memory of the device that the sums take, with the buffers of the denoiser."""
        sums = sum(array.capacity for array in self._allocated.values())
        return sums + (self.denoiser.bytes if "denoiser" in vars(self) else 0)

    def _allocate(self, types: dict[str, Any], *leading: int) -> None:
        """Zero arrays by name, and allocate those that are not there."""
        for name, dtype in types.items():
            if name in self._allocated:
                self._allocated[name].zero_()
                continue
            array = wp.zeros((*leading, self.images * self.height, self.width), dtype=dtype, device=self.device)
            self._allocated[name] = array
            setattr(self.arrays, name, array)
            for image, arrays in enumerate(self.image_arrays if self.images > 1 else ()):
                rows = slice(image * self.height, (image + 1) * self.height)
                setattr(arrays, name, array[:, rows] if leading else array[rows])
            vars(self).pop("table", None)
