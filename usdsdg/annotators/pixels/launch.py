"""Launches of kernels over the pixels, rows or masks of an image, on the device where the image is.

Images are NumPy arrays in the memory of the host, or Warp arrays on a device; results are what the image is. On a CPU,
kernels run in bands over the threads of the process, on CUDA in one launch.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from usdsdg import buffers
from usdsdg.parallel import available_threads, launch_rows
from usdsdg.readback import read_back

if TYPE_CHECKING:
    import warp as wp

# Images as annotators have them: np.ndarray (H, W, *channels), or wp.array (H, W) of numbers or vectors. To a type
# checker the two have little in common.
Pixels: TypeAlias = Any

# Pixels that a thread takes at least: to hand out fewer takes longer than most kernels need for them.
BAND_PIXELS = 1 << 18
# Pixels that a thread of a CPU goes through in one call of a kernel that takes their number.
RUN_PIXELS = 1 << 12
# Masks that a thread takes at a time.
MASKS = 64


def new(shape: tuple[int, ...], dtype: Any, like: Pixels) -> Pixels:
    """Return an array of undefined values for a kernel to fill, where the image `like` is."""
    if isinstance(like, np.ndarray):
        return buffers.empty(shape, dtype)
    import warp as wp

    number: Any = wp.dtype_from_numpy(np.dtype(dtype))  # Warp declares `dtype: type[float]`
    return wp.empty(shape, dtype=number, device=like.device)


def placed(table: np.ndarray, like: Pixels) -> Pixels:
    """Return a table that a kernel updates, where the image `like` is."""
    if isinstance(like, np.ndarray):
        return table
    import warp as wp

    return wp.array(table, dtype=wp.dtype_from_numpy(table.dtype), device=like.device)


def on_host(image: Pixels) -> np.ndarray:
    """Return an image in the memory of the host; only that of a GPU is copied."""
    return image if isinstance(image, np.ndarray) else read_back({"image": image})["image"]


def is_image(value: Any) -> bool:
    """Return whether a value is an array of NumPy or Warp, which need not be imported for that."""
    return hasattr(type(value), "__dlpack__")


def channels_of(image: Pixels) -> int:
    """Return the number of channels of an image, 1 for one of numbers."""
    if isinstance(image, np.ndarray):
        return image.shape[2] if image.ndim > 2 else 1
    return (*image.shape[2:], *getattr(image.dtype, "_shape_", ()), 1)[0]


def run(
    kernel: Any, shape: tuple[int, ...], inputs: Sequence[Any], outputs: Sequence[Pixels], *, band: int = 0
) -> None:
    """Run a kernel over `shape` where its outputs are; arrays there are viewed as the kernel's types, others copied.

    The kernel's arguments are the inputs, the first index of a band along the first axis, and the outputs, which must
    be contiguous. band: indices of that axis that a thread takes at once; 0 for `band_of` them.
    """
    device = "cpu" if isinstance(outputs[0], np.ndarray) else str(outputs[0].device)
    band = band or band_of(shape[0], prod(shape[1:]))
    types = [argument.type for argument in kernel.adj.args]
    given = [_on_device(each, kind, device) for each, kind in zip(inputs, types[: len(inputs)], strict=True)]
    results = [_on_device(each, kind, device) for each, kind in zip(outputs, types[len(inputs) + 1 :], strict=True)]
    launch_rows(kernel, shape, given, results, device=device, band_rows=band)


def run_over_pixels(kernel: Any, count: int, inputs: Sequence[Any], outputs: Sequence[Pixels]) -> None:
    """Run a kernel over the pixels of images; its argument after the inputs is how many each of its threads takes."""
    pixels = RUN_PIXELS if isinstance(outputs[0], np.ndarray) or outputs[0].device.is_cpu else 1
    threads = -(-count // pixels)
    run(kernel, (threads,), [*inputs, pixels], outputs, band=band_of(threads, pixels))


def band_of(count: int, pixels: int) -> int:
    """Return how many rows of so many pixels, of `count`, a thread takes at a time: as many as all others."""
    bands = min(available_threads(), max(count * pixels // BAND_PIXELS, 1))
    return -(-count // bands) or 1


def viewed(array: wp.array, dtype: Any, shape: tuple[int, ...], *, offset: int = 0) -> wp.array:
    """Return the memory of a contiguous array, from an offset [bytes] on, as another type and shape."""
    import warp as wp

    start = None if array.ptr is None else array.ptr + offset
    view = wp.array(ptr=start, shape=shape, dtype=dtype, device=array.device, copy=False)
    view._ref = array  # as Warp's own views keep their memory
    return view


def in_a_row(images: Sequence[Pixels]) -> Pixels | None:
    """Return images of one size on a GPU as one image, (N * H, W), if each begins where the one before it ends."""
    first = images[0]
    if any(isinstance(each, np.ndarray) or not each.is_contiguous for each in images):
        return None
    import warp as wp

    size = first.size * wp.types.type_size_in_bytes(first.dtype)
    if any(each.ptr != first.ptr + k * size or each.device != first.device for k, each in enumerate(images)):
        return None
    whole = viewed(first, first.dtype, (len(images) * first.shape[0], *first.shape[1:]))
    whole._ref = tuple(images)
    return whole


def pieces(whole: wp.array, count: int) -> list[wp.array]:
    """Return so many equal pieces of a contiguous array along its first axis, which share its memory."""
    import warp as wp

    shape = (whole.shape[0] // count, *whole.shape[1:])
    size = prod(shape) * wp.types.type_size_in_bytes(whole.dtype)
    return [viewed(whole, whole.dtype, shape, offset=k * size) for k in range(count)]


def _on_device(value: Any, kind: Any, device: str) -> Any:
    """Return an array as a Warp array of the type of an argument, flat where that has one axis; other values as is."""
    import warp as wp

    if isinstance(value, wp.array):
        items = value.size * wp.types.type_size_in_bytes(value.dtype) // wp.types.type_size_in_bytes(kind.dtype)
        return viewed(value, kind.dtype, value.shape[: kind.ndim] if kind.ndim > 1 else (items,))
    if not isinstance(value, np.ndarray):
        return value
    value = np.ascontiguousarray(value)
    if kind.ndim == 1:
        value = value.reshape(-1, *getattr(kind.dtype, "_shape_", ()))
    return wp.array(value, dtype=kind.dtype, device=device, copy=False)
