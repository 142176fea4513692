"""Settings of the path tracer and of tone mapping."""

from __future__ import annotations

import math
from dataclasses import dataclass

# Luminance that the default exposure shows as white [nits]; clamps are multiples of it.
DEFAULT_WHITE = 1500.0
# Light AOVs: radiance split by how the first surface scattered it; see `PathSettings.light_aovs`.
LIGHT_AOVS = ("direct_diffuse", "direct_specular", "indirect_diffuse", "reflections", "refractions")


@dataclass(frozen=True)
class PathSettings:
    """How `WarpRenderer.accumulate` traces paths.

    A sample is a function of (seed, frame, pixel, sample index) alone. An image of 64 samples is the same bit for bit
    in one call or in several that continue the numbering with `first_sample`.
    """

    bounces: int = 3  # maximum path length in surfaces: 1 = direct light only
    glass_bounces: int = 6  # glass interfaces that a path may cross in addition
    seed: int = 0
    frame: int = 0
    first_sample: int = 0
    # Firefly clamp: maximum luminance of one contribution after two or more bounces [nits]; 0 = no clamp.
    clamp: float = 3.0 * DEFAULT_WHITE
    # Path regularization: minimum GGX alpha after a rough bounce. Removes caustics that few samples cannot resolve.
    regularization: float = 0.3
    # Also accumulate the feature buffers (albedo, normal, depth) that the denoisers need.
    denoise: bool = False
    # Also accumulate LIGHT_AOVS. Light that the first surface scatters directly from lights or emissive surfaces is
    # "direct_diffuse" or "direct_specular"; light that it scatters from other surfaces is "indirect_diffuse" or
    # "reflections"; light transmitted through glass is "refractions". The rest of the image is the emission of the
    # first surface, of a light or of the environment.
    light_aovs: bool = False

    @classmethod
    def fast(cls, **changes) -> PathSettings:
        """Return the preset of RaytracedLighting: short paths, a strong firefly clamp, denoised."""
        return cls(**{"bounces": 3, "clamp": DEFAULT_WHITE, "regularization": 0.5, "denoise": True, **changes})


@dataclass(frozen=True)
class ToneSettings:
    """How `WarpRenderer.develop` denoises and tone-maps mean radiance [nits], in photographic terms."""

    enabled: bool = True  # False: LdrColor is exposed and clipped without the filmic curve
    film_iso: float = 100.0
    shutter: float = 50.0  # reciprocal exposure time [1/s]
    f_number: float = 5.0
    exposure_compensation: float = 0.0  # stops
    denoise: bool | None = None  # None: denoise if the film has feature buffers
    denoiser: str = "wavelet"  # or "oidn": Open Image Denoise, from the extra `usdsdg[denoise]`
    denoiser_blend: float = 0.0  # weight of the noisy image in the result: 0 = fully denoised, 1 = noisy

    @property
    def white(self) -> float:
        """Luminance that is shown as white [nits]; choose `PathSettings.clamp` as a multiple of it."""
        return 1.0 / self.exposure

    @property
    def exposure(self) -> float:
        """Factor from luminance [nits] to exposure, where 1 saturates a sensor of this ISO.

        EV100 = log2(N² / t * 100 / ISO), and the saturating luminance is 1.2 * 2^EV100 (ISO 12232; Lagarde and
        de Rousiers, "Moving Frostbite to PBR", 2014): 1500 nits for the defaults.
        """
        ev100 = math.log2(self.f_number**2 * self.shutter * 100.0 / self.film_iso)
        return 2.0**self.exposure_compensation / (1.2 * 2.0**ev100)
