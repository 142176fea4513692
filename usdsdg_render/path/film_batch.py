"""Films of many images of one size, in one piece of memory."""

from typing import Any

import warp as wp

from usdsdg.errors import Unsupported
from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.path import wavelet_denoiser
from usdsdg_render.path.film import tone_mapped
from usdsdg_render.settings import ToneSettings

_FEATURES = {"background": wp.vec4, "albedo": wp.vec3, "normal_depth": wp.vec4, "square": wp.float32}


class FilmBatch:
    """Running sums of `images` images, one below the other.

    Attributes:
        has_features, has_light_aovs: whether there are the buffers of the denoiser, and those of light AOVs.
        table: (images,) `FilmArrays`, one for each image.
    """

    def __init__(self, images: int, width: int, height: int, device: str, *, features: bool) -> None:
        """features: with the buffers that the denoiser needs."""
        self.images, self.width, self.height, self.has_features = images, width, height, features
        self.device, self.has_light_aovs = device, False
        types: dict[str, Any] = {"color": wp.vec4, **(_FEATURES if features else {})}
        shape = (images * height, width)
        self.arrays: Any = FilmArrays()
        self._sums = [wp.zeros(shape, dtype=dtype, device=device) for dtype in types.values()]
        for name, array in zip(types, self._sums, strict=True):
            setattr(self.arrays, name, array)
        self.arrays.dropped = wp.zeros(shape, dtype=wp.int32, device=device)
        films = []
        for image in range(images):
            film: Any = FilmArrays()
            for name in (*types, "dropped"):
                setattr(film, name, getattr(self.arrays, name)[image * height : (image + 1) * height])
            films.append(film)
        self.table = wp.array(films, dtype=FilmArrays, device=device)

    def clear(self) -> None:
        """Begin new images."""
        for array in (*self._sums, self.arrays.dropped):
            array.zero_()

    def develop(self, tone: ToneSettings, *, threads: int | None) -> dict[str, wp.array]:
        """Denoise and tone-map; return HdrColor (images, height, width) vec4h and LdrColor vec4ub on the device.

        Raises:
            Unsupported: the denoiser is not the wavelet filter.
        """
        radiance = self.arrays.color
        if self.has_features and tone.denoise is not False:
            if tone.denoiser != "wavelet" or tone.denoiser_blend != 0.0:
                raise Unsupported(
                    f"worlds: the denoiser {tone.denoiser!r}, blend factor {tone.denoiser_blend:g}, cleans one image "
                    "at a time. Set /usdsdg/denoiser to 'wavelet' and blendFactor to 0, or switch denoising off."
                )
            radiance = wavelet_denoiser.denoise(self.arrays, self.device, images=self.images, threads=threads)
        images = tone_mapped(radiance, self.arrays.color, tone, threads)
        shape = (self.images, self.height, self.width)
        return {name: array.reshape(shape) for name, array in images.items()}
