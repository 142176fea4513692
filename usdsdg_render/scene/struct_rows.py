"""Rows of Warp structs, as NumPy fills them and as kernels read them."""

from functools import lru_cache
from typing import Any

import numpy as np
import warp as wp


@lru_cache(maxsize=64)
def _dtype(struct: Any) -> np.dtype:
    return np.dtype(struct.numpy_dtype())


def records(struct: Any, count: int) -> np.ndarray:
    """An array of zeroed rows with the memory layout of a Warp struct."""
    return np.zeros(count, _dtype(struct))


def uploaded(rows: np.ndarray, struct: Any, device: str) -> wp.array:
    """A copy of `records` on a device, in their shape.

    The same as wp.array(rows, dtype=struct), which looks up the struct's layout anew each time and takes far longer.
    """
    there = wp.empty(rows.shape, dtype=struct, device=device)
    if rows.size:
        here = wp.array(ptr=rows.ctypes.data, shape=rows.shape, dtype=struct, device="cpu", copy=False)
        wp.copy(there, here)
    return there
