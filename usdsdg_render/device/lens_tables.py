"""Lens tables on devices, uploaded once and kept for the lifetime of the lens."""

from weakref import WeakKeyDictionary

import numpy as np
import warp as wp

from usdsdg.stage.cameras.lens_tables import LensTable

_uploaded: WeakKeyDictionary[LensTable, dict[str, wp.array]] = WeakKeyDictionary()


def table_address(table: LensTable, device: str) -> int:
    """Return the device address of a table, in the layout of `kernels.cameras.lens_table`."""
    held = _uploaded.setdefault(table, {})
    if device not in held:
        starts = np.zeros((table.start_map.shape[0] * table.start_map.shape[1], 4), np.float32)
        starts[:, :2] = table.start_map.reshape(-1, 2)
        rows = np.concatenate([table.texels.reshape(-1, 4), starts])
        held[device] = wp.array(rows, dtype=wp.vec4, device=device)
    address = held[device].ptr
    assert address is not None
    return address
