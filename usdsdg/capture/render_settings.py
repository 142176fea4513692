"""Translate the `/rtx/...` settings into settings of the renderer for one frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from usdsdg.errors import warn_once
from usdsdg.graph.sampling import get_global_seed
from usdsdg.session.progress import say_once
from usdsdg.session.settings.store import captures_motion_blur, get_settings
from usdsdg_render.settings import PathSettings, ToneSettings

# Samples per pixel of the fast mode before it adds one per sub-frame; the denoiser needs a few.
MIN_SAMPLES = 4


@dataclass(frozen=True)
class RenderMode:
    """How one frame, or a subset of its samples, is rendered."""

    path_tracing: bool
    samples: int
    sub_frames: int
    motion_blur: bool
    denoise: bool
    first_sample: int = 0  # index of the first sample in the frame's sequence
    denoiser: str = "wavelet"
    denoiser_blend: float = 0.0  # weight of the noisy image, 0 = fully denoised

    def split(self, parts: int) -> list[RenderMode]:
        """Split the samples into consecutive parts, none empty; the first ones take the remainder."""
        parts = max(min(parts, self.samples), 1)
        base, extra = divmod(self.samples, parts)
        modes, first = [], self.first_sample
        for part in range(parts):
            samples = base + (part < extra)
            modes.append(replace(self, samples=samples, first_sample=first))
            first += samples
        return modes


def render_mode(rt_subframes: int) -> RenderMode:
    """Read the settings for the next frame.

    Path tracing takes `/rtx/pathtracing/totalSpp` samples per pixel, or `spp` where that is larger; with motion blur
    they are divided among the sub-frames. The fast modes take a few samples, one more per sub-frame, and filter them.
    """
    settings = get_settings()
    if _traces_paths():
        total = settings.get_as_int("/rtx/pathtracing/totalSpp")
        samples = max(total if total > 0 else settings.get_as_int("/rtx/pathtracing/spp"), 1)
        sub_frames = max(settings.get_as_int("/omni/replicator/pathTracedMotionBlurSubSamples"), 1)
        return _path_traced(samples, min(sub_frames, samples), captures_motion_blur())
    name = settings.get_as_string("/rtx/rendermode")
    if name not in ("RaytracedLighting", "RayTracedLighting", "RealTimePathTracing"):
        warn_once(
            f"/rtx/rendermode {name!r} is not known; using RaytracedLighting. Known: PathTracing, RaytracedLighting."
        )
    return _fast(rt_subframes)


def opens_shutter() -> bool:
    """Return whether the next frame shows motion while its shutter is open."""
    return _traces_paths() and captures_motion_blur()


def _traces_paths() -> bool:
    return get_settings().get_as_string("/rtx/rendermode") == "PathTracing"


def still_mode(samples: int | None) -> RenderMode:
    """Return how a picture beside the run is rendered: with so many path-traced samples, or in the fast mode."""
    return _fast(1) if samples is None else _path_traced(samples, 1, False)


def _path_traced(samples: int, sub_frames: int, blur: bool) -> RenderMode:
    denoise = get_settings().get_as_bool("/rtx/pathtracing/optixDenoiser/enabled")
    filtering = {"denoiser": _denoiser("oidn"), "denoiser_blend": _denoiser_blend()} if denoise else {}
    return RenderMode(True, samples, sub_frames, blur, denoise, **filtering)


def _fast(rt_subframes: int) -> RenderMode:
    return RenderMode(False, MIN_SAMPLES + rt_subframes, 1, False, True, denoiser=_denoiser("wavelet"))


def _denoiser(best: str) -> str:
    """Return the denoiser that `/usdsdg/denoiser` names; "auto" is `best` if that is installed and can run."""
    from usdsdg_render.path import oidn_denoiser

    name = get_settings().get_as_string("/usdsdg/denoiser") or "auto"
    if name not in ("auto", "wavelet", "oidn"):
        warn_once(f"/usdsdg/denoiser {name!r} is not known; using auto. Known: auto, wavelet, oidn.")
        name = "auto"
    if name != "auto":
        return name
    if best != "oidn" or (oidn_denoiser.is_installed() and not oidn_denoiser.lacks_sve()):
        return best
    if oidn_denoiser.lacks_sve():
        better = "Open Image Denoise, which cleans them, needs a processor with SVE on aarch64"
    else:
        better = "pip install 'usdsdg[denoise]' cleans them with Open Image Denoise"
    say_once(
        "path-traced images are cleaned by the filter of the fast mode, which leaves the noise of depth of field and "
        f"motion blur. {better}"
    )
    return "wavelet"


def _denoiser_blend() -> float:
    key = "/rtx/pathtracing/optixDenoiser/blendFactor"
    weight = get_settings().get_as_float(key)
    if not 0.0 <= weight <= 1.0:
        warn_once(
            f"{key} is {weight:g}; it may be 0 (all denoised) to 1 (not at all), and the nearer of them is taken."
        )
        return 1.0 if weight > 1.0 else 0.0
    return weight


def glass_labels() -> str:
    """Return what labels show at glass, from `/usdsdg/labels/glass`: its "surface", or what is "behind" it."""
    name = get_settings().get_as_string("/usdsdg/labels/glass") or "surface"
    if name not in ("surface", "behind"):
        warn_once(f"/usdsdg/labels/glass {name!r} is not known; using surface. Known: surface, behind.")
        return "surface"
    return name


def path_settings(mode: RenderMode, frame: int, *, with_light_aovs: bool) -> PathSettings:
    """Return the path tracer's settings for the samples of `mode`; `with_light_aovs` requests the light AOVs."""
    settings = get_settings()
    common: dict[str, Any] = {
        "seed": get_global_seed(), "frame": frame, "first_sample": mode.first_sample, "light_aovs": with_light_aovs,
        "glass_bounces": settings.get_as_int("/rtx/pathtracing/maxSpecularAndTransmissionBounces"),
    }  # fmt: skip
    if not mode.path_tracing:
        return PathSettings.fast(**common)
    return PathSettings(bounces=settings.get_as_int("/rtx/pathtracing/maxBounces"), denoise=mode.denoise, **common)


def tone_settings(mode: RenderMode) -> ToneSettings:
    """Return the settings of denoising and tone mapping."""
    settings = get_settings()
    return ToneSettings(
        film_iso=settings.get_as_float("/rtx/post/tonemap/filmIso"),
        shutter=settings.get_as_float("/rtx/post/tonemap/cameraShutter"),
        f_number=settings.get_as_float("/rtx/post/tonemap/fNumber"),
        denoise=mode.denoise,
        denoiser=mode.denoiser,
        denoiser_blend=mode.denoiser_blend,
    )
