"""Arrays of annotators as Warp arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from usdsdg.annotators.augmentations.warp_kernel import device_or_cpu

if TYPE_CHECKING:
    import warp as wp


def on_device(data: np.ndarray, device: str) -> wp.array | np.ndarray:
    """Return a copy of `data` as a Warp array on `device`, on the CPU if there is no such device.

    As in Replicator, ids are int32 in Warp arrays; they stay below 2³¹. Structured arrays stay NumPy arrays, since Warp
    has none.
    """
    import warp as wp

    if data.dtype.names is not None:
        return data.copy()
    return wp.array(data.view(np.int32) if data.dtype == np.uint32 else data, device=device_or_cpu(device))
