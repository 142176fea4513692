"""Film: running sums of radiance per pixel, and their denoising and tone mapping."""

from typing import Any

import numpy as np
import warp as wp

from usdsdg.errors import RenderError
from usdsdg.parallel import cheap_rows, launch_rows
from usdsdg.readback import read_back
from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.kernels.path.tone_map import tone_map_pixels
from usdsdg_render.kernels.path.wavelet_denoiser import blend
from usdsdg_render.path import oidn_denoiser, wavelet_denoiser
from usdsdg_render.settings import LIGHT_AOVS, ToneSettings

_DENOISERS = {"wavelet": wavelet_denoiser.denoise, "oidn": oidn_denoiser.denoise}


class Film:
    """Running sums of one image; `WarpRenderer.accumulate` adds samples, once for each motion-blur sub-frame."""

    def __init__(self, width: int, height: int, device: str) -> None:
        self.width, self.height, self.device = width, height, device
        self.samples = 0  # per pixel, requested so far; a pixel may hold fewer (see `dropped`)
        self.arrays = FilmArrays()
        self.arrays.color = self._zeros(wp.vec4)
        self.arrays.dropped = self._zeros(wp.int32)
        self.has_features = False
        self.has_light_aovs = False

    def _zeros(self, dtype) -> wp.array:
        return wp.zeros((self.height, self.width), dtype=dtype, device=self.device)

    def allocate_features(self) -> None:
        """Allocate the feature buffers of the denoisers; call before the first sample."""
        if not self.has_features:
            self.arrays.background = self._zeros(wp.vec4)
            self.arrays.albedo = self._zeros(wp.vec3)
            self.arrays.normal_depth = self._zeros(wp.vec4)
            self.arrays.square = self._zeros(wp.float32)
            self.has_features = True

    def allocate_light_aovs(self) -> None:
        """Allocate the sums of the light AOVs; call before the first sample."""
        if not self.has_light_aovs:
            shape = (len(LIGHT_AOVS), self.height, self.width)
            self.arrays.light_aovs = wp.zeros(shape, dtype=wp.vec3, device=self.device)
            self.has_light_aovs = True

    def light_aovs(self) -> dict[str, np.ndarray]:
        """Mean radiance per light AOV, (height, width, 3) float32 [nits] each; empty unless allocated."""
        if not self.has_light_aovs:
            return {}
        samples = np.maximum(self.arrays.color.numpy()[..., 3:], 1.0)
        return dict(zip(LIGHT_AOVS, self.arrays.light_aovs.numpy() / samples, strict=True))

    @property
    def dropped(self) -> int:
        """Number of samples that were rejected because they were not finite."""
        return int(self.arrays.dropped.numpy().sum())

    def radiance(self) -> np.ndarray:
        """Mean radiance, (height, width, 3) float32 [nits]; black where there is no sample."""
        color = self.arrays.color.numpy()
        return color[..., :3] / np.maximum(color[..., 3:], 1.0)


def tone_map(film: Film, tone: ToneSettings, *, threads: int | None = None, fetched: bool = True) -> dict[str, Any]:
    """Denoise and tone-map a film; see `WarpRenderer.develop`."""
    radiance = film.arrays.color
    if film.has_features and tone.denoise is not False:
        radiance = _denoised(film, tone, threads)
    images = tone_mapped(radiance, film.arrays.color, tone, threads)
    return {**(read_back(images) if fetched or film.device == "cpu" else images), **film.light_aovs()}


def tone_mapped(radiance: wp.array, sums: wp.array, tone: ToneSettings, threads: int | None) -> dict[str, wp.array]:
    """Return HdrColor and LdrColor of radiance, and of the sums that it was denoised from."""
    device = str(radiance.device)
    hdr = wp.empty(radiance.shape, dtype=wp.vec4h, device=device)
    ldr = wp.empty(radiance.shape, dtype=wp.vec4ub, device=device)
    inputs, rows = [radiance, sums, tone.exposure, int(tone.enabled)], cheap_rows(radiance.shape[1])
    launch_rows(tone_map_pixels, radiance.shape, inputs, [hdr, ldr], device=device, threads=threads, band_rows=rows)
    return {"HdrColor": hdr, "LdrColor": ldr}


def _denoised(film: Film, tone: ToneSettings, threads: int | None) -> wp.array:
    if tone.denoiser not in _DENOISERS:
        raise RenderError(f"denoiser is {tone.denoiser!r}; it may be {' or '.join(map(repr, _DENOISERS))}.")
    denoised = _DENOISERS[tone.denoiser](film.arrays, film.device, threads=threads)
    if tone.denoiser_blend == 0.0:
        return denoised
    blended = wp.empty_like(denoised)
    inputs = [film.arrays.color, denoised, tone.denoiser_blend]
    rows = cheap_rows(film.width)
    launch_rows(blend, denoised.shape, inputs, [blended], device=film.device, threads=threads, band_rows=rows)
    return blended
