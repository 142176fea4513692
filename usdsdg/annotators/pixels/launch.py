"""Launches of kernels over the pixels, rows or masks of an image, in bands over the threads of the process."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from usdsdg.parallel import available_threads, launch_rows

# Pixels that a thread takes at least: fewer cost more to hand out than they take.
BAND_PIXELS = 1 << 16
# Masks that a thread takes at a time.
MASKS = 64


def run(
    kernel: Any, shape: tuple[int, ...], inputs: Sequence[Any], outputs: Sequence[np.ndarray], *, band: int = 0
) -> None:
    """Run a kernel over `shape` on the CPU; arrays are wrapped as the kernel's types, and not copied if contiguous.

    The kernel's arguments are the inputs, the first index of a band along the first axis, and the outputs, which must
    be contiguous. band: indices of that axis that a thread takes at once; 0 for `band_of` them.
    """
    band = band or band_of(shape[0], int(np.prod(shape[1:])))
    types = [argument.type for argument in kernel.adj.args]
    given = [_wrapped(each, kind) for each, kind in zip(inputs, types[: len(inputs)], strict=True)]
    results = [_wrapped(each, kind) for each, kind in zip(outputs, types[len(inputs) + 1 :], strict=True)]
    launch_rows(kernel, shape, given, results, device="cpu", band_rows=band)


def band_of(count: int, pixels: int) -> int:
    """Return how many rows of so many pixels, of `count`, a thread takes at a time: as many as all others."""
    return max(-(-count // available_threads()), -(-BAND_PIXELS // max(pixels, 1)))


def _wrapped(value: Any, kind: Any) -> Any:
    """Return an array as a Warp array of the type of an argument, flat where that has one axis; other values as is."""
    if not isinstance(value, np.ndarray):
        return value
    import warp as wp

    value = np.ascontiguousarray(value)
    if kind.ndim == 1:
        value = value.reshape(-1, *getattr(kind.dtype, "_shape_", ()))
    return wp.array(value, dtype=kind.dtype, device="cpu", copy=False)
