"""From the `/rtx/...` settings to what one capture asks of the renderer."""

from __future__ import annotations

from dataclasses import dataclass, replace

from usdsdg.errors import warn_once
from usdsdg.session.settings_store import get_settings

# Samples per pixel of the fast mode: enough for the filter to work with, and one more for every sub-frame.
LEAST_SAMPLES = 4


@dataclass(frozen=True)
class RenderMode:
    """How one frame is drawn. `first_sample` is where this sub-frame's samples begin in the frame's sequence."""

    path_tracing: bool
    samples: int
    sub_frames: int
    motion_blur: bool
    denoise: bool
    first_sample: int = 0
    denoiser: str = "wavelet"
    denoiser_blend: float = 0.0  # weight of the noisy image, 0 = fully denoised

    def split(self, parts: int) -> list[RenderMode]:
        """The samples in `parts` shares that follow each other, the first ones taking the remainder; none is empty."""
        parts = max(min(parts, self.samples), 1)
        base, extra = divmod(self.samples, parts)
        shares, first = [], self.first_sample
        for part in range(parts):
            samples = base + (part < extra)
            shares.append(replace(self, samples=samples, first_sample=first))
            first += samples
        return shares


def render_mode(rt_subframes: int) -> RenderMode:
    """Read the settings for the next frame.

    Path tracing takes `/rtx/pathtracing/totalSpp` samples per pixel, or `spp` where that is larger; with motion blur
    they are spread over the sub-frames. The fast modes take a few samples, one more per sub-frame, and filter them.
    """
    settings = get_settings()
    name = settings.get_as_string("/rtx/rendermode")
    if name == "PathTracing":
        total = settings.get_as_int("/rtx/pathtracing/totalSpp")
        samples = max(total if total > 0 else settings.get_as_int("/rtx/pathtracing/spp"), 1)
        sub_frames = max(settings.get_as_int("/omni/replicator/pathTracedMotionBlurSubSamples"), 1)
        blur = settings.get_as_bool("/omni/replicator/captureMotionBlur")
        denoise = settings.get_as_bool("/rtx/pathtracing/optixDenoiser/enabled")
        filtering = {"denoiser": _denoiser("oidn"), "denoiser_blend": _denoiser_blend()} if denoise else {}
        return RenderMode(True, samples, min(sub_frames, samples), blur, denoise, **filtering)
    if name not in ("RaytracedLighting", "RayTracedLighting", "RealTimePathTracing"):
        warn_once(
            f"/rtx/rendermode {name!r} is not known; using RaytracedLighting. Known: PathTracing, RaytracedLighting."
        )
    return RenderMode(False, LEAST_SAMPLES + rt_subframes, 1, False, True, denoiser=_denoiser("wavelet"))


def _denoiser(best: str) -> str:
    """What filters pictures, by `/usdsdg/denoiser`; "auto" is `best` where that is installed and can run."""
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
    warn_once(
        "path-traced pictures are cleaned by the filter of the fast mode, which leaves the noise of depth of field and "
        f"motion blur. {better}; with the setting /usdsdg/denoiser at 'wavelet' this filter stays and this line goes."
    )
    return "wavelet"


def _denoiser_blend() -> float:
    key = "/rtx/pathtracing/optixDenoiser/blendFactor"
    share = get_settings().get_as_float(key)
    if not 0.0 <= share <= 1.0:
        warn_once(f"{key} is {share:g}; it may be 0 (all denoised) to 1 (not at all), and the nearer of them is taken.")
        return 1.0 if share > 1.0 else 0.0
    return share


def glass_labels() -> str:
    """What labels show where glass is, by `/usdsdg/labels/glass`: its "surface", or what is "behind" it."""
    name = get_settings().get_as_string("/usdsdg/labels/glass") or "surface"
    if name not in ("surface", "behind"):
        warn_once(f"/usdsdg/labels/glass {name!r} is not known; using surface. Known: surface, behind.")
        return "surface"
    return name
