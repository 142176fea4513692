"""Choices of a picture: how paths are traced, and how radiance becomes a displayable image."""

from __future__ import annotations

import math
from dataclasses import dataclass

# Luminance that the default exposure shows as white [nits]; clamps are multiples of it.
DEFAULT_WHITE = 1500.0
# Parts of the light in a picture, by what its first surface did with it; see `PathSettings.parts`.
PARTS = ("direct_diffuse", "direct_specular", "indirect_diffuse", "reflections", "refractions")


@dataclass(frozen=True)
class PathSettings:
    """How `WarpRenderer.accumulate` adds samples.

    A sample is a function of (seed, frame, pixel, sample index) alone. A picture of 64 samples is the same bit for bit
    in one call or in several that count on with `first_sample`.
    """

    bounces: int = 3  # surfaces that a path may meet: 1 = direct light only
    glass_bounces: int = 6  # faces of glass that it may meet besides
    seed: int = 0
    frame: int = 0
    first_sample: int = 0
    # Most that one contribution of light that has met two surfaces or more may add to a sample [nits]; 0 = no limit.
    clamp: float = 3.0 * DEFAULT_WHITE
    # Least GGX alpha of glossy surfaces seen by way of a rough one: removes caustics that few samples cannot resolve.
    regularization: float = 0.3
    # Sum what `develop(denoise=True)` needs as well.
    denoise: bool = False
    # Sum the PARTS as well. What a first surface scatters straight from lights, or from what glows, is
    # "direct_diffuse" or "direct_specular" (mirrored); what it scatters from other surfaces "indirect_diffuse" or
    # "reflections"; what comes through glass "refractions". The rest of a picture is what the first surface, a light
    # or the sky gives off itself.
    parts: bool = False

    @classmethod
    def fast(cls, **changes) -> PathSettings:
        """The RaytracedLighting preset: short paths, strongly clamped, made to be denoised."""
        return cls(**{"bounces": 3, "clamp": DEFAULT_WHITE, "regularization": 0.5, "denoise": True, **changes})


@dataclass(frozen=True)
class ToneSettings:
    """How `WarpRenderer.develop` turns mean radiance [nits] into colours, by photographic terms."""

    enabled: bool = True  # False: LdrColor is exposed and clipped, without the filmic curve
    film_iso: float = 100.0
    shutter: float = 50.0  # reciprocal exposure time [1/s]
    f_number: float = 5.0
    exposure_compensation: float = 0.0  # stops
    denoise: bool | None = None  # None: denoise when the film holds what it takes
    denoiser: str = "wavelet"  # that of the fast mode; or "oidn", Open Image Denoise of the extra `usdsdg[denoise]`
    noisy_share: float = 0.0  # of what the picture was before it was denoised: 0 = nothing, 1 = as if it was not

    @property
    def white(self) -> float:
        """Luminance that comes out as white [nits]; `PathSettings.clamp` wants to be a multiple of it."""
        return 1.0 / self.exposure

    @property
    def exposure(self) -> float:
        """Factor from nits to film: 1 is the brightest that a sensor of this ISO still tells from white.

        EV100 = log2(N² / t * 100 / ISO), and the saturating luminance is 1.2 * 2^EV100 (ISO 12232; Lagarde and
        de Rousiers, "Moving Frostbite to PBR", 2014): 1500 nits for the defaults.
        """
        ev100 = math.log2(self.f_number**2 * self.shutter * 100.0 / self.film_iso)
        return 2.0**self.exposure_compensation / (1.2 * 2.0**ev100)
