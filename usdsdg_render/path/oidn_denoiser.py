"""Denoising of a film by Intel's Open Image Denoise, which the extra `usdsdg[denoise]` installs.

Albedo and normal guide the filter. Both are prefiltered, each by a network of its own, because depth of field and
motion blur make them as noisy as the radiance.
"""

import atexit
import ctypes
import importlib.util
import platform
import sys
import threading
from functools import lru_cache
from typing import Any

import numpy as np
import warp as wp

from usdsdg.errors import RenderError
from usdsdg.parallel import available_threads, cheap_rows, launch_rows
from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.kernels.path.wavelet_denoiser import BLOCK_PIXELS, average_with_margin, block_luminance

MIDDLE_GRAY = 0.18
# Border of mirrored pixels: the networks assume black outside of the image, which darkens its last pixels.
MARGIN = 8
# Blocks of pixels below this luminance are ignored in the estimate of exposure [nits].
BLACK = 1.0e-8
# getauxval key of the processor features of Linux on aarch64, and the bit of SVE.
_HWCAP, _SVE = 16, 1 << 22

# The networks of `_filters` serve one image at a time.
_busy = threading.Lock()


def is_installed() -> bool:
    """Whether the extra is installed."""
    return importlib.util.find_spec("mitsuba_oidn") is not None


@lru_cache(maxsize=1)
def lacks_sve() -> bool:
    """Whether the library would crash this process: its build for Linux on aarch64 requires SVE (0.1.2)."""
    if sys.platform != "linux" or platform.machine() != "aarch64":
        return False
    value_of = ctypes.CDLL(None).getauxval
    value_of.argtypes, value_of.restype = [ctypes.c_ulong], ctypes.c_ulong
    return not value_of(_HWCAP) & _SVE


def denoise(film: FilmArrays, device: str, *, threads: int | None = None) -> wp.array:
    """Denoise the film's mean radiance, on its CUDA device if the library supports that, else on the CPU.

    Args:
        film: sums with feature buffers.

    Returns:
        (height, width) vec4: radiance [nits], and 1 as the number of samples.

    Raises:
        RenderError: the extra is not installed, or does not run here.
    """
    target = _oidn_device(device)
    height, width = film.color.shape
    shape = (height + 2 * MARGIN, width + 2 * MARGIN)
    color = wp.empty(shape, dtype=wp.vec4, device=target)
    albedo, normal = (wp.empty(shape, dtype=wp.vec3, device=target) for _ in range(2))
    sums = [each.to(target) for each in (film.color, film.background, film.albedo, film.normal_depth)]
    rows, outputs = cheap_rows(shape[1]), [color, albedo, normal]
    launch_rows(average_with_margin, shape, [*sums, MARGIN], outputs, device=target, threads=threads, band_rows=rows)
    scale = _input_scale(color, threads)
    with _busy:
        filters = _filters(shape, target, threads or available_threads())
        for name, image in (("albedo", albedo), ("normal", normal)):
            _run(filters[name], {name: image}, image)
        filters["color"].input_scale = scale
        _run(filters["color"], {"color": color, "albedo": albedo, "normal": normal}, color)
    inside: Any = color[MARGIN:-MARGIN, MARGIN:-MARGIN]
    return inside.contiguous().to(device)


def library() -> Any:
    """Import the Python binding of Open Image Denoise.

    Raises:
        RenderError: the extra is not installed, or the system lacks a library or the processor SVE.
    """
    if lacks_sve():
        raise RenderError(
            "Open Image Denoise's build for aarch64 needs a processor with SVE, which this one is not: set the "
            "denoiser (/usdsdg/denoiser) to 'wavelet'."
        )
    try:
        import mitsuba_oidn
    except ImportError as error:
        raise RenderError(
            f"Open Image Denoise cannot be loaded ({error}): pip install 'usdsdg[denoise]', or set the denoiser "
            "(/usdsdg/denoiser) to 'wavelet'."
        ) from error
    except RuntimeError as error:
        raise RenderError(
            f"Open Image Denoise is installed but cannot be loaded ({error}). On Linux it needs the system's libatomic "
            "(libatomic1 in Debian and Ubuntu); install that, or set the denoiser (/usdsdg/denoiser) to 'wavelet'."
        ) from error
    return mitsuba_oidn


def _oidn_device(device: str) -> str:
    oidn = library()
    on_cuda = any(each.type is oidn.DeviceType.CUDA for each in oidn.physical_devices())
    return device if on_cuda else "cpu"


@lru_cache(maxsize=4)
def _filters(shape: tuple[int, int], target: str, threads: int) -> dict[str, Any]:
    """Return the networks for one image size; cached because setup takes longer than execution."""
    oidn = library()
    if target == "cpu":
        device = oidn.Device(oidn.DeviceType.CPU)
        device.num_threads = threads
    else:
        device = oidn.Device.cuda(wp.get_device(target).ordinal, wp.get_stream(target).cuda_stream)
    filters = {name: device.new_filter("RT") for name in ("albedo", "normal", "color")}
    # Higher quality of the prefiltered guides does not change the result.
    filters["albedo"].quality = filters["normal"].quality = oidn.Quality.Fast
    filters["color"].quality = oidn.Quality.High
    filters["color"].hdr = True
    filters["color"].clean_aux = True
    return filters


# Networks alive at interpreter shutdown are reported as leaks.
atexit.register(_filters.cache_clear)


def _run(network: Any, inputs: dict[str, wp.array], output: wp.array) -> None:
    for name, image in inputs.items():
        network.set_image(name, image)
    network.set_image("output", output)
    network.execute()


def _input_scale(color: wp.array, threads: int | None) -> float:
    """Return the input scale that maps the image's log-average luminance to middle gray, as the networks expect.

    The library's own estimate depends on the number of threads in the last digits.
    """
    rows, columns = (-(-length // BLOCK_PIXELS) for length in color.shape)
    means = wp.empty((rows, columns), dtype=wp.float32, device=color.device)
    launch_rows(block_luminance, (rows, columns), [color], [means], device=str(color.device), threads=threads)
    lit = means.numpy().astype(np.float64)
    lit = lit[lit > BLACK]
    return float(MIDDLE_GRAY / np.exp2(np.log2(lit).mean())) if lit.size else 1.0
