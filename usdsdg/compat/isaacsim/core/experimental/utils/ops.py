"""`isaacsim.core.experimental.utils.ops`: Warp arrays from numbers, lists, NumPy and Warp arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.compat.wrappers.arrays import as_numpy, known_device
from usdsdg.warp_start import quiet_warp

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values


def parse_device(device: str | wp.Device | None, *, raise_on_invalid: bool = False) -> wp.Device:
    """Return Warp's device; its default one for None.

    Raises:
        ValueError: there is no such device, and `raise_on_invalid`.
    """
    quiet_warp()
    import warp as wp

    if device is None or isinstance(device, wp.Device):
        return wp.get_device() if device is None else device
    return wp.get_device(device if raise_on_invalid else known_device(str(device)))


def place(x: Values, *, dtype: type | None = None, device: str | wp.Device | None = None) -> wp.array:
    """Return a Warp array; one that has this type and device already is returned as it is."""
    quiet_warp()
    import warp as wp

    if isinstance(x, wp.array) and (dtype is None or x.dtype == dtype):
        return x if device is None else x.to(device)  # pyright: ignore[reportReturnType]
    array = np.atleast_1d(as_numpy(x))
    return wp.array(array if dtype is None else array.astype(wp.dtype_to_numpy(dtype)), device=device)


def resolve_indices(
    x: Indices, *, count: int | None = None, dtype: type | None = None, device: str | wp.Device | None = None
) -> wp.array:
    """Return indices (N,), int32; 0 to count - 1 for None.

    Raises:
        ValueError: neither indices nor `count` are given.
    """
    import warp as wp

    if x is None:
        if count is None:
            raise ValueError("resolve_indices: give x or count")
        x = np.arange(count)
    return place(np.ravel(as_numpy(x)), dtype=dtype or wp.int32, device=device)


def broadcast_to(
    x: Values, *, shape: Sequence[int], dtype: type | None = None, device: str | wp.Device | None = None
) -> wp.array:
    """Return a Warp array of this shape; rows and columns are repeated as in NumPy.

    Raises:
        ValueError: the numbers do not fit the shape.
    """
    return place(np.array(np.broadcast_to(as_numpy(x), tuple(shape))), dtype=dtype, device=device)
