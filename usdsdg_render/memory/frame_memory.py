"""Memory of tables that are filled anew for each frame, and uploaded together."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from usdsdg_render.memory.staging_buffer import CACHE_LINE, aligned


class Table(NamedTuple):
    """One table: `count` rows, NumPy's type of a row, and Warp's; `shape` of a row that is an array."""

    count: int
    numpy: Any
    warp: Any
    shape: tuple[int, ...] = ()


class FrameMemory:
    """Tables on the host and their copies on a device; on a CPU both are the same memory.

    On CUDA the host has them twice, page-locked: while one is uploaded, the other one is filled.
    """

    def __init__(self, tables: Mapping[str, Table], device: str) -> None:
        self._tables = dict(tables)
        self._offsets: dict[str, int] = {}
        size = 0
        for name, table in self._tables.items():
            self._offsets[name] = size
            bytes_of_row = np.dtype(table.numpy).itemsize * int(np.prod(table.shape, dtype=np.int64))
            size += -(-table.count * bytes_of_row // CACHE_LINE) * CACHE_LINE
        self.bytes = size = max(size, CACHE_LINE)
        if device == "cpu":
            self._host = [aligned((size,), np.uint8)]
            self._device = wp.array(self._host[0], dtype=wp.uint8, device="cpu", copy=False)
            self._sources: list[wp.array] = []
        else:
            self._sources = [wp.empty(size, dtype=wp.uint8, device="cpu", pinned=True) for _ in range(2)]
            self._host = [source.numpy() for source in self._sources]
            self._device = wp.empty(size, dtype=wp.uint8, device=device)
            self._events = [wp.Event(device) for _ in range(2)]
        self.turn = 0  # which of the host's tables are filled now

    def begin(self) -> None:
        """Begin to fill the tables: of the last frame but one on CUDA, of the last one on a CPU."""
        if self._sources:
            self.turn = 1 - self.turn
            wp.synchronize_event(self._events[self.turn])

    def host(self, name: str) -> np.ndarray:
        """Return a table as it is to be filled: an array of its rows."""
        table = self._tables[name]
        dtype = np.dtype(table.numpy)
        count = table.count * int(np.prod(table.shape, dtype=np.int64))
        start = self._offsets[name]
        bytes_ = self._host[self.turn][start : start + count * dtype.itemsize]
        return bytes_.view(dtype).reshape(table.count, *table.shape)

    def address(self, name: str) -> int:
        """Return the address of a table on the device."""
        assert self._device.ptr is not None
        return int(self._device.ptr) + self._offsets[name]

    def device(self, name: str) -> wp.array:
        """Return the rows of a table on the device; valid as long as this object lives."""
        table = self._tables[name]
        return wp.array(ptr=self.address(name), shape=(table.count,), dtype=table.warp, device=self._device.device)

    def upload(self) -> None:
        """Copy all tables to the device."""
        if self._sources:
            wp.copy(self._device, self._sources[self.turn])
            wp.record_event(self._events[self.turn])
