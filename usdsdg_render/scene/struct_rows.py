"""Arrays of Warp structs: filled by NumPy on the host, read by kernels on the device."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import warp as wp


@lru_cache(maxsize=64)
def dtype_of(struct: Any) -> np.dtype:
    """Return NumPy's type of a row with the memory layout of a Warp struct."""
    return np.dtype(struct.numpy_dtype())


def records(struct: Any, count: int) -> np.ndarray:
    """Return an array of zeroed rows with the memory layout of a Warp struct."""
    return np.zeros(count, dtype_of(struct))


def records_of(values: Sequence[Any], struct: Any) -> np.ndarray:
    """Return records with what instances of a Warp struct hold."""
    rows = records(struct, len(values))
    for k, value in enumerate(values):
        rows[k] = value.numpy_value()
    return rows


def copy_rows(target: np.ndarray, source: np.ndarray) -> None:
    """Copy rows of one type as bytes: NumPy copies records field by field."""
    whole = f"V{target.dtype.itemsize}"
    assert target.dtype == source.dtype
    target.view(whole)[:] = source.view(whole)


def uploaded(rows: np.ndarray, struct: Any, device: str, *, into: wp.array | None = None) -> wp.array:
    """Copy an array of `records` to a device, with the same shape; `into` an earlier result, if that has this shape.

    Equals wp.array(rows, dtype=struct), which is far slower because it derives the layout of the struct each time.
    """
    if rows.dtype.itemsize != dtype_of(struct).itemsize or not rows.flags.c_contiguous:
        # Such as by `np.concatenate`, which leaves out padding.
        raise ValueError(f"rows of {rows.dtype.itemsize} bytes do not have the memory layout of {struct.key}")
    target = into
    if target is None or target.shape != rows.shape:
        target = wp.empty(rows.shape, dtype=struct, device=device)
    if rows.size:
        source = wp.array(ptr=rows.ctypes.data, shape=rows.shape, dtype=struct, device="cpu", copy=False)
        wp.copy(target, source)
    return target
