"""Intel's Open Image Denoise over a film's radiance: networks that the extra `usdsdg[denoise]` installs.

Albedo and normal guide the filter. They are cleaned first, each by a network of its own, because depth of field and
motion blur make them as noisy as the light.
"""

from __future__ import annotations

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
from usdsdg_render.device.parallel import available_threads, launch_rows
from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.kernels.path.wavelet_denoiser import LEVEL_PIXELS, average, levels

MIDDLE_GREY = 0.18
# Pixels that are mirrored around a picture: the networks take what lies outside for black, which darkens the last ones.
MARGIN = 8
# Below this a block of pixels is black and says nothing of how bright a picture is [nits].
BLACK = 1.0e-8
# Where Linux on aarch64 tells what the processor has: the key of the list of features, and the bit of SVE in it.
_HWCAP, _SVE = 16, 1 << 22

# The networks of `_filters` belong to one picture at a time.
_busy = threading.Lock()


def is_installed() -> bool:
    """Whether the extra is there."""
    return importlib.util.find_spec("mitsuba_oidn") is not None


@lru_cache(maxsize=1)
def lacks_sve() -> bool:
    """Whether the library would end this process: its build for Linux on aarch64 takes SVE for granted (0.1.2)."""
    if sys.platform != "linux" or platform.machine() != "aarch64":
        return False
    value_of = ctypes.CDLL(None).getauxval
    value_of.argtypes, value_of.restype = [ctypes.c_ulong], ctypes.c_ulong
    return not value_of(_HWCAP) & _SVE


def denoise(film: FilmArrays, device: str, *, threads: int | None = None) -> wp.array:
    """The film's mean radiance, filtered: on its CUDA device where the library has a part for it, else on the CPU.

    Args:
        film: sums with features.

    Returns:
        (height, width) vec4: radiance [nits], and 1 as the number of samples.

    Raises:
        RenderError: the extra is not installed, or does not run here.
    """
    place = _place(device)
    height, width = film.color.shape
    shape = (height + 2 * MARGIN, width + 2 * MARGIN)
    color = wp.empty(shape, dtype=wp.vec4, device=place)
    albedo, normal = (wp.empty(shape, dtype=wp.vec3, device=place) for _ in range(2))
    sums = [each.to(place) for each in (film.color, film.background, film.albedo, film.normal_depth)]
    launch_rows(average, shape, [*sums, MARGIN], [color, albedo, normal], device=place, threads=threads)
    scale = _input_scale(color, threads)
    with _busy:
        filters = _filters(shape, place, threads or available_threads())
        for name, picture in (("albedo", albedo), ("normal", normal)):
            _run(filters[name], {name: picture}, picture)
        filters["color"].input_scale = scale
        _run(filters["color"], {"color": color, "albedo": albedo, "normal": normal}, color)
    inside: Any = color[MARGIN:-MARGIN, MARGIN:-MARGIN]
    return inside.contiguous().to(device)


def library() -> Any:
    """The binding of Open Image Denoise, loaded.

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
            f"Open Image Denoise is installed but cannot be loaded ({error}). On aarch64 it needs the system's "
            "libatomic (libatomic1 in Debian and Ubuntu); install that, or set the denoiser "
            "(/usdsdg/denoiser) to 'wavelet'."
        ) from error
    return mitsuba_oidn


def _place(device: str) -> str:
    oidn = library()
    on_cuda = any(each.type is oidn.DeviceType.CUDA for each in oidn.physical_devices())
    return device if on_cuda else "cpu"


@lru_cache(maxsize=4)
def _filters(shape: tuple[int, int], place: str, threads: int) -> dict[str, Any]:
    """Networks for pictures of one size; setting them up takes longer than running them."""
    oidn = library()
    if place == "cpu":
        device = oidn.Device(oidn.DeviceType.CPU)
        device.num_threads = threads
    else:
        device = oidn.Device.cuda(wp.get_device(place).ordinal, wp.get_stream(place).cuda_stream)
    filters = {name: device.new_filter("RT") for name in ("albedo", "normal", "color")}
    # Guides that a better network has cleaned make the same picture.
    filters["albedo"].quality = filters["normal"].quality = oidn.Quality.Fast
    filters["color"].quality = oidn.Quality.High
    filters["color"].hdr = True
    filters["color"].clean_aux = True
    return filters


# Networks that the interpreter's end finds alive are reported as leaks.
atexit.register(_filters.cache_clear)


def _run(network: Any, inputs: dict[str, wp.array], output: wp.array) -> None:
    for name, picture in inputs.items():
        network.set_image(name, picture)
    network.set_image("output", output)
    network.execute()


def _input_scale(color: wp.array, threads: int | None) -> float:
    """The factor that makes a picture's typical level a middle grey, which the networks are at their best with.

    The library would choose much the same, but in the last digits it would depend on the number of threads.
    """
    rows, columns = (-(-length // LEVEL_PIXELS) for length in color.shape)
    means = wp.empty((rows, columns), dtype=wp.float32, device=color.device)
    launch_rows(levels, (rows, columns), [color], [means], device=color.device.alias, threads=threads)
    bright = means.numpy().astype(np.float64)
    bright = bright[bright > BLACK]
    return float(MIDDLE_GREY / np.exp2(np.log2(bright).mean())) if bright.size else 1.0
